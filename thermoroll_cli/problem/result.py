"""What comes out of a solve: immutable states, their scalars, errors and the work done."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from thermoroll_cli.problem.problem import Problem
from thermoroll_cli.problem.subsurface import BodyStresses, Subsurface

Value = TypeVar("Value")

FIELDS: dict[str, tuple[str, str]] = {
    "pressure": ("Pa", "contact pressure"),
    "shear_x": ("Pa", "shear traction along x"),
    "shear_y": ("Pa", "shear traction along y"),
    "slip_x": ("m/s", "slip velocity along x"),
    "slip_y": ("m/s", "slip velocity along y"),
    "state": ("1", "0 out of contact, 1 stick, 2 slip"),
    "covered": ("1", "share of the element inside the contact"),
    "stick_share": ("1", "share of the element that sticks"),
    "friction_coefficient": ("1", "local coefficient of friction, at the temperature of the contact"),
    "heat_flux": ("W/m2", "frictional heat flux into both bodies"),
    "heat_flux_lower": ("W/m2", "heat flux into the lower body, friction and conduction"),
    "temperature_rise_lower": ("K", "surface temperature rise of the lower body"),
    "temperature_rise_upper": ("K", "surface temperature rise of the upper body"),
    "entry_temperature_lower": ("K", "temperature with which the track enters the contact, lower body"),
    "entry_temperature_upper": ("K", "temperature with which the track enters the contact, upper body"),
    "displacement_elastic": ("m", "normal elastic displacement, sum of both bodies"),
    "displacement_thermal": ("m", "thermal expansion towards each other, sum of both bodies"),
    "gap": ("m", "distance between the deformed surfaces"),
}
"""Name of each 2-D field, with its SI unit and long name."""

SCALARS: dict[str, str] = {
    "Q_F_W": "total frictional heat",
    "gamma_c": "contact area / Hertz area",
    "gamma_st": "stick area / contact area",
    "gamma_p": "maximum pressure / Hertz peak pressure",
    "temperature_rise_max_lower_K": "maximum temperature rise, lower body",
    "temperature_rise_max_upper_K": "maximum temperature rise, upper body",
    "surface_temperature_max_lower_K": "hottest surface temperature, lower body",
    "surface_temperature_max_upper_K": "hottest surface temperature, upper body",
    "bulk_temperature_lower_K": "mean surface temperature, lower body",
    "bulk_temperature_upper_K": "mean surface temperature, upper body",
    "entry_temperature_max_lower_K": "hottest entering track, lower body",
    "entry_temperature_max_upper_K": "hottest entering track, upper body",
    "flash_temperature_max_lower_K": "rise of this pass, lower body",
    "flash_temperature_max_upper_K": "rise of this pass, upper body",
    "heat_into_lower_W": "heat into the lower body",
    "heat_into_upper_W": "heat into the upper body",
    "recirculation_bulge_um": "thermal crown over the contact",
    "thermal_crown_ratio": "curvatures of thermal crown / gap",
    "warm_up_time_lower_s": "warm-up time, lower body",
    "warm_up_time_upper_s": "warm-up time, upper body",
    "force_x_N": "longitudinal creep force",
    "force_y_N": "lateral creep force",
    "spin_moment_Nmm": "spin moment",
    "T_gamma_N": "wear number Tγ, frictional heat over rolling speed",
    "creepage_longitudinal": "longitudinal creepage",
    "creepage_lateral": "lateral creepage",
    "creepage_spin_rad_mm": "spin",
    "pressure_max_MPa": "maximum pressure",
    "shear_max_MPa": "maximum shear traction",
    "heat_flux_max_W_mm2": "maximum heat flux",
    "approach_um": "rigid-body approach",
    "contact_area_mm2": "contact area",
    "stick_area_mm2": "stick area",
    "thermal_displacement_max_um": "thermal displacement, variation over the contact (sum of both bodies)",
    "partition_mean": "share of the frictional heat that enters the lower body",
    "power_balance_error": "relative mismatch of dissipated heat and work of the creep forces",
}
"""Physical scalars of one state, in the units of their names, in the order they are reported."""

WITHOUT_HERTZ: dict[str, str] = {
    "gamma_c": "contact area / cold area",
    "gamma_p": "maximum pressure / cold one",
}
"""What these ratios relate to where bodies have profiles, and there is no Hertz contact to compare with."""

HERTZ_SCALARS: dict[str, str] = {
    "hertz_a_mm": "Hertz semi-axis along x",
    "hertz_b_mm": "Hertz semi-axis along y",
    "hertz_p0_MPa": "Hertz peak pressure",
    "friction_limit_N": "friction limit μW",
    "peclet_lower": "Péclet number V a0/κ, lower body",
    "peclet_upper": "Péclet number V a0/κ, upper body",
    "kalker_C11": "Kalker's longitudinal creepage coefficient",
    "kalker_C22": "Kalker's lateral creepage coefficient",
    "kalker_C23": "Kalker's coefficient of spin and lateral force",
    "speed_solved_m_s": "rolling speed of the state",
}
"""Scalars that belong to the inputs and not to a state."""


class Named(Mapping[str, Value]):
    """Values by name, which cannot be changed. A KeyError lists the names there are."""

    def __init__(self, kind: str, values: Mapping[str, Value]) -> None:
        self._kind, self._values = kind, dict(values)

    def __getitem__(self, name: str) -> Value:
        if name in self._values:
            return self._values[name]
        raise KeyError(f"no {self._kind} {name!r}; there are {', '.join(self._values) or 'none'}")

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    def __repr__(self) -> str:
        return repr(self._values)


@dataclass(frozen=True)
class State:
    """One steady state on a grid: `fields` has the 2-D arrays named in `FIELDS` (SI, shape (nx, ny), read-only), `x` and `y`
    the element centres in m, `scalars` the numbers named in `SCALARS`. A field or scalar whose stage was skipped is absent or
    nan."""

    fields: Mapping[str, NDArray[Any]]
    scalars: Mapping[str, float]
    x: NDArray[np.float64]
    y: NDArray[np.float64]

    def __post_init__(self) -> None:
        views = {name: np.asarray(values).view() for name, values in self.fields.items()}
        for view in views.values():
            view.flags.writeable = False
        object.__setattr__(self, "fields", Named("field", views))
        object.__setattr__(self, "scalars", Named("scalar", self.scalars))

    def __repr__(self) -> str:
        return f"<State: fields {', '.join(self.fields)}; {len(self.scalars)} scalars>"


@dataclass(frozen=True)
class Result:
    """Outcome of one solve.

    `coupled` is the state with thermal deformation, `isothermal` the state on the isothermal geometry; they are the
    same object when nothing feeds back. Each has its own grid where the domain has followed a heated contact. `error` maps
    scalar names to the estimated discretisation error over the scale of that scalar (`error_scale`). `work` holds plain JSON
    types: grid, iterations, operator applications, seconds by stage, skipped stages with reasons. `history` holds one array per
    residual.
    `case_text` and `case_json` are the case it was solved for, as read and resolved (empty for a bare `Problem`).
    `patches` (of bodies with profiles) has a mapping for each patch of the coupled state, named in units (`patches_of`);
    `unbounded` names scalars that grow with every refinement, at the end of a profile that the contact reaches.
    `subsurface` has the stresses inside the bodies where the problem asks for them. `attributes` are the root attributes of the
    file that the result was read from: when, with which versions and by which command line it was computed.
    """

    problem: Problem
    coupled: State
    isothermal: State
    hertz: Mapping[str, float]
    converged: bool
    reason: str
    error: Mapping[str, float]
    work: Mapping[str, Any]
    history: Mapping[str, NDArray[np.float64]] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()
    case_text: str = ""
    case_json: str = ""
    patches: tuple[Mapping[str, float], ...] = ()
    unbounded: tuple[str, ...] = ()
    subsurface: Subsurface | None = None
    attributes: Mapping[str, Any] = field(default_factory=dict)

    @property
    def x(self) -> NDArray[np.float64]:
        """Element centres of the coupled state along x in m, (nx,)."""
        return self.coupled.x

    @property
    def y(self) -> NDArray[np.float64]:
        """Element centres of the coupled state along y in m, (ny,)."""
        return self.coupled.y

    @property
    def bodies(self) -> Mapping[str, BodyStresses]:
        """Stresses inside the bodies that were looked into, by "lower" and "upper"; none where the problem asks for none."""
        return {} if self.subsurface is None else self.subsurface.bodies

    @property
    def own_grids(self) -> bool:
        """Whether the two states live on different grids."""
        cold = self.isothermal
        return not (np.array_equal(self.x, cold.x) and np.array_equal(self.y, cold.y))

    @property
    def status(self) -> str:
        return "converged" if self.converged else "not_converged"

    def __repr__(self) -> str:
        title = f"{self.problem.title!r}, " if self.problem.title else ""
        outcome = "converged" if self.converged else f"not converged: {self.reason}"
        told = {"Q_F_W": "Q_F = {:.4g} W", "force_x_N": "F_x = {:.4g} N", "gamma_st": "γ_st = {:.3g}"}
        numbers = [text.format(self.coupled.scalars[k]) for k, text in told.items() if self.coupled.scalars.get(k, 0.0) != 0.0]
        return f"<Result {title}{len(self.x)}×{len(self.y)}, {', '.join([outcome, *numbers])}>"

    def summary(self) -> dict[str, Any]:
        """All scalars under the public names of the interface (plain Python types, nan where not computed)."""
        return {
            "status": self.status,
            "reason": self.reason,
            **self.coupled.scalars,
            **self.hertz,
            **({} if self.subsurface is None else self.subsurface.scalars),
            "isothermal": dict(self.isothermal.scalars),
            "error": {**self.error, **({} if self.subsurface is None else self.subsurface.error)},
            "work": dict(self.work),
            "warnings": list(self.warnings),
            **({"patches": [dict(patch) for patch in self.patches]} if self.patches else {}),
            **({"unbounded": list(self.unbounded)} if self.unbounded else {}),
        }
