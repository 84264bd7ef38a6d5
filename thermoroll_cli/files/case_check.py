"""From parsed TOML to valid settings, with all errors of the case at once, and suggestions of what was meant."""

from __future__ import annotations

import difflib
import itertools
import math
import os
import re
from collections.abc import Callable, Collection, Iterable
from dataclasses import replace
from functools import cached_property
from typing import Any, NamedTuple, get_args

from pydantic import ValidationError
from pydantic.fields import FieldInfo

from thermoroll_cli.files import case_model as model
from thermoroll_cli.files.case_conflicts import conflicts, heat_is_on
from thermoroll_cli.files.case_errors import CaseError, Finding, KeyPath
from thermoroll_cli.files.case_history import HistoryTable, extremes
from thermoroll_cli.files.case_line import LOAD, PRESSURE
from thermoroll_cli.files.case_model import EXCLUSIVE, Settings
from thermoroll_cli.files.case_problem import problem_of
from thermoroll_cli.files.case_schema import Entry, allowed_values, entry_at, is_table, known_keys, known_words
from thermoroll_cli.files.case_source import CaseSource, key_path
from thermoroll_cli.files.case_surface import SurfaceTable, body_at, reading_of
from thermoroll_cli.files.case_table import UNIT_AT_END, Table, quantity_of
from thermoroll_cli.files.case_wheelset import OutlineTable, SliceTable
from thermoroll_cli.files.column_files import FromFile, read_history, read_positions, read_series
from thermoroll_cli.files.csv_table import TableError
from thermoroll_cli.files.profile_file import SLICES, Reading, SliceFile, read_outline, read_profile, read_slices
from thermoroll_cli.files.spellings import factor_of, meant, unit_in
from thermoroll_cli.files.surface_file import MEASURED_IN
from thermoroll_cli.one_contact.steady_state.derived import derived_of
from thermoroll_cli.one_contact.steady_state.solvable import passes, reasons_against
from thermoroll_cli.problem.geometry import Unsolvable
from thermoroll_cli.problem.kinds import Kind, every_kind, kind_in
from thermoroll_cli.problem.names import unit_of
from thermoroll_cli.problem.problem import BODIES, STANDARD_ACCURACY, Problem


class Checked(NamedTuple):
    """What is known of a valid case: its `settings`, the `readings` of its files by the keys of their tables, and the `problem`
    that it describes of one contact."""

    settings: Settings
    readings: dict[str, Reading | FromFile]
    problem: Problem


class Source(NamedTuple):
    """A `key` of a `table` that names a file, which has the `content` of another key; `allowed` if the key does not say it."""

    table: type[Table]
    key: str
    content: str
    read: Callable[..., Any]
    allowed: str = ""


SOURCES = (
    Source(model.ProfileTable, "file", "points_mm", read_profile,
           "a text file with two columns, y and height in mm, y increasing; or a .prr, .prw, .ban or .whl file"),
    Source(OutlineTable, "file", "points_mm", read_outline),
    Source(model.MaterialConstants, "relaxation_file", "relaxation", read_series,
           "a text file with the columns frequency_Hz, storage_GPa, loss_GPa"),
    Source(model.WearTable, "positions_file", "positions", read_positions),
    Source(HistoryTable, "file", "values", read_history,
           "a CSV file with the columns distance_mm or time_s and keys that change, names in its first line"),
)  # fmt: skip

READ_BY = ("side",)
OF_A_FILE = ("unit", "height_unit", *READ_BY)
"""Keys of the table of a profile that say how its file is read: the points that come from it are in mm, of one side."""

_MESSAGES = {
    "float_type": "must be a number",
    "int_type": "must be a whole number",
    "list_type": "must be a list",
    "dict_type": "must be a table",
    "too_short": "is empty",
    "too_long": "has too many entries",
    "model_type": "must be a table",
    "bool_type": "must be true or false",
    "string_type": "must be text in quotes",
    "string_too_long": "is too long",
    "literal_error": "is not a known word",
    "less_than_equal": "is above the allowed range",
}
"""Kinds of pydantic's errors, in our words."""


def validate(source: CaseSource) -> Checked:
    """The settings of a case with all defaults filled in, and what follows from them. Raises CaseError with all errors of the
    case."""
    checker = _Checker(source)
    settings = checker.settings()
    return Checked(settings, checker.readings, checker.problem(settings))


