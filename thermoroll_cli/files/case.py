"""Case files: TOML text in, a checked case and the problem that it describes out."""

from __future__ import annotations

import html
import json
import math
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
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
from thermoroll_cli.problem import problem as si
from thermoroll_cli.problem.problem import FrictionLaw, Profile

__all__ = ["Case", "CaseError", "Finding", "Override", "case_name"]


@dataclass(frozen=True)
class Case:
    """A valid case: `settings` in the units of the case file with all defaults filled in, and the `text` that they come from.
    `name` is that of its result files. Cases are equal if their settings are."""

    name: str = field(compare=False)
    text: str = field(compare=False)
    settings: model.Settings

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
    def from_dict(cls, content: Mapping[str, Any], *, name: str = "case") -> Case:
        """The case of tables and keys as in a case file, for example `{"load": {"normal_N": 65.0, …}, …}`. Values may be
        NumPy's; None is a key left out. Raises CaseError."""
        given = _plain(content)
        return cls(name, tomli_w.dumps(given), validate(CaseSource("from_dict", "", given, located=False)))

    @classmethod
    def from_json(cls, text: str, *, name: str = "case", overrides: Sequence[Override] = ()) -> Case:
        """The case that `to_json` wrote, of this version or an earlier one. Raises CaseError."""
        try:
            content = json.loads(text)
            geometry = content["geometry"]
            content["geometry"] = {key: math.inf if value == "inf" else value for key, value in geometry.items()}
            for (table, key), (new_table, new_key) in model.MOVED.items():
                if key in content[table]:
                    content.setdefault(new_table, {})[new_key] = content[table].pop(key)
        except (ValueError, KeyError, TypeError, AttributeError):
            raise CaseError([Finding("no resolved case in it", source=name)]) from None
        return cls.parse(tomli_w.dumps(content), name=name, overrides=overrides)

    @classmethod
    def of(cls, case: Case | Mapping[str, Any] | str | os.PathLike[str]) -> Case:
        """`case` itself, or the case of a file, or of a mapping of tables and keys. Raises CaseError."""
        if isinstance(case, Case):
            return case
        return cls.from_dict(case) if isinstance(case, Mapping) else cls.read(case)

    @classmethod
    def from_source(cls, source: CaseSource, name: str) -> Case:
        """The case of a text that is parsed already. Raises CaseError."""
        return cls(name, source.text, validate(source))

    def with_values(self, values: Mapping[str, Any]) -> Case:
        """This case with other values for some dotted keys, for example `{"rolling.speed_m_s": 2.0}`. Where two keys exclude
        each other (a creepage and a force) the new one replaces the old. Raises CaseError."""
        content = self._content()
        overrides = [Override(key_path(key), _plain(value), f"{key}={value}", "with_values") for key, value in values.items()]
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
        return problem_of(self.settings)

    @property
    def inputs(self) -> tuple[Input, ...]:
        """All keys that have a value, in their own units and in SI."""
        return tuple(inputs(self.settings))

    def to_toml(self) -> str:
        """The case with all defaults filled in, as a case file that gives the same case again."""
        return tomli_w.dumps(self._content())

    def to_json(self) -> str:
        """The case with all defaults filled in, as strict JSON; infinite radii are "inf"."""
        content = self._content()
        for key, value in content["geometry"].items():
            content["geometry"][key] = "inf" if isinstance(value, float) and math.isinf(value) else value
        return json.dumps(content, ensure_ascii=False, allow_nan=False)

    def __hash__(self) -> int:
        return hash(self.to_json())

    def __repr__(self) -> str:
        title = f": {self.settings.title}" if self.settings.title else ""
        return f"<Case {self.name}{title}>"

    def _repr_html_(self) -> str:
        """A table of the inputs, for notebooks."""
        rows = "".join(
            f"<tr><td>{html.escape(item.key)}</td><td>{html.escape(item.shown)}</td><td>{html.escape(item.shown_si)}</td></tr>"
            for item in self.inputs if item.key != "title")  # fmt: skip
        title = html.escape(f"{self.name}: {self.settings.title}" if self.settings.title else self.name)
        return f"<table><caption>{title}</caption><tr><th>key</th><th>value</th><th>in SI</th></tr>{rows}</table>"

    def _content(self) -> dict[str, Any]:
        content = self.settings.model_dump(exclude_none=True)
        if isinstance(content["numerics"].get("grid"), tuple):
            content["numerics"]["grid"] = list(content["numerics"]["grid"])
        return {key: value for key, value in content.items() if value not in ("", {})}


