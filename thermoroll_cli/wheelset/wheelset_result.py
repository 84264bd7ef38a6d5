"""The answer: a wheelset in balance with all its patches, as scalars in track axes with forces on the rails."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from thermoroll_cli.arrays import Array
from thermoroll_cli.problem.names import PATCH_SCALARS
from thermoroll_cli.problem.problem import BODIES
from thermoroll_cli.problem.result import Named, Result
from thermoroll_cli.wheelset.first_contact import wheelset_warnings
from thermoroll_cli.wheelset.patch_surface import PatchSurface
from thermoroll_cli.wheelset.shared_errors import SharedErrors, shared_errors
from thermoroll_cli.wheelset.solve_wheelset import Report, SolvedPatch, SolvedWheelset, WheelsetSolver
from thermoroll_cli.wheelset.wheelset_problem import SIDES, SideName, WheelsetProblem, sign_of

FORCES = "xyz"
SUMS = {"Q_F_W": "Q_F_W", "T_gamma_N": "T_gamma_N"}
MAXIMA = {"pressure_max_MPa": "pressure_max_MPa", "approach_max_um": "approach_um"}
"""Scalars of the whole that are the sum, or the largest, of one of its patches."""
IN_CONTACT = {"force_s_N": "force_y_N", "moment_n_Nmm": "spin_moment_Nmm"}
"""Scalars of a patch by their names in the contact."""
LARGEST_FORCE_ERROR = 1e-3
"""Departure of the vertical force from a given one: ten times the change from round to round that ends them."""
LARGEST_POWER_ERROR = 2e-3
"""Heat of all patches against the power that the rails take from the wheelset."""
ROLLING = 1e-3
"""Heat over the friction limit times the speed below which a wheelset hardly slips, and its heat is a small difference."""
WIDEST_PLANE = 0.3
"""Turn of the surface across a patch (rad) from which a plane is a doubtful model; the solver warns of curved patches."""


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
    warnings = tuple(wheelset_warnings(problem))
    return _result_of((solver or WheelsetSolver(threads)).solve(problem, report=report), warnings)


def _result_of(solved: SolvedWheelset, warnings: tuple[str, ...]) -> WheelsetResult:
    """The result of a solved wheelset; not converged where it is not in balance, or where a patch is not."""
    summed = _Whole(solved)
    patches = []
    for side in solved.problem.sides:
        mine = [pair for pair in zip(solved.patches, summed.patch_errors, strict=True) if pair[0].side == side]
        mine.sort(key=lambda pair: sign_of(pair[0].side) * pair[0].forces.centre[1])
        patches += [WheelsetPatch(side, number, _record(patch, errors), patch.result, patch)
                    for number, (patch, errors) in enumerate(mine, 1)]
    reasons = [solved.reason] if solved.reason else [*summed.unbalanced]
    reasons += [f"patch {patch.name}: {patch.result.reason}" for patch in patches if not patch.result.converged]
    scalars = summed.scalars
    sliding = sum(patch.result.problem.traction_limit for patch in solved.patches) * solved.problem.motion.speed
    if scalars["power_balance_error"] * scalars["Q_F_W"] > LARGEST_POWER_ERROR * max(scalars["Q_F_W"], ROLLING * sliding):
        reasons.append(f"the heat of the patches and the power of the wheelset differ by {scalars['power_balance_error']:.1e}")
    of_patches = dict.fromkeys(f"patch {patch.name}: {warning}" for patch in patches
                          for warning in (*map(_in_own_axes, patch.result.warnings), *_turning(patch.solved),
                                          *_divided(patch.solved)))
    return WheelsetResult(solved.problem, Named("scalar", scalars), summed.errors, tuple(patches), "; ".join(reasons),
                          (*warnings, *_left_out(solved), *of_patches))


def _left_out(solved: SolvedWheelset) -> Iterator[str]:
    """Overlaps that are no patches."""
    problem, standing = solved.problem, solved.standing
    for side in problem.sides:
        facing = problem.facing(side, standing.roll)
        facing = facing.lowered(standing.height - facing.position.z)
        for region in facing.regions():
            if not PatchSurface(facing, region, problem.curved).faces:
                yield (f"the {side} wheel and rail overlap at y = {1e3 * sign_of(side) * region.place.y:.4g} mm, at the sharp "
                       "end of a profile, where no normal meets both surfaces: this contact is left out")


def _turning(patch: SolvedPatch) -> Iterator[str]:
    """Doubts about a patch across which the surface turns far."""
    surface, state = patch.bearing.patch, patch.result.coupled
    s = -state.y[np.asarray(state.fields["pressure"]).any(axis=0)]
    turn = float(np.ptp(replace(surface, curved=True).inclination(s))) if len(s) else 0.0
    if turn > WIDEST_PLANE and not surface.curved:
        yield (f"the surface turns by {turn:.2g} rad across the patch, which lies in a plane: "
               'patches = "curved" follows the surface')


def _divided(patch: SolvedPatch) -> Iterator[str]:
    """Doubts about contacts apart from each other that share the grid of one patch."""
    loaded = np.flatnonzero(np.asarray(patch.result.coupled.fields["pressure"]).any(axis=0))
    parts = np.split(loaded, np.flatnonzero(np.diff(loaded) > 1) + 1)
    if len(parts) > 1:
        y = 1e3 * sign_of(patch.side) * patch.bearing.patch.places(-patch.result.coupled.y)[:, 1]
        yield (f"it holds {len(parts)} contacts, at y = {' and '.join(f'{y[part].mean():.4g}' for part in parts)} mm, on one "
               f"grid: the narrowest is {min(map(len, parts))} elements wide; compare pressures with a finer numerics.grid")


def _in_own_axes(warning: str) -> str:
    """A `warning` of the contact in a patch, which knows no track."""
    return warning.replace(" y = ", " y (in the axes of its result) = ")


def _record(patch: SolvedPatch, errors: Mapping[str, float]) -> dict[str, Any]:
    """Place, forces, creepages and the scalars of a patch in track axes, in the units of their names, and their `errors`."""
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
    record |= of_result
    return record | {"status": patch.result.status, "error": {name: e for name, e in errors.items() if name in record}}


@dataclass(frozen=True)
class _Whole:
    """Scalars of a whole wheelset, and the errors of these and of its patches."""

    solved: SolvedWheelset

    @property
    def patches(self) -> tuple[SolvedPatch, ...]:
        return self.solved.patches

    def forces(self, side: SideName) -> Array:
        """Force on a rail in N, in track axes."""
        mirror = np.array([1.0, sign_of(side), 1.0])
        return sum((mirror * patch.forces.force for patch in self.patches if patch.side == side), np.zeros(3))

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
        scalars |= {name: sum(self.of_patches(own)) for name, own in SUMS.items()}
        rises = [rise for body in BODIES for rise in self.of_patches(f"temperature_rise_max_{body}_K") if not math.isnan(rise)]
        scalars["temperature_rise_max_K"] = max(rises, default=math.nan)
        scalars |= {name: max(self.of_patches(own), default=math.nan) for name, own in MAXIMA.items()}
        heat, power = scalars["Q_F_W"], sum(patch.forces.power for patch in self.patches)
        return scalars | {"power_balance_error": abs(heat + power) / heat if heat > 0.0 else 0.0}

    def of_patches(self, name: str) -> list[float]:
        """A scalar of the contacts of all patches."""
        return [patch.result.coupled.scalars[name] for patch in self.patches]

    def rolling_radius(self, side: SideName) -> float:
        """Distance of the patch with the largest load from the axle in m, nan without one."""
        mine = [patch for patch in self.patches if patch.side == side]
        return max(mine, key=lambda patch: patch.bearing.load).rolling_radius if mine else math.nan

    @property
    def unbalanced(self) -> Iterator[str]:
        """Which given vertical forces the rails do not carry: where a force jumps over the height, none has that value."""
        problem, scalars = self.solved.problem, self.scalars
        if problem.vertical is None:
            return
        share = 0.5 if problem.finds_roll else 1.0
        for place in ([f"{side}_" for side in problem.sides] if problem.finds_roll else [""]):
            force, wanted = scalars[f"track_force_z_{place}N"], share * problem.vertical
            if abs(force - wanted) > LARGEST_FORCE_ERROR * wanted:
                where = f"{place.rstrip('_')} rail carries" if place else "rails carry"
                yield f"the {where} {force:.6g} N, not {wanted:.6g} N: no height gives this force, which jumps there"

    @cached_property
    def shared(self) -> SharedErrors:
        return shared_errors(self.solved)

    @cached_property
    def patch_errors(self) -> list[dict[str, float]]:
        """Errors of the scalars of each patch: its own, and that of its load, with which they grow at most in proportion. The
        power of the creep forces has also that of the creepage, by the angular velocity."""
        ours = {contact: name for name, contact in IN_CONTACT.items()}
        errors = []
        for patch, load in zip(self.patches, self.shared.loads, strict=True):
            own = {ours.get(name, name): error + load for name, error in patch.result.error.items()} | {"normal_N": load}
            power = patch.result.coupled.scalars["T_gamma_N"]
            moved = abs(patch.forces.force[0]) * self.shared.velocity / power if power else 0.0
            errors.append({name: error + (moved if name in SUMS else 0.0) for name, error in own.items()})
        return errors

    @property
    def force_errors(self) -> dict[str, float]:
        """Errors of the forces on the rails over the vertical one. A vertical force that is given has none."""
        problem, vertical = self.solved.problem, max(abs(self.scalars["track_force_z_N"]), 1e-300)
        of_patches = [(patch.side, patch.force_errors + load * np.abs(patch.forces.force))
                      for patch, load in zip(self.patches, self.shared.loads, strict=True)]
        of_sides = {f"_{side}": sum((error for of, error in of_patches if of == side), np.zeros(3)) / vertical
                    for side in problem.sides}  # fmt: skip
        errors = of_sides | {"": sum(of_sides.values(), np.zeros(3))}
        given = set() if problem.vertical is None else {""} if problem.shares_load else set(errors)
        return {f"track_force_{axis}{side}_N": float(error) for side, of_axes in errors.items()
                for axis, error in zip(FORCES, of_axes, strict=True) if not (axis == "z" and side in given)}

    @property
    def errors(self) -> dict[str, float]:
        """Errors of the scalars: of forces over the vertical one, of the height over the largest approach, of lateral over
        vertical forces as they are, of others over themselves. What is given, or not there, has none."""
        solved, scalars = self.solved, self.scalars
        if not self.patches:
            return {}
        errors = self.force_errors
        if solved.problem.vertical is not None:
            errors["height_mm"] = 1e6 * self.shared.height / scalars["approach_max_um"]
        if solved.problem.finds_speed:
            errors["angular_velocity_rad_s"] = self.shared.velocity
        for side in solved.problem.sides:
            lateral, vertical = (errors.get(f"track_force_{axis}_{side}_N", 0.0) for axis in "yz")
            ratio, carried = scalars[f"lateral_over_vertical_{side}"], abs(scalars[f"track_force_z_{side}_N"])
            errors[f"lateral_over_vertical_{side}"] = (
                (lateral + abs(ratio) * vertical) * abs(scalars["track_force_z_N"]) / carried if carried else math.nan)
        for name, own in (SUMS | MAXIMA).items():
            moved = [patch[own] * value for patch, value in zip(self.patch_errors, self.of_patches(own), strict=True)]
            errors[name] = float(np.sum(moved) if name in SUMS else np.max(moved)) / (scalars[name] or math.nan)
        rises = [patch[f"temperature_rise_max_{body}_K"] for patch in self.patch_errors for body in BODIES]
        errors["temperature_rise_max_K"] = max((error for error in rises if not math.isnan(error)), default=math.nan)
        return errors