class _Checker:
    def __init__(self, source: CaseSource) -> None:
        self.source = source
        self.content = source.content
        self.findings: list[Finding] = []
        self.sections: dict[str, Any] = {}
        self.readings: dict[str, Reading | FromFile] = {}

    def settings(self) -> Settings:
        self._unknown_in((), (key for key in self.content if key not in Settings.model_fields))
        self._table((), model.Head, {"title": self.content.get("title", "")})
        for name, field in Settings.model_fields.items():
            if name == "load":
                self._kind_of_case()
            if name == "rolling":
                self._rolling_speed()
            if name not in model.Head.model_fields:
                self._section(name, field)
        self._exclusive()
        long = self.source.get(key_path(LOAD)) is not None
        for body in BODIES if isinstance(self.content.get("geometry"), dict) and not long else ():
            # Across rolling each body has a radius, or a profile.
            key, profile, given = f"{body}_radius_y_mm", f"{body}_profile", self.content["geometry"]
            if not self._has(("geometry",), given, key, profile):
                allowed = f"{allowed_values(('geometry', key))}; or a table [geometry.{profile}]"
                hint = f"of a line contact whose load is a pressure, inf for both; with {LOAD} they may be left out" if (
                    self.source.get(key_path(PRESSURE)) is not None) else ""
                self._note(("geometry", key), "is missing", allowed=allowed, hint=hint, at_key=True)
        self._conflicts()
        history = self.sections.get("history")
        varied = {} if history is None else history.values
        for override in self.source.overrides:
            if ".".join(map(str, override.path)) in varied:
                self._note(override.path, "changes over time as history.values says", allowed="another key", at_key=True)
        self._raise()
        if history is not None:
            self._without_zeros(varied)
            self._over_time(history)
        sections = dict(self.sections)
        if sections["thermal"] is None:
            sections["thermal"] = model.ThermalTable(heat=heat_is_on(sections))
        numerics, creepage, force = sections["numerics"], sections["creepage"], sections["force"]
        if numerics.grid is None and numerics.accuracy is None:
            sections["numerics"] = numerics.model_copy(update={"accuracy": STANDARD_ACCURACY})
        for way in () if "creepage" in self.kind.follows else ("longitudinal", "lateral"):
            given = any(getattr(force, key) is not None or f"force.{key}" in varied for key in (f"{way}_N", f"{way}_N_mm"))
            if getattr(creepage, way) is None and not given:
                creepage = creepage.model_copy(update={way: 0.0})
        # Every part of it has been checked.
        return Settings.model_construct(title=self.content.get("title", ""), **sections | {"creepage": creepage})

    def problem(self, settings: Settings) -> Problem:
        """The problem that valid settings describe. Raises CaseError with every reason against it."""
        reasons = list[Unsolvable]()
        try:
            problem = problem_of(settings)
            derived = derived_of(problem)
            reasons += () if passes(derived) else reasons_against(derived)
        except Unsolvable as cause:  # there is no problem to ask
            reasons.append(cause)
        for reason in reasons:
            path = key_path(reason.other)
            # The constants of one body, or of both.
            line = self.source.line_of(path) or self.source.line_of(tuple(part for part in path if part not in BODIES))
            self._note(key_path(reason.key), str(reason) + line, allowed=reason.allowed)
        self._raise()
        return problem

    def _exclusive(self) -> None:
        for first, second, allowed in EXCLUSIVE:
            path, given = key_path(first), self.source.get(key_path(second))
            if given is not None and self.source.get(path) is not None:
                message = f"cannot be given together with {first}{self.source.line_of(path)}"
                self._note(key_path(second), message, allowed=allowed, at_key=isinstance(given, dict))

    def _conflicts(self) -> None:
        for conflict in conflicts(self.sections, self.kind):
            self._note(conflict.path, conflict.message + self.source.line_of(conflict.other), allowed=conflict.allowed,
                       hint=conflict.hint, at_key=conflict.at_key)

    def _without_zeros(self, varied: Collection[str]) -> None:
        """Leave out creepages of 0 beside forces over time: cases that older versions resolved have such ones written."""
        given = self.sections["creepage"]
        zero = [way for way in ("longitudinal", "lateral") if getattr(given, way) == 0.0
                and any(f"force.{way}_{unit}" in varied for unit in ("N", "N_mm"))]
        if zero:
            self.sections["creepage"] = given.model_copy(update=dict.fromkeys(zero))
            left = {key: value for key, value in self.content["creepage"].items() if key not in zero}
            self.content = {**self.content, "creepage": left}
            self.source = replace(self.source, content=self.content)

    def _over_time(self, history: HistoryTable) -> None:
        """The case as it is at some places of its history, by the rules of all others. Raises CaseError."""
        for number, values in extremes(history).items():
            place = f"{self.source.name}: history.values, number {number + 1}"
            content = dict(self.content)
            tables = dict.fromkeys(key.partition(".")[0] for key in values)
            content |= {table: dict(content.get(table, {})) for table in tables}
            for key, value in values.items():
                table, _, name = key.partition(".")
                content[table][name] = value
            here = _Checker(replace(self.source, content=content, located=False))
            here.sections = dict(self.sections)
            for table in tables:
                here._section(table, Settings.model_fields[table])
            here._exclusive()
            if not here.findings:
                here._conflicts()
            self.findings += [replace(found, source=place) for found in here.findings]
            self._raise()

    def _raise(self) -> None:
        if self.findings:
            raise CaseError(self.findings)

    def _section(self, name: str, field: FieldInfo) -> None:
        given = self.content.get(name)
        if isinstance(given, dict):
            kind = next(kind for kind in (field.annotation, *get_args(field.annotation)) if isinstance(kind, type))
            valid = self._material(given) if name == "material" else self._table((name,), kind, given)
            valid = valid and self._with_files((name,), valid)
            if valid is not None:
                self.sections[name] = valid
        elif name in self.content:
            self._note((name,), "must be a table", allowed=f"a table [{name}]", hint=_missing_table(name, field))
        elif name == "load" and self.kind.without_load in self.content:
            self.sections[name] = model.LoadTable()
        elif not field.is_required():
            # Some tables mean something by not being there.
            self.sections[name] = None if name in ("thermal", "subsurface") else field.get_default(call_default_factory=True)
        elif name not in self._meant((), self.content):
            self._note((name,), f"the table [{name}] is missing", hint=_missing_table(name, field))

    def _material(self, given: dict[str, Any]) -> Table | None:
        own = [body for body in BODIES if body in given]
        if not own:
            return self._table(("material",), model.MaterialTable, given)
        allowed = "constants in [material] for both bodies, or in [material.lower] and [material.upper]"
        constants = {key: value for key, value in given.items() if key not in BODIES}
        only_layers = all(isinstance(given[body], dict) and given[body].keys() == {"layers"} for body in own)
        if constants and "layers" not in constants and only_layers:
            # Both bodies are of one material and differ in their coatings alone.
            if self._table(("material",), model.MaterialTable, constants) is None:
                return None
            return self._table(("material",), model.TwoMaterials, {body: constants | given.get(body, {}) for body in BODIES})
        if shared := [key for key in given if key in model.MaterialTable.model_fields]:
            message = f"constants of both bodies ({', '.join(shared)}) cannot be given together with [material.{own[0]}]"
            self._note(("material", own[0]), message, allowed=allowed, at_key=True)
            # As long as this error remains, it is not known whether the constants of each body are complete.
            self._unknown_in(("material",), (key for key in given if key not in (*shared, *BODIES)))
            return None
        missing = [body for body in BODIES if body not in given]
        for body in missing:
            message = "is missing: the other body has its own material"
            self._note(("material", body), message, allowed=allowed, at_key=True)
        return self._table(("material",), model.TwoMaterials, given, ignored=missing)

    def _with_files(self, path: KeyPath, table: Table) -> Table | None:
        """`table`, and those in it, with the content of the files that they name; None where a file has none."""
        changes: dict[str, Any] = {}
        for key, value in table:
            if isinstance(value, Table):
                changes[key] = self._with_files((*path, key), value)
            elif isinstance(value, list) and value and isinstance(value[0], Table):
                own = [self._with_files((*path, key, number), each) for number, each in enumerate(value)]
                changes[key] = None if None in own else own
        failed = None in changes.values()
        if isinstance(table, HistoryTable) and table.begin and table.begin.endswith(".h5"):
            # The state before may be found later than the case is checked.
            changes["begin"] = os.path.abspath(os.path.join(os.path.dirname(self.source.name), table.begin))
        if isinstance(table, SurfaceTable) and table.file is not None and table.kind is None:
            # Its heights are too many for the text of a case.
            table = table.model_copy(update={"file": os.path.abspath(
                os.path.join(os.path.dirname(self.source.name), table.file))})
            try:
                found = reading_of(table, body_at(path)).checksum
            except (ValueError, OSError) as fault:
                self._note((*path, "file"), str(fault), allowed=MEASURED_IN, hint=getattr(fault, "hint", ""))
                return None
            if table.checksum not in (None, found):
                self._note((*path, "checksum"), f"{table.file} has changed: it has {found}", allowed="that, or none")
            return table.model_copy(update={"checksum": found})
        if isinstance(table, OutlineTable) and (slices := self._slices(path, table)) is not None:
            changes |= slices
            failed = failed or not slices
            table = table.model_copy(update={"file": None})
        for source in (source for source in SOURCES if isinstance(table, source.table)):
            named, place = getattr(table, source.key), (*path, source.key)
            of_file = {key: getattr(table, key) for key in OF_A_FILE if getattr(table, key, None) is not None}
            if named is None or getattr(table, source.content):
                for key in of_file if not changes.get("sections") else ():
                    self._note((*path, key), "is about a file, and there is none", allowed="file beside it", at_key=True)
                continue
            if isinstance(named, model.RelaxationFile):
                named, place = named.file, (*place, "file")
            try:
                of_both = {key: of_file[key] for key in of_file if key in READ_BY}
                read = source.read(os.path.join(os.path.dirname(self.source.name), named), **of_both)
            except (ValueError, OSError) as fault:
                self._note(place, str(fault), allowed=source.allowed or allowed_values(place), hint=getattr(fault, "hint", ""))
                return None
            if not isinstance(read, list):
                if isinstance(read, Reading):
                    read = read.in_units(of_file.get("unit"), of_file.get("height_unit"))
                self.readings[".".join(map(str, place[:-1]))] = read
                read = read.content
            content = read if isinstance(read, dict) else {source.content: read}
            changes |= {**dict.fromkeys(of_file), source.key: None, **content}
        return None if failed else table.model_copy(update=changes) if changes else table

    def _slices(self, path: KeyPath, table: OutlineTable) -> dict[str, Any] | None:
        """Changes of the table of an outline whose slices are read from files; empty where one cannot be, None where it has
        none."""
        folder, named = os.path.dirname(self.source.name), table.file or ""
        listed = named.lower().endswith(SLICES)
        if not (listed or table.slices) or table.sections or table.points_mm:
            return None
        place, wheel, sections, first = (*path, "file" if listed else "slices"), path[0] == "wheelset", [], None
        try:
            if listed and named.lower().endswith(SLICES[1]) != wheel:
                raise TableError(f"{named} has slices {'around a wheel' if not wheel else 'along a track'}")
            files, control = read_slices(os.path.join(folder, named)) if listed else ([
                SliceFile(at, file, []) for at, file in table.slices or ()
                if isinstance(at, float | int) and isinstance(file, str)], False)
            if len(files) < len(table.slices or ()):
                raise TableError("a slice is a pair of its place, a number, and the name of its file")
            folder = os.path.dirname(os.path.join(folder, named)) if listed else folder
            if any(second.at <= before.at for before, second in itertools.pairwise(files)):
                raise TableError("places of slices do not increase")
            for each in files:
                read = read_outline(os.path.join(folder, each.file), table.side).in_units(table.unit, table.height_unit)
                first = first or read
                sections.append(SliceTable(at=each.at, points_mm=read.content, features_mm=each.features or None))
        except (ValueError, OSError) as fault:
            self._note(place, str(fault), allowed=allowed_values(place), hint=getattr(fault, "hint", ""))
            return {}
        assert first is not None
        unit = "degrees" if wheel else "mm"
        note = f"the first of {len(files)} slices from {files[0].at:.6g} to {files[-1].at:.6g} {unit}"
        self.readings[".".join(map(str, path))] = replace(first, note=", ".join(filter(None, (first.note, note))))
        if table.control_points is not None:
            control = table.control_points
        return {**dict.fromkeys(OF_A_FILE), "file": None, "slices": None, "sections": sections,
                "control_points": control or None}

    @cached_property
    def kind(self) -> Kind:
        """What the case asks for, also by misspelt tables."""
        return kind_in(self._given)

    @property
    def _given(self) -> set[str]:
        return {*self.content, *self._meant((), self.content)}

    def _kind_of_case(self) -> None:
        """Tables and keys that a case of its kind must have, and those that it cannot have."""
        others = "".join(f"; or {' and '.join(f'[{table}]' for table in kind.needs or kind.tables)}"
                         for kind in reversed(every_kind()) if kind.tables and kind.base and not self.kind.tables)
        for table in self.kind.needs:
            if table not in self._given:
                self._note((table,), f"the table [{table}] is missing", hint=f"add {', '.join(known_keys((table,)))}{others}")
        for table, keys in self.kind.one_of.items():
            given = self.content.get(table)
            if isinstance(given, dict) and not self._has((table,), given, *keys):
                self._note((table, keys[0]), "is missing", allowed=allowed_values((table, keys[0])), at_key=True)
        why, allowed = self.kind.refusal
        for path in map(key_path, self.kind.refused):
            if self.source.get(path) is not None:
                self._note(path, f"cannot be given together with {why}", allowed=allowed, at_key=True)

    def _rolling_speed(self) -> None:
        if not self.kind.rolls:
            return
        rolling, path = self.content.get("rolling"), ("rolling", "speed_m_s")
        if "rolling" not in self._given:
            self._note(("rolling",), "the table [rolling] is missing", hint=f"add {', '.join(known_keys(('rolling',)))}")
        elif isinstance(rolling, dict) and not self._has(("rolling",), rolling, "speed_m_s"):
            self._note(path, "is missing", allowed=allowed_values(path), at_key=True)

    def _table(self, path: KeyPath, kind: type[Table], given: dict[str, Any], ignored: Iterable[str] = ()) -> Table | None:
        """The table of `given`, or None where it has errors, which are noted; but not those of keys that are `ignored`."""
        try:
            return kind.model_validate(given)
        except ValidationError as cause:
            seen: set[KeyPath] = {(*path, key) for key in ignored}
            for error in cause.errors(include_url=False):  # a value that fits none of several types has one error for each
                place = _place((*path, error["loc"][0]), error["loc"][1:])
                if place in seen:
                    continue
                seen.add(place)
                if error["type"] == "extra_forbidden":
                    self._unknown_in(place[:-1], place[-1:])
                elif error["type"] != "missing":
                    entry = entry_at(place)
                    self._note(place, _message(error, entry), allowed=allowed_values(place),
                               hint=_value_hint(error["input"], entry))
                elif place[-1] not in self._meant(place[:-1], error["input"]):
                    # A misspelt key is one error, not two.
                    self._note(place, "is missing", allowed=allowed_values(place), at_key=True)
        return None

    def _has(self, table: KeyPath, given: dict[str, Any], *keys: str) -> bool:
        """Whether one of the `keys` of `table` is given, perhaps misspelt."""
        return bool({*keys} & {*given} or {*keys} & self._meant(table, given))

    def _meant(self, table: KeyPath, given: dict[str, Any]) -> set[str]:
        """Keys of `table` that are missing only because they are misspelt."""
        known = known_keys(table)
        return {_same_quantity(key, known) or meant(key).rpartition(".")[2] or _nearest(key, known)
                for key in given if key not in known}

    def _unknown_in(self, table: KeyPath, keys: Iterable[str | int]) -> None:
        for key in keys:
            self._note((*table, key), "unknown key", hint=_unknown_key(table, str(key)), at_key=True)

    def _note(self, path: KeyPath, message: str, **details: Any) -> None:
        # A table alone stands for a list of one.
        path = tuple(part for place, part in enumerate(path)
                     if not (part == 0 and isinstance(self.source.get(path[:place]), dict)))
        self.findings.append(self.source.finding(path, message, **details))