@dataclass(frozen=True)
class Input:
    """A key with its `value` in the unit of the key, and in SI: `si` is None if it is no number, `unit` may be empty."""

    key: str
    value: Any
    si: float | None
    unit: str

    @property
    def shown(self) -> str:
        """The value in the unit of the key, as text."""
        return shown(self.value)

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
            yield Input(key, value, float(table.si(name)), model.si_unit(type(table).model_fields[name])[0])
        elif value is not None and value != "":
            yield Input(key, value, None, "")


def shown(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, list | tuple):
        return f"{len(value)} values" if len(value) > 2 else "×".join(map(shown, value))
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _plain(value: Any) -> Any:
    """`value` with Python's numbers and lists for NumPy's, and without None."""
    if isinstance(value, Mapping):
        return {str(key): _plain(inner) for key, inner in value.items() if inner is not None}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return value.tolist() if hasattr(value, "tolist") else value


def problem_of(settings: model.Settings) -> si.Problem:
    """The problem in SI units that a case describes: units are converted here (`case_model.Table.si`) and nowhere else."""
    lower, upper = (_material(material) for material in settings.materials.values())
    geometry, load, rolling, friction = settings.geometry, settings.load, settings.rolling, settings.friction
    creepage, force, thermal, numerics = settings.creepage, settings.force, settings.thermal, settings.numerics
    grid = (numerics.grid, numerics.grid) if isinstance(numerics.grid, int) else numerics.grid
    return si.Problem(
        lower=lower,
        upper=upper,
        geometry=si.Geometry(
            lower_radius_x=geometry.si("lower_radius_x_mm"),
            lower_radius_y=geometry.si("lower_radius_y_mm") or math.inf,
            upper_radius_x=geometry.si("upper_radius_x_mm"),
            upper_radius_y=geometry.si("upper_radius_y_mm") or math.inf,
            lower_profile=_profile(geometry.lower_profile),
            upper_profile=_profile(geometry.upper_profile),
        ),
        normal_force=load.normal_N,
        friction=load.friction_coefficient,
        motion=si.Motion(
            speed=rolling.speed_m_s,
            creepage_x=creepage.longitudinal,
            creepage_y=creepage.lateral,
            spin=creepage.si("spin_rad_mm"),
            force_x=force.longitudinal_N,
            force_y=force.lateral_N,
            differential_slip=rolling.differential_slip,
        ),
        heating=si.Heating(
            heat=thermal.heat,
            deformation=thermal.deformation,
            peclet=thermal.peclet,
            partition=thermal.partition,
            bulk_lower=thermal.bulk_temperature_lower_K,
            bulk_upper=thermal.bulk_temperature_upper_K,
            lower_track=_recirculation(thermal.lower, geometry.lower_radius_x_mm),
            upper_track=_recirculation(thermal.upper, geometry.upper_radius_x_mm),
        ),
        numerics=si.Numerics(grid=grid, accuracy=numerics.accuracy, extent=numerics.extent),
        title=settings.title,
        friction_slope=friction.temperature_slope_1_K,
        friction_minimum=friction.temperature_minimum_factor,
        friction_maximum=friction.temperature_maximum_factor,
        friction_start=friction.temperature_start_K,
        friction_law=_friction_law(settings),
        wear=_wear(settings),
        layer=0.0 if settings.layer is None else settings.layer.si("compliance_um_GPa") or 0.0,
        layer_yield=None if settings.layer is None else settings.layer.si("yield_MPa"),
        subsurface=_subsurface(settings),
    )


