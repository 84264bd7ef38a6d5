"""Case files: TOML text in, a checked case and the problem it describes out."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import tomli_w

from thermoroll_cli.files.case.case_errors import CaseError, Finding
from thermoroll_cli.files.case.case_model import MaterialTable, RecirculationTable, Settings, SubsurfaceTable, Table
from thermoroll_cli.files.case.case_source import (
    STANDARD_INPUT,
    CaseSource,
    Override,
    apply_overrides,
    parse_source,
    read_source,
)
from thermoroll_cli.files.case.case_validation import validate
from thermoroll_cli.files.case.profile_checks import geometry_si
from thermoroll_cli.problem import problem as si

__all__ = ["Case", "CaseError", "Finding", "Override"]


PYTHON = "with_values"
"""Where errors of `Case.with_values` are."""


@dataclass(frozen=True)
class Case:
    """A valid case: `settings` in the units of the case file with all defaults filled in, and the `text` they
    come from. `name` is what result files are called."""

    name: str
    text: str
    settings: Settings

    @classmethod
    def read(cls, path: str | os.PathLike[str], overrides: Sequence[Override] = ()) -> Case:
        """Read the case file at `path` (`-`: standard input), with `overrides` applied.

        Raises CaseError, with all errors of the case, if it is missing, unreadable or invalid.
        """
        return cls.from_source(read_source(path, overrides), case_name(path))

    @classmethod
    def parse(cls, text: str, *, name: str = "case", overrides: Sequence[Override] = ()) -> Case:
        """The case that the TOML `text` describes. Raises CaseError."""
        return cls.from_source(parse_source(text, name, overrides), name)

    @classmethod
    def from_json(cls, text: str, *, name: str = "case", overrides: Sequence[Override] = ()) -> Case:
        """The case that `to_json` wrote. Raises CaseError."""
        try:
            content = json.loads(text)
            geometry = content["geometry"]
            content["geometry"] = {key: math.inf if value == "inf" else value for key, value in geometry.items()}
        except (ValueError, KeyError, TypeError, AttributeError):
            raise CaseError([Finding("no resolved case in it", source=name)]) from None
        return cls.parse(_toml(content), name=name, overrides=overrides)

    @classmethod
    def from_source(cls, source: CaseSource, name: str) -> Case:
        """The case of a text that is parsed already. Raises CaseError."""
        return cls(name, source.text, validate(source))

    def with_values(self, values: Mapping[str, Any]) -> Case:
        """This case with other values for some dotted keys, for example `{"rolling.speed_m_s": 2.0}`. Of two keys
        that exclude each other (a creepage and a force) the new one replaces the old. Raises CaseError."""
        content = self._content()
        overrides = [
            # NumPy's numbers and arrays, as they come out of a loop, are meant as Python's.
            Override(tuple(key.split(".")), value.tolist() if hasattr(value, "tolist") else value, f"{key}={value}", PYTHON)
            for key, value in values.items()
        ]
        apply_overrides(content, overrides)
        source = CaseSource(self.name, self.text, content, tuple(overrides), located=False)
        return Case(self.name, self.text, validate(source))

    @property
    def plots(self) -> bool:
        """Whether the case asks for pictures."""
        return self.settings.output.plots

    @property
    def problem(self) -> si.Problem:
        """The problem in SI units."""
        return _problem(self.settings)

    def to_toml(self) -> str:
        """The case with all defaults filled in, as a case file that gives the same case again."""
        return _toml(self._content())

    def to_json(self) -> str:
        """The case with all defaults filled in, as strict JSON; infinite radii are "inf"."""
        content = self._content()
        for key, value in content["geometry"].items():
            content["geometry"][key] = "inf" if isinstance(value, float) and math.isinf(value) else value
        return json.dumps(content, ensure_ascii=False, allow_nan=False)

    def _content(self) -> dict[str, Any]:
        content = _given(self.settings)
        if isinstance(content["numerics"].get("grid"), tuple):
            content["numerics"]["grid"] = list(content["numerics"]["grid"])
        return {key: value for key, value in content.items() if value not in ("", {})}


def case_name(path: str | os.PathLike[str]) -> str:
    """What the results of the case at `path` are called: the file name without its last suffix."""
    name = os.fspath(path)
    return "stdin" if name == STANDARD_INPUT else os.path.splitext(os.path.basename(name))[0]


def _given(table: Table) -> dict[str, Any]:
    """The keys and tables in `table` that are not left out. For this alone pydantic would have to build a serializer first."""
    given = {key: value for key, value in table if value is not None}
    return {key: _given(value) if isinstance(value, Table) else value for key, value in given.items()}


def _toml(content: dict[str, Any]) -> str:

    return tomli_w.dumps(content)


def _problem(settings: Settings) -> si.Problem:
    """Convert units, here and nowhere else. Decimal prefixes below one divide: 30.0 / 1e3 is 0.03 to the last bit."""
    materials = {body: _material(material) for body, material in settings.materials.items()}
    creepage, force = settings.creepage, settings.force
    thermal, numerics = settings.thermal, settings.numerics
    grid = (numerics.grid, numerics.grid) if isinstance(numerics.grid, int) else numerics.grid
    return si.Problem(
        lower=materials["lower"],
        upper=materials["upper"],
        geometry=geometry_si(settings.geometry),
        normal_force=settings.load.normal_N,
        friction=settings.load.friction_coefficient,
        motion=si.Motion(
            speed=settings.rolling.speed_m_s,
            creepage_x=creepage.longitudinal,
            creepage_y=creepage.lateral,
            spin=creepage.spin_rad_mm * 1e3,
            force_x=force.longitudinal_N,
            force_y=force.lateral_N,
            differential_slip=settings.rolling.differential_slip,
        ),
        heating=si.Heating(
            heat=thermal.heat,
            deformation=thermal.deformation,
            peclet=thermal.peclet,
            partition=thermal.partition,
            bulk_lower=thermal.bulk_temperature_lower_K,
            bulk_upper=thermal.bulk_temperature_upper_K,
            lower_track=_recirculation(thermal.lower, settings.geometry.lower_radius_x_mm),
            upper_track=_recirculation(thermal.upper, settings.geometry.upper_radius_x_mm),
        ),
        numerics=si.Numerics(grid=grid, accuracy=numerics.accuracy, extent=numerics.extent),
        title=settings.title,
        friction_slope=settings.load.friction_temperature_slope_1_K,
        friction_minimum=settings.load.friction_minimum_factor,
        friction_maximum=settings.load.friction_maximum_factor,
        friction_start=settings.load.friction_temperature_start_K,
        subsurface=None if settings.subsurface is None else _subsurface(settings.subsurface),
    )


def _subsurface(table: SubsurfaceTable) -> si.SubsurfaceRequest:
    return si.SubsurfaceRequest(
        bodies=tuple(body for body in si.BODIES if body in table.bodies),
        depth=None if table.depth_mm is None else table.depth_mm / 1e3,
        layers=table.layers,
        thermal=table.thermal is not False,
        fields=table.fields,
    )


def _recirculation(table: RecirculationTable | None, radius_mm: float) -> si.Recirculation | None:
    if table is None or not table.recirculate:
        return None
    width = 2.0 * abs(radius_mm) if table.width_mm is None else table.width_mm
    return si.Recirculation(width / 1e3, table.passes_per_revolution, table.convection_W_m2K, table.thermal_resistance_K_W)


def _material(material: MaterialTable) -> si.Material:
    expansion, diffusivity = material.expansion_um_mK, material.diffusivity_mm2_s
    return si.Material(
        youngs_modulus=material.youngs_modulus_GPa * 1e9,
        poisson_ratio=material.poisson_ratio,
        conductivity=material.conductivity_W_mK,
        expansion=None if expansion is None else expansion / 1e6,
        diffusivity=None if diffusivity is None else diffusivity / 1e6,
    )