def _place(path: KeyPath, location: tuple[Any, ...]) -> KeyPath:
    """The path of the key that an error at `location` behind `path` is about: no entry of a list, no alternative of a type."""
    for part in location:
        if not is_table(entry_at(path)):
            break
        path = (*path, part)
    return path


def _message(error: Any, entry: Entry) -> str:
    kind, value = error["type"], error["input"]
    if isinstance(value, float) and math.isnan(value) and not is_table(entry):
        return "nan is not a number"
    if kind == "finite_number" or (kind == "float_type" and type(value) is int):  # an integer no float can hold
        return "must be finite"
    if kind == "greater_than_equal":
        return "must be greater than 0" if error["ctx"]["ge"] > 0 >= value else "is below the allowed range"
    if kind == "greater_than":
        return f"must be greater than {error['ctx']['gt']:g}"
    if kind in ("float_type", "bool_type") and known_words(entry):
        return f"{_MESSAGES[kind].replace(' or ', ', ')} or a known word"
    return str(_MESSAGES.get(kind, error["msg"]))


def _value_hint(value: Any, entry: Entry) -> str:
    """Help for a text that is not allowed: the nearest known word, or how a number is written."""
    if not isinstance(value, str):
        return ""
    if near := _nearest(value, known_words(entry)):
        return f'did you mean "{near}"?'
    if is_table(entry) or "string" in (entry.get("type"), entry.get("items", {}).get("type")):
        return ""
    if re.fullmatch(r"\s*[-+]?\d+,\d+\s*", value):
        return "a number is written with a point and without quotes: 0.5"
    if value.strip().lower() in ("true", "false"):
        return "true and false are written without quotes"
    try:
        float(value)
    except ValueError:
        return ""
    return "a number is written without quotes"


