"""What the pictures need of a result."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from thermoroll_cli.problem.result import BodyStresses, Result


@dataclass(frozen=True)
class StateView:
    """Fields (SI) at the element centres `x`, `y` (m) and scalars (public names) of one state, and what a picture calls it."""

    label: str
    fields: Mapping[str, NDArray[Any]]
    scalars: Mapping[str, float]
    x: NDArray[np.float64]
    y: NDArray[np.float64]

    def field(self, name: str) -> NDArray[np.float64] | None:
        """The named field, or None where it was not computed."""
        values = self.fields.get(name)
        if values is None or not np.any(np.isfinite(values)):
            return None
        return np.nan_to_num(np.asarray(values, dtype=np.float64))

    def magnitude(self, stem: str) -> NDArray[np.float64] | None:
        """Length of the vector field with components `stem`_x and `stem`_y."""
        x, y = self.field(stem + "_x"), self.field(stem + "_y")
        return None if x is None or y is None else np.hypot(x, y)


@dataclass(frozen=True)
class RunView:
    """One result as the pictures see it; lengths and fields in SI units.

    `x`, `y` are the element centres of the last of `states`.
    `states` holds the isothermal and the coupled state, or the single state where nothing feeds back.
    `heat_scale` is k/(α l) with l = 1 mm, by which the article divides heat fluxes (nan without thermal constants).
    """

    title: str
    x: NDArray[np.float64]
    y: NDArray[np.float64]
    states: tuple[StateView, ...]
    semi_axes: tuple[float, float]
    peak_pressure: float
    heat_scale: float
    problem: Mapping[str, Any]
    summary: Mapping[str, Any]
    subsurface: Mapping[str, BodyStresses] = dataclasses.field(default_factory=dict)

    @property
    def converged(self) -> bool:
        return bool(self.summary.get("status") == "converged")


def view_of(result: Result) -> RunView:
    """The view of a result."""
    coupled, isothermal = result.coupled.fields, result.isothermal.fields
    problem: Mapping[str, Any] = dataclasses.asdict(result.problem)
    single = result.coupled is result.isothermal
    summary: Mapping[str, Any] = result.summary()
    subsurface: Mapping[str, BodyStresses] = {} if result.subsurface is None else result.subsurface.bodies
    cold_x, cold_y = result.isothermal.x, result.isothermal.y
    x, y, cold_x, cold_y = (np.asarray(axis) for axis in (result.x, result.y, cold_x, cold_y))
    states: tuple[StateView, ...] = (StateView("", coupled, summary, x, y),)
    if not single:
        states = (StateView("isothermal", isothermal, summary["isothermal"], cold_x, cold_y),
                  StateView("coupled", coupled, summary, x, y))
    return RunView(
        title=str(problem.get("title", "")),
        x=x,
        y=y,
        states=states,
        semi_axes=(summary["hertz_a_mm"] * 1e-3, summary["hertz_b_mm"] * 1e-3),
        peak_pressure=summary["hertz_p0_MPa"] * 1e6,
        heat_scale=_heat_scale(problem),
        problem=problem,
        summary=summary,
        subsurface=subsurface,
    )


def _heat_scale(problem: Mapping[str, Any]) -> float:
    lower = problem.get("lower", {})
    conductivity, expansion = lower.get("conductivity"), lower.get("expansion")
    length = 1e-3
    return conductivity / (expansion * length) if conductivity and expansion else math.nan
