"""The answer: a wheelset in balance with all its patches, as scalars in track axes with forces on the rails."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from thermoroll_cli.arrays import Array
from thermoroll_cli.problem.names import PATCH_SCALARS, SCALARS
from thermoroll_cli.problem.result import Named, Result
from thermoroll_cli.wheelset.solve_wheelset import Report, SolvedPatch, SolvedWheelset, WheelsetSolver
from thermoroll_cli.wheelset.wheelset_problem import SIDES, SideName, WheelsetProblem, sign_of

FORCES = "xyz"
STIFFENING = 1.5
"""Exponent of the load over the overlap: an error of the height counts by so much in the shares of patches."""
LARGEST_POWER_ERROR = 2e-3
"""Heat of all patches against the power that the rails take from the wheelset."""
ROLLING = 1e-3
"""Heat over the friction limit times the speed below which a wheelset hardly slips, and its heat is a small difference."""
WIDEST_PLANE, WIDEST_CURVED = 0.3, 1.0
"""Turn of the surface across a patch (rad) from which a plane, or the half-space, is a doubtful model."""


@dataclass(frozen=True)
class WheelsetPatch:
    """A patch and where it lies, `solved`: its `side`, its `number` from the left of the track on that side, its `record` in
    track axes, and its `result`, in the axes of the contact solver."""

    side: SideName
    number: int
    record: Mapping[str, Any]
    result: Result
    solved: SolvedPatch

    @property
    def name(self) -> str:
        """End of the names of its files."""
        return f"{self.side}_{self.number}"


@dataclass(frozen=True)
class WheelsetResult:
    """Outcome of a wheelset.

    Attributes:

    - `problem`: the question, in SI units;
    - `scalars`: forces on the rails in the axes of the track, position and heat, in the units of their names;
    - `error`: estimated errors of scalars: of forces over the vertical force, of the height over the largest approach, of
      others over themselves;
    - `patches`: each with its `record` in the axes of the track and its `result`;
    - `reason`: why it has not converged, "" if it has; `warnings`;
    - `case_text`, `case_json`: the case as read and with all defaults; empty for a bare problem.
    """

    problem: WheelsetProblem
    scalars: Mapping[str, float]
    error: Mapping[str, float]
    patches: tuple[WheelsetPatch, ...]
    reason: str = ""
    warnings: tuple[str, ...] = ()
    case_text: str = ""
    case_json: str = ""

    @property
    def converged(self) -> bool:
        return not self.reason

    @property
    def status(self) -> str:
        return "converged" if self.converged else "not_converged"

    def summary(self, files: Mapping[str, str] | None = None) -> dict[str, Any]:
        """All scalars under their public names, and the patches with the `files` of their results by name."""
        patches = [{"side": patch.side, "number": patch.number, "file": (files or {}).get(patch.name, ""), **patch.record}
                   for patch in self.patches]
        return {"status": self.status, "reason": self.reason, "warnings": list(self.warnings), **self.scalars,
                "error": dict(self.error), "patches": patches}


def solve_wheelset(
    problem: WheelsetProblem, *, threads: int = 1, report: Report | None = None, solver: WheelsetSolver | None = None
) -> WheelsetResult:
    """Solve `problem`, from the last state of `solver` if it is given. `report` is called with a stage and a mapping as the
    work goes on. Raises Unsolvable if a wheel misses its rail; `reason` says everything else that goes wrong."""
    return result_of_wheelset((solver or WheelsetSolver(threads)).solve(problem, report=report))


def result_of_wheelset(solved: SolvedWheelset, warnings: tuple[str, ...] = ()) -> WheelsetResult:
    """The result of a solved wheelset; not converged where it is not in balance, or where a patch is not."""
    patches = []
    for side in solved.problem.sides:
        mine = sorted((patch for patch in solved.patches if patch.side == side),
                      key=lambda patch: sign_of(patch.side) * patch.forces.centre[1])
        patches += [WheelsetPatch(side, number, _record(patch), patch.result, patch) for number, patch in enumerate(mine, 1)]
    summed = _Sums(solved)
    reasons = [solved.reason] if solved.reason else []
    reasons += [f"patch {patch.name}: {patch.result.reason}" for patch in patches if not patch.result.converged]
    scalars = summed.scalars
    sliding = sum(patch.result.problem.traction_limit for patch in solved.patches) * solved.problem.motion.speed
    if scalars["power_balance_error"] * scalars["Q_F_W"] > LARGEST_POWER_ERROR * max(scalars["Q_F_W"], ROLLING * sliding):
        reasons.append(f"the heat of the patches and the power of the wheelset differ by {scalars['power_balance_error']:.1e}")
    of_patches = dict.fromkeys(f"patch {patch.name}: {warning}" for patch in patches
                          for warning in (*patch.result.warnings, *_turning(patch.solved)))
    return WheelsetResult(solved.problem, Named("scalar", scalars), summed.errors, tuple(patches), "; ".join(reasons),
                          (*warnings, *of_patches))


def _turning(patch: SolvedPatch) -> Iterator[str]:
    """Doubts about a patch across which the surface turns far."""
    surface, state = patch.bearing.patch, patch.result.coupled
    s = -state.y[np.asarray(state.fields["pressure"]).any(axis=0)]
    turn = float(np.ptp(replace(surface, curved=True).inclination(s))) if len(s) else 0.0
    if turn > WIDEST_PLANE and not surface.curved:
        yield (f"the surface turns by {turn:.2g} rad across the patch, which lies in a plane: "
               'patches = "curved" follows the surface')
    if turn > WIDEST_CURVED:
        yield (f"the surface turns by {turn:.2g} rad across the patch: the half-space, whose compliance both bodies have, is "
               "doubtful above 1 rad")


def _record(patch: SolvedPatch) -> dict[str, Any]:
    """Place, forces, creepages and the scalars of a patch in track axes, in the units of their names."""
    sign, forces, scalars = sign_of(patch.side), patch.forces, patch.result.coupled.scalars
    x, y, z = forces.centre
    along, across, normal = forces.local
    rail, wheel = patch.in_profiles
    record = {
        "x_mm": 1e3 * x, "y_mm": 1e3 * sign * y, "z_mm": 1e3 * z, "angle_mrad": 1e3 * sign * forces.angle,
        "y_rail_mm": 1e3 * rail, "y_wheel_mm": 1e3 * wheel,
        "normal_N": normal, "force_x_N": along, "force_s_N": sign * across,
        "moment_n_Nmm": -sign * scalars["spin_moment_Nmm"],
        "creepage_x": forces.creepages[0], "creepage_s": sign * forces.creepages[1],
        "spin_rad_mm": 1e-3 * sign * forces.creepages[2],
    }  # fmt: skip
    of_result = {name: scalars[name] for name in PATCH_SCALARS
                 if name not in record and not math.isnan(scalars.get(name, math.nan))}
    return record | of_result | {"status": patch.result.status, "error": dict(patch.result.error)}


@dataclass(frozen=True)
class _Sums:
    """Scalars of a whole wheelset, and their errors."""

    solved: SolvedWheelset

    def forces(self, side: SideName) -> Array:
        """Force on a rail in N, in track axes."""
        mirror = np.array([1.0, sign_of(side), 1.0])
        return sum((mirror * patch.forces.force for patch in self.solved.patches if patch.side == side), np.zeros(3))

    @cached_property
    def scalars(self) -> dict[str, float]:
        solved = self.solved
        sides = solved.problem.sides
        scalars = {"height_mm": 1e3 * solved.standing.height, "roll_mrad": 1e3 * solved.standing.roll,
                   "angular_velocity_rad_s": -solved.angular_velocity}
        for side in SIDES:
            force = self.forces(side) if side in sides else np.full(3, math.nan)
            scalars |= {f"track_force_{axis}_{side}_N": float(f) for axis, f in zip(FORCES, force, strict=True)}
            scalars[f"lateral_over_vertical_{side}"] = float(force[1] / force[2]) if force[2] else math.nan
            scalars[f"rolling_radius_{side}_mm"] = 1e3 * self.rolling_radius(side)
        total = np.sum([self.forces(side) for side in sides], axis=0)
        scalars |= {f"track_force_{axis}_N": float(f) for axis, f in zip(FORCES, total, strict=True)}
        scalars["rolling_radius_difference_mm"] = scalars["rolling_radius_right_mm"] - scalars["rolling_radius_left_mm"]
        of_patches = [patch.result.coupled.scalars for patch in solved.patches]
        heat = sum(values["Q_F_W"] for values in of_patches)
        rises = [values[f"temperature_rise_max_{body}_K"] for values in of_patches for body in ("lower", "upper")]
        power = sum(patch.forces.power for patch in solved.patches)
        return scalars | {
            "Q_F_W": heat, "T_gamma_N": sum(values["T_gamma_N"] for values in of_patches),
            "temperature_rise_max_K": max((rise for rise in rises if not math.isnan(rise)), default=math.nan),
            "pressure_max_MPa": max((values["pressure_max_MPa"] for values in of_patches), default=math.nan),
            "approach_max_um": 1e6 * max((patch.bearing.sunk for patch in solved.patches), default=math.nan),
            "power_balance_error": abs(heat + power) / heat if heat > 0.0 else 0.0,
        }

    def rolling_radius(self, side: SideName) -> float:
        """Distance of the patch with the largest load from the axle in m, nan without one."""
        mine = [patch for patch in self.solved.patches if patch.side == side]
        return max(mine, key=lambda patch: patch.bearing.load).rolling_radius if mine else math.nan

    @property
    def errors(self) -> dict[str, float]:
        """Errors of the scalars: of forces over the vertical one, of the height over the largest approach, of others over
        themselves.

        Each patch has its own; an error of the height, by those of the approaches and of the ratios of forces, moves the load
        of every patch beside others by `STIFFENING` times its share of the overlap."""
        solved = self.solved
        vertical = max(abs(self.scalars["track_force_z_N"]), 1e-300)
        height = sum(patch.bearing.sunk * (patch.result.error.get("approach_um", math.nan) + solved.drift)
                     for patch in solved.patches)
        forces = sum(patch.force_error for patch in solved.patches) / vertical
        shared = [patch for patch in solved.patches if sum(p.side == patch.side for p in solved.patches) > 1
                  or solved.problem.vertical is None]
        moved = sum(STIFFENING * height / patch.bearing.sunk * patch.bearing.load for patch in shared) / vertical
        names = (name for name in self.scalars if name.startswith("track_force"))
        errors = dict.fromkeys(names, forces + moved + solved.drift)
        errors["height_mm"] = height / (1e-6 * self.scalars["approach_max_um"])
        for name in (name for name in self.scalars if name in SCALARS and not SCALARS[name].given):
            own = (patch.result.error.get(name, math.nan) for patch in solved.patches)
            errors[name] = moved + max(own, default=math.nan)
        rises = [patch.result.error.get(f"temperature_rise_max_{body}_K", math.nan) for patch in solved.patches
                 for body in ("lower", "upper")]
        errors["temperature_rise_max_K"] = moved + max((error for error in rises if not math.isnan(error)), default=math.nan)
        return errors
