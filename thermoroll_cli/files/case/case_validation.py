"""From parsed TOML to valid settings, with every error of the case found in one go."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator
from typing import Any

from pydantic import ValidationError

from thermoroll_cli.files.case.allowed_values import allowed_values, nested_table
from thermoroll_cli.files.case.case_checks import conflicts, heat_is_on
from thermoroll_cli.files.case.case_errors import CaseError, Finding
from thermoroll_cli.files.case.case_hints import known_keys, meant_key, missing_table, misspelt_word, unknown_key, wrong_type
from thermoroll_cli.files.case.case_model import (
    PROFILES,
    REQUIRED_SECTIONS,
    SECTIONS,
    GeometryTable,
    Head,
    MaterialTable,
    ProfileTable,
    Settings,
    Table,
    ThermalTable,
    TwoMaterials,
)
from thermoroll_cli.files.case.case_source import CaseSource
from thermoroll_cli.files.case.profile_checks import profile_faults, touching
from thermoroll_cli.files.case.profile_file import ProfileError, read_profile
from thermoroll_cli.files.case.toml_positions import KeyPath
from thermoroll_cli.problem.problem import STANDARD_ACCURACY

LEFT_OUT_MATTERS = ("thermal", "subsurface")
"""Tables that mean something by not being there."""

WORDS = {
    "peclet": ("rolling", "sliding", "stationary"),
    "partition": ("matched",),
    "deformation": ("always",),
    "bodies": ("lower", "upper"),
    "fields": ("plane", "von_mises", "full"),
    "kind": ("logarithmic",),
    "interpolation": ("cubic", "linear"),
}
"""Known words of the keys that take some."""


def validate(source: CaseSource) -> Settings:
    """The settings of a case with all defaults filled in. Raises CaseError with all errors of the case."""
    checker = _Checker(source)
    return checker.settings()


class _Checker:
    def __init__(self, source: CaseSource) -> None:
        self.source = source
        self.findings: list[Finding] = []
        self.sections: dict[str, Any] = {}

    def settings(self) -> Settings:
        content = self.source.content
        for key in content.keys() - {"title", "material", *SECTIONS}:
            self._unknown((key,))
        title = content.get("title", "")
        self._material()
        for name, model in SECTIONS.items():
            self._section(name, model)
        self._title(title)
        for conflict in conflicts(self.sections):
            also = self.source.line_of(conflict.other) if conflict.other else ""
            self._note(conflict.path, conflict.message + also, allowed=conflict.allowed, hint=conflict.hint)
        if self.findings:
            raise CaseError(self.findings)
        settings = self._resolved(title)
        if (fault := touching(settings)) is not None:
            self._note(("geometry", fault.key), fault.message, allowed=fault.allowed, hint=fault.hint, at_key=True)
            raise CaseError(self.findings)
        return settings

    def _title(self, title: Any) -> None:
        for error in _errors_of(Head, {"title": title}):
            self._invalid_value((), Head, error)

    def _material(self) -> None:
        given = self._given_table("material", required=True)
        if given is None:
            return
        if not {"lower", "upper"} & given.keys():
            self.sections["material"] = self._table(("material",), MaterialTable, given)
        else:
            self._two_materials(given)
        if self.sections.get("material") is None:
            self.sections.pop("material", None)

    def _two_materials(self, given: dict[str, Any]) -> None:
        allowed = "constants in [material] for both bodies, or in [material.lower] and [material.upper]"
        for key in given.keys() - {"lower", "upper", *MaterialTable.model_fields}:
            self._unknown(("material", key))
        shared = [key for key in given if key in MaterialTable.model_fields]
        if shared:
            own = next(body for body in ("lower", "upper") if body in given)
            message = f"constants of both bodies ({', '.join(shared)}) cannot be given together with [material.{own}]"
            self._note(("material", own), message, allowed=allowed, at_key=True)
            # Whether what each body has is complete cannot be told before this is decided.
            return
        bodies = {}
        for body in ("lower", "upper"):
            path = ("material", body)
            if body not in given:
                self._note(path, "is missing: the other body has its own material", allowed=allowed, at_key=True)
            elif not isinstance(given[body], dict):
                self._note(path, "must be a table", allowed=f"a table [material.{body}]")
            else:
                bodies[body] = self._table(path, MaterialTable, given[body])
        if len(bodies) == 2 and all(bodies.values()):
            self.sections["material"] = TwoMaterials.model_construct(**bodies)

    def _section(self, name: str, model: type[Table]) -> None:
        required = name in REQUIRED_SECTIONS
        if name not in self.source.content and not required:
            self.sections[name] = None if name in LEFT_OUT_MATTERS else model.model_construct()
            return
        given = self._given_table(name, required=required)
        if given is not None and name == "geometry":
            self._geometry(given)
            return
        valid = None if given is None else self._table((name,), model, given)
        if valid is not None:
            self.sections[name] = valid

    def _geometry(self, given: dict[str, Any]) -> None:
        """[geometry] with the tables of profiles in it."""
        count = len(self.findings)
        tables = {body: given[body] for body in PROFILES if body in given}
        profiles = {body: self._profile(("geometry", body), table) for body, table in tables.items()}
        radii = self._table(("geometry",), GeometryTable, {key: value for key, value in given.items() if key not in tables})
        for body in ("lower", "upper"):
            key, profile = f"{body}_radius_y_mm", f"{body}_profile"
            if profile in given and key in given:
                self._note(("geometry", profile), f"cannot be given together with geometry.{key}"
                           + self.source.line_of(("geometry", key)), allowed="a lateral radius or a profile", at_key=True)
            elif profile not in given and key not in given and key not in self._meant("geometry", given):
                self._note(("geometry", key), "is missing", allowed=f"{allowed_values(GeometryTable, key)}; or a table "
                           f"[geometry.{profile}]", at_key=True)
        if radii is not None and len(self.findings) == count:
            self.sections["geometry"] = radii.model_copy(update=profiles)

    def _profile(self, path: KeyPath, given: Any) -> ProfileTable | None:
        """One profile, its file replaced by the points in it."""
        if not isinstance(given, dict):
            self._note(path, "must be a table", allowed=allowed_values(GeometryTable, str(path[-1])))
            return None
        table: ProfileTable | None = self._table(path, ProfileTable, given)
        if table is None:
            return None
        for fault in profile_faults(table):
            self._note((*path, fault.key) if fault.key else path, fault.message, allowed=fault.allowed, at_key=not fault.key)
            return None
        if table.file is None:
            return table
        try:
            points = read_profile(os.path.join(os.path.dirname(self.source.name), table.file))
        except ProfileError as fault:
            self._note((*path, "file"), str(fault), allowed="a text file with two columns, y and height in mm, y increasing")
            return None
        return table.model_copy(update={"points_mm": points, "file": None})

    def _given_table(self, name: str, *, required: bool) -> dict[str, Any] | None:
        given = self.source.content.get(name)
        if isinstance(given, dict):
            return given

        hint = missing_table(name)
        if name in self.source.content:
            self._note((name,), "must be a table", allowed=f"a table [{name}]", hint=hint)
        elif required and name not in self._meant("", self.source.content):
            self._note((name,), f"the table [{name}] is missing", hint=hint)
        return None

    def _table(self, path: KeyPath, model: type[Table], given: dict[str, Any]) -> Any:
        errors = _errors_of(model, given)
        if not errors:
            return model.model_validate(given)
        meant = self._meant(".".join(str(part) for part in path), given)
        for error in errors:
            # A misspelt key is one error, not two.
            if not (error["type"] == "missing" and error["loc"][0] in meant):
                self._invalid_value(path, model, error)
        return None

    def _meant(self, table: str, given: dict[str, Any]) -> set[str]:
        """Keys that are missing only because they are misspelt."""

        known = known_keys(table)
        return {meant_key(table, key) for key in given if key not in known}

    def _invalid_value(self, table: KeyPath, model: type[Table], error: Any) -> None:

        table, model, key = _place(table, model, error["loc"])
        value, path = error["input"], (*table, key)
        if error["type"] == "extra_forbidden":
            self._unknown(path)
        elif error["type"] == "missing":
            self._note(path, "is missing", allowed=allowed_values(model, key), at_key=True)
        else:
            words = WORDS.get(key, ())
            hint = misspelt_word(value, words)
            if not hint and key not in ("title", "peclet", "kind", "interpolation", "file", "points_mm"):
                hint = wrong_type(value)
            self._note(path, _message(error), allowed=allowed_values(model, key), hint=hint)

    def _unknown(self, path: KeyPath) -> None:

        hint = unknown_key(".".join(str(part) for part in path[:-1]), str(path[-1]))
        self._note(path, "unknown key", hint=hint, at_key=True)

    def _note(self, path: KeyPath, message: str, **details: Any) -> None:
        self.findings.append(self.source.finding(path, message, **details))

    def _resolved(self, title: str) -> Settings:
        """The settings with what is left out decided: nothing depends on defaults any more."""
        sections = dict(self.sections)
        if sections["thermal"] is None:
            sections["thermal"] = ThermalTable(heat=heat_is_on(sections))
        numerics, creepage, force = sections["numerics"], sections["creepage"], sections["force"]
        if numerics.grid is None and numerics.accuracy is None:
            sections["numerics"] = numerics.model_copy(update={"accuracy": STANDARD_ACCURACY})
        zeros = {
            direction: 0.0
            for direction in ("longitudinal", "lateral")
            if getattr(creepage, direction) is None and getattr(force, f"{direction}_N") is None
        }
        sections["creepage"] = creepage.model_copy(update=zeros)
        # Every part of it has been checked.
        return Settings.model_construct(title=title, **sections)


def _place(table: KeyPath, model: type[Table], location: tuple[Any, ...]) -> tuple[KeyPath, type[Table], str]:
    """The table, its model and the key that an error at `location` is about: tables inside tables have models of their own."""
    key = str(location[0])
    inner = nested_table(model, key)
    if inner is None or len(location) == 1:
        return table, model, key
    return _place((*table, key), inner, location[1:])


def _errors_of(model: type[Table], given: dict[str, Any]) -> list[Any]:
    try:
        model.model_validate(given)
    except ValidationError as cause:
        return list(_first_of_each(model, cause.errors(include_url=False)))
    return []


def _first_of_each(model: type[Table], errors: list[Any]) -> Iterator[Any]:
    seen = set()
    for error in errors:  # a value that fits none of several types has one error for each
        place = _place((), model, error["loc"])
        if place not in seen:
            seen.add(place)
            yield error


def _message(error: Any) -> str:
    kind, value = error["type"], error["input"]
    if isinstance(value, float) and math.isnan(value):
        return "nan is not a number"
    if kind == "finite_number" or (kind == "float_type" and type(value) is int):  # an integer no float can hold
        return "must be finite"
    if kind == "greater_than_equal":
        return "must be greater than 0" if error["ctx"]["ge"] > 0 >= value else "is below the allowed range"
    if kind == "less_than_equal":
        return "is above the allowed range"
    plain = {
        "float_type": "must be a number",
        "int_type": "must be a whole number",
        "list_type": "must be a list",
        "too_short": "is empty",
        "too_long": "has too many entries",
        "model_type": "must be a table",
        "bool_type": "must be true or false",
        "string_type": "must be text in quotes",
        "string_too_long": "is too long",
        "literal_error": "is not a known word",
    }
    # A validator that raises ValueError is quoted with these words in front.
    return str(plain.get(kind, error["msg"].removeprefix("Value error, ")))