def _unknown_key(table: KeyPath, key: str) -> str:
    """Help for `key`, which `table` does not have."""
    known = known_keys(table)
    unit = UNIT_AT_END.search(key)
    same = _same_quantity(key, known)
    elsewhere = [name for name in Settings.model_fields if key in known_keys((name,)) and name != (*table, "")[0]]
    if elsewhere and (unit or not same):
        return f"{key} belongs in [{elsewhere[0]}]"
    if same:
        wanted = UNIT_AT_END.search(same)
        given = f"not {unit.group()[1:]}" if unit else "which is missing here"
        return (f'did you mean "{same}"? The unit is part of the key: {wanted.group()[1:] if wanted else "none"}, {given}'
                f"{_conversion(key, same)}")
    if other := meant(key):
        own = other.rpartition(".")[2]
        return f'did you mean "{own if own in known else other}"?{_conversion(key, other)}'
    if not table and (inside := next((f"{name}.{found}" for name in Settings.model_fields
                                      if (found := _same_quantity(key, known_keys((name,))))), "")):
        return f'did you mean "{inside}"?'
    near = _nearest(key, known)
    return f'did you mean "{near}"?' if near else f"known here: {', '.join(known)}"


def _conversion(written: str, own: str) -> str:
    """What one of the unit of a key as somebody has `written` it is in that of the key `own`."""
    unit, wanted = unit_in(written), unit_of(own)
    factor = factor_of(unit, wanted)
    return f" (1 {unit} is {f'{factor:.6g} {wanted}'.rstrip()})" if unit and factor not in (None, 1.0) else ""


def _missing_table(name: str, field: FieldInfo) -> str:
    """The keys that a missing table would have."""
    if name == "material":
        return "add youngs_modulus_GPa and poisson_ratio, or the tables [material.lower] and [material.upper]"
    return f"add {', '.join(known_keys((name,)))}" if field.is_required() else ""


def _same_quantity(key: str, known: Collection[str]) -> str:
    """The known key that differs from `key` in its unit only; "" where one differs in capitals alone."""
    wanted = quantity_of(key).lower()
    alike = {name.lower(): name for name in known if quantity_of(name).lower() == wanted}
    return "" if key.lower() in alike else next(iter(alike.values()), "")


def _nearest(word: str, known: Iterable[str]) -> str:
    lowered = {name.lower(): name for name in known}
    near = difflib.get_close_matches(word.lower()[:200], lowered, n=1, cutoff=0.6)
    return lowered[near[0]] if near else ""
