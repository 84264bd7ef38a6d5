"""Case files: TOML text in, a checked case and the problem that it describes out."""

from __future__ import annotations

import contextlib
import html
import json
import math
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from operator import attrgetter
from typing import Any

import tomli_w

from thermoroll_cli.files import case_model as model
from thermoroll_cli.files.case_check import validate
from thermoroll_cli.files.case_errors import CaseError, Finding
from thermoroll_cli.files.case_source import (
    CaseSource,
    Override,
    apply_overrides,
    case_name,
    key_path,
    parse_source,
    read_source,
)
from thermoroll_cli.files.case_surface import MadeSurface, shown_surfaces
from thermoroll_cli.files.column_files import FromFile
from thermoroll_cli.files.profile_file import Reading
from thermoroll_cli.files.surface_file import MeasuredSurface
from thermoroll_cli.problem import problem as si
from thermoroll_cli.problem.geometry import Unsolvable
from thermoroll_cli.problem.kinds import Task

__all__ = ["Case", "CaseError", "Finding", "Override", "case_name", "solvable"]

INFINITE = ("geometry", "track")
"""Tables with radii that may be infinite, which JSON does not know."""


@dataclass(frozen=True)
class Case:
    """A valid case. Cases are equal if their settings are.

    Attributes:

    - `name`: begins the names of its result files;
    - `text`: the TOML text that it comes from;
    - `settings`: the tables of the case file in the units of their keys, with all defaults filled in;
    - `readings`: how the profiles that the text names as files were read, by the keys of their tables;
    - `described`: the problem of one contact in SI units; of an assembly what its contacts have in common.
    """

    name: str = field(compare=False)
    text: str = field(compare=False)
    settings: model.Settings
    readings: Mapping[str, Reading | FromFile] = field(compare=False)
    described: si.Problem = field(compare=False)

    @classmethod
    def read(cls, path: str | os.PathLike[str], overrides: Sequence[Override] = ()) -> Case:
        """Read a case file.

        Parameters:

        - `path`: the TOML file; "-" is standard input;
        - `overrides`: values of keys, as of `--set`.

        Raises CaseError, with all errors of the case, if it is missing, unreadable or invalid.
        """
        return cls.from_source(read_source(path, overrides), case_name(path))

    @classmethod
    def parse(cls, text: str, *, name: str = "case", overrides: Sequence[Override] = ()) -> Case:
        """The case that a TOML text describes.

        Parameters:

        - `text`: the content of a case file;
        - `name`: of result files and in messages; profiles that the text names are read from its folder;
        - `overrides`: as of `read`.

        Raises CaseError with all errors of the case.
        """
        return cls.from_source(parse_source(text, name, overrides), name)

    @classmethod
    def from_dict(cls, content: Mapping[str, Any], *, name: str = "case") -> Case:
        """The case of tables and keys as in a case file.

        Parameters:

        - `content`: for example `{"load": {"normal_N": 65.0, …}, …}`, in the units of the keys; values may be NumPy's, and None
          is a key left out; files that it names are read from the current folder;
        - `name`: of result files.

        Raises CaseError with all errors of the case.
        """
        given = _plain(content)
        return cls(name, tomli_w.dumps(given), *validate(CaseSource("from_dict", "", given, located=False)))

    @classmethod
    def from_json(cls, text: str, *, name: str = "case") -> Case:
        """The case that `to_json` wrote.

        Parameters:

        - `text`: strict JSON, as in `Result.case_json`;
        - `name`: as of `parse`.

        Raises CaseError if the text is no case or an invalid one.
        """
        try:
            content = json.loads(text)
            for radii in (table for table in INFINITE if table in content):
                content[radii] = {key: math.inf if value == "inf" else value for key, value in content[radii].items()}
            written = tomli_w.dumps(content)
        except (ValueError, KeyError, TypeError, AttributeError):
            raise CaseError([Finding("no resolved case in it", source=name)]) from None
        return cls.parse(written, name=name)

    @classmethod
    def of(cls, case: Case | Mapping[str, Any] | str | os.PathLike[str]) -> Case:
        """The case of any of these.

        Parameters:

        - `case`: a `Case`, which is returned; the path of a case file; or a mapping as of `from_dict`.

        Raises CaseError, and TypeError for something else.
        """
        if isinstance(case, Case):
            return case
        if not isinstance(case, Mapping | str | os.PathLike):
            raise TypeError(f"a case is a Case, the path of a file, or a mapping of tables, not {type(case).__name__}")
        return cls.from_dict(case) if isinstance(case, Mapping) else cls.read(case)

    @classmethod
    def from_source(cls, source: CaseSource, name: str) -> Case:
        """The case of a text that is parsed already. Raises CaseError."""
        return cls(name, source.text, *validate(source))

    def with_values(self, values: Mapping[str, Any]) -> Case:
        """This case with other values of some keys.

        Parameters:

        - `values`: by dotted key, in the units of the keys: `{"rolling.speed_m_s": 2.0}`. If two keys exclude each other (a
          creepage and a force) the new one replaces the old.

        Raises CaseError with all errors of the new case; this one does not change.
        """
        content = self._content()
        overrides = [Override(key_path(key), _plain(value), f"{key}={value}", "with_values") for key, value in values.items()]
        apply_overrides(content, overrides)
        source = CaseSource(self.name, self.text, content, tuple(overrides), located=False)
        settings, read, described = validate(source)
        kept = {key: reading for key, reading in self.readings.items()
                if not {f"{key}.points_mm", key.removesuffix("_file")} & {*values}
                and not any(key.startswith(f"{changed}.") for changed in values)}
        return replace(self, settings=settings, readings={**kept, **read}, described=described)

    @property
    def plots(self) -> str:
        """Which pictures the case asks for: "all", "summary" or "none"."""
        asked = self.settings.output.plots
        return asked if isinstance(asked, str) else "all" if asked else "none"

    @property
    def problem(self) -> si.Problem:
        """The problem of one contact in SI units. Raises Unsolvable for an assembly, which has several: see `task`."""
        self.settings.kind.check_one_contact()
        return self.described

    @property
    def task(self) -> Task:
        """The problem in SI units, of any kind: one contact, a wheelset, a ball bearing, … A result file that a history begins
        with is read now."""
        task: Task = self.settings.kind.task(self.settings, self.described)
        return task

    @property
    def inputs(self) -> tuple[Input, ...]:
        """All keys that have a value, in their own units and in SI."""
        return tuple(inputs(self.settings))

    @property
    def profiles(self) -> dict[str, dict[str, Any]]:
        """How each profile file was read, by the key of its table: file, format, unit, points, ranges, signs, flange."""
        records = {}
        for key, reading in self.readings.items():
            if isinstance(reading, Reading):
                table = attrgetter(key)(self.settings)
                records[key] = reading.record(mirror=table.mirror, flip=table.flip, wheel=key.startswith("wheelset."))
            else:
                records[key] = reading.record()
        return records

    @property
    def surfaces(self) -> dict[str, MadeSurface | MeasuredSurface]:
        """How surfaces were made or read, by the keys of their tables."""
        return shown_surfaces(dict(self.settings))

    def to_toml(self) -> str:
        """The text of a case file that gives the same case again, with all defaults filled in."""
        return tomli_w.dumps(self._content())

    def to_json(self) -> str:
        """The case as strict JSON with all defaults filled in; infinite radii are "inf"."""
        content = self._content()
        for name in (name for name in INFINITE if name in content):
            content[name] = {key: "inf" if value == math.inf else value for key, value in content[name].items()}
        return json.dumps(content, ensure_ascii=False, allow_nan=False)

    def __hash__(self) -> int:
        return hash(self.to_json())

    def __repr__(self) -> str:
        title = f": {self.settings.title}" if self.settings.title else ""
        return f"<Case {self.name}{title}>"

    def _repr_html_(self) -> str:
        """A table of the inputs, for notebooks."""
        rows = "".join(
            f"<tr><td>{html.escape(item.key)}</td><td>{html.escape(shown(item.value))}</td><td>{html.escape(item.shown_si)}</td></tr>"
            for item in self.inputs if item.key != "title")  # fmt: skip
        title = html.escape(f"{self.name}: {self.settings.title}" if self.settings.title else self.name)
        return f"<table><caption>{title}</caption><tr><th>key</th><th>value</th><th>in SI</th></tr>{rows}</table>"

    def _content(self) -> dict[str, Any]:
        content = self.settings.model_dump(exclude_none=True)
        if isinstance(content["numerics"].get("grid"), tuple):
            content["numerics"]["grid"] = list(content["numerics"]["grid"])
        # The creepages of an assembly follow from its motion; their defaults are none of its keys.
        follow = self.settings.kind.follows
        # The load of a wheelset is empty where its friction has places.
        return {key: value for key, value in content.items() if (value not in ("", {}) or key == "load") and key not in follow}