def _friction_law(settings: model.Settings) -> FrictionLaw | None:
    """The law of slip, relative to the coefficient without slip; None for constant friction. Memory without a law is kept as a
    law that does not fall, which is warned of."""
    friction, at_rest = settings.friction, settings.load.friction_coefficient
    if at_rest == 0.0 or not (friction.law or friction.memory_um):
        return None
    law = FrictionLaw(friction.law or "exponential", memory=friction.si("memory_um"),
                      memory_slip=friction.si("memory_slip_mm_s"))
    if friction.law == "table":
        return replace(law, table=tuple((speed, coefficient / at_rest) for speed, coefficient in friction.table or ()))
    if friction.law is None:
        return law
    return replace(law, limit=(friction.limit_coefficient or 0.0) / at_rest, half_slip=friction.half_slip_m_s or 0.0)


def _subsurface(settings: model.Settings) -> si.SubsurfaceRequest | None:
    table = settings.subsurface
    return None if table is None else si.SubsurfaceRequest(
        bodies=tuple(body for body in si.BODIES if body in table.bodies),
        depth=table.si("depth_mm"),
        layers=table.layers,
        thermal=table.thermal is not False,
        fields=table.fields,
        lower_strength=_strength(settings.strength.lower if settings.strength else None),
        upper_strength=_strength(settings.strength.upper if settings.strength else None),
    )  # fmt: skip


def _strength(table: model.BodyStrengthTable | None) -> si.Strength | None:
    return None if table is None else si.Strength(table.si("shear_yield_MPa"), table.dang_van_coefficient)


def _wear(settings: model.Settings) -> si.Wear | None:
    table = settings.wear
    if table is None:
        return None
    bodies = {body: _worn_body(getattr(table, body), getattr(settings.geometry, f"{body}_radius_x_mm")) for body in si.BODIES}
    return si.Wear(
        **bodies,
        distance=table.si("distance_km") or math.inf,
        depth=table.si("depth_um") or math.inf,
        step_fraction=table.step_fraction,
        snapshots=table.snapshots,
    )


def _worn_body(table: model.WornBodyTable | None, radius_mm: float) -> si.WornBody:
    if table is None:
        return si.WornBody()
    return si.WornBody(table.si("specific_wear_rate_mm3_Nm"), table.track_length_m or 2e-3 * math.pi * abs(radius_mm))


def _recirculation(table: model.RecirculationTable | None, radius_mm: float) -> si.Recirculation | None:
    if table is None or not table.recirculate:
        return None
    width = 2.0 * abs(radius_mm) / 1e3 if table.width_mm is None else table.si("width_mm")
    return si.Recirculation(width, table.passes_per_revolution, table.convection_W_m2K, table.thermal_resistance_K_W)


def _material(material: model.MaterialTable) -> si.Material:
    return si.Material(*_constants(material), layers=tuple(
        si.Layer(layer.si("thickness_um"), *_constants(layer), layer.si("shear_yield_MPa")) for layer in material.layers or ()))


def _constants(table: model.MaterialConstants) -> tuple[float, float, float | None, float | None, float | None]:
    return (table.si("youngs_modulus_GPa"), table.poisson_ratio, table.conductivity_W_mK, table.si("expansion_um_mK"),
            table.si("diffusivity_mm2_s"))


def _profile(table: model.ProfileTable | None) -> Profile | None:
    if table is None:
        return None
    points = tuple((y / 1e3, z / 1e3) for y, z in table.points_mm or ())
    length, drop, flat = (table.si(key) or 0.0 for key in ("length_mm", "drop_um", "flat_mm"))
    return Profile(points, table.interpolation, length, drop, flat, table.si("offset_mm"), table.si("tilt_mrad"))