@contextlib.contextmanager
def solvable(case: Case, source: str) -> Iterator[None]:
    """Inside, a valid `case`, read from `source`, that turns out to be unsolvable raises CaseError."""
    try:
        yield
    except Unsolvable as cause:
        finding = CaseSource(source, case.text, {}).finding(key_path(cause.key), str(cause), allowed=cause.allowed, at_key=True)
        raise CaseError([finding]) from None


@dataclass(frozen=True)
class Input:
    """A key with its `value` in the unit of the key, and in SI: `si` is None if it is no number, `unit` may be empty."""

    key: str
    value: Any
    si: float | None
    unit: str

    @property
    def shown_si(self) -> str:
        """The value in SI units, where those say more than the number alone."""
        return f"{self.si:.6g} {self.unit}" if self.si is not None and self.unit else ""


def inputs(table: model.Table, prefix: str = "") -> Iterator[Input]:
    """All keys of a case that have a value, in the order of the tables."""
    for name, value in table:
        key = prefix + name
        if isinstance(value, model.Table):
            yield from inputs(value, f"{key}.")
        elif isinstance(value, list) and value and isinstance(value[0], model.Table):
            for number, item in enumerate(value):
                yield from inputs(item, f"{key}.{number}.")
        elif isinstance(value, int | float) and not isinstance(value, bool):
            yield Input(key, value, float(table.si(name)), table.si_unit(name)[0])
        elif value is not None and value != "":
            yield Input(key, value, None, "")


def shown(value: Any) -> str:
    """A value in the unit of its key, as text."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, list | tuple):
        return f"{len(value)} values" if len(value) > 2 else "×".join(map(shown, value))
    if isinstance(value, Mapping):
        return ", ".join(f"{key} ({shown(inner)})" for key, inner in value.items())
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _plain(value: Any) -> Any:
    """`value` with Python's numbers and lists for NumPy's, and without None."""
    if isinstance(value, Mapping):
        return {str(key): _plain(inner) for key, inner in value.items() if inner is not None}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return value.tolist() if hasattr(value, "tolist") else value
