"""Errors of the height and of the angular velocity of a wheelset and of the loads of its patches, from those of its patches."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from thermoroll_cli.problem.scalar_errors import passed_on
from thermoroll_cli.wheelset.one_wheel import BALANCED, STIFFENING
from thermoroll_cli.wheelset.patch_problem import SolvedPatch
from thermoroll_cli.wheelset.solve_wheelset import FINE, SolvedWheelset


@dataclass(frozen=True)
class SharedErrors:
    """Errors of the `height` (m) and, if it is found, of the `roll` (rad), which is that of the heights of both wheels over the
    span; of the `loads` of all patches over themselves, and of the angular `velocity` over itself. 0 of what is given."""

    height: float
    roll: float
    loads: tuple[float, ...]
    velocity: float


def shared_errors(solved: SolvedWheelset) -> SharedErrors:
    """Errors of height and loads. With errors e of the approaches δ at the same loads W, and an error dz of the height,

        dW_i = k_i (dz cos α_i − e_i),      k_i = 1.5 W_i/δ_i.

    At a given height dz = 0. Patches that carry a given force together have dz = Σ k_j e_j/Σ k_j cos α_j, and at about the same
    inclination dW_i = k_i Σ k_j (e_j − e_i)/Σ k_j. Signs are unknown: absolute values add."""
    patches, finds_height = solved.patches, solved.problem.vertical is not None
    sunk, cosines = (np.array(column) for column in ([patch.bearing.sunk for patch in patches],
                                                     [math.cos(patch.bearing.patch.angle) for patch in patches]))
    stiffness = STIFFENING * np.array([patch.bearing.load for patch in patches]) / sunk
    estimated = sunk * np.array([patch.error_of("approach_um") / patch.result["approach_um"] for patch in patches])
    approach = estimated + sunk * np.array([_moved(patch) for patch in patches])
    heights, loads = [0.0], np.zeros(len(patches))
    for group in _carriers(solved):
        own = stiffness[group]
        by_approach = -np.eye(len(group))
        if finds_height:
            heights.append(float(passed_on(estimated[group], own / (own @ cosines[group]))))
            by_approach += own / own.sum()
            loads[group] = [_unbalanced(patches[i]) for i in group]
        loads[group] += STIFFENING / sunk[group] * passed_on(approach[group], by_approach)
    roll = sum(heights) / solved.problem.span if solved.problem.finds_roll else 0.0
    return SharedErrors(max(heights), roll, tuple(loads.tolist()), _velocity(solved, loads.tolist()))


def _velocity(solved: SolvedWheelset, loads: Sequence[float]) -> float:
    """Error of the angular velocity over itself: that of the forces along the track, and what the search left of them, over
    their change with it."""
    limit = sum(patch.result.problem.traction_limit for patch in solved.patches)
    if not solved.problem.finds_speed or not limit:
        return 0.0
    forces = sum(patch.force_errors(load)[0] for patch, load in zip(solved.patches, loads, strict=True))
    return float(forces / limit + max(FINE, solved.left)) / abs(solved.drive_slope)


def _carriers(solved: SolvedWheelset) -> Iterator[list[int]]:
    """Numbers of the patches that carry a force together: of both wheels if the roll is given."""
    sides = [patch.side for patch in solved.patches]
    for of in ([{side} for side in set(sides)] if solved.problem.finds_roll else [set(sides)]):
        if group := [k for k, side in enumerate(sides) if side in of]:
            yield group


def _unbalanced(patch: SolvedPatch) -> float:
    """Error of a load through its equilibrium with a vertical force: its tolerance, the last change of the ratio of both, and
    the error of the friction, which has a part in it."""
    friction = abs(math.sin(patch.angle)) * patch.error_of("force_y_N") / patch.bearing.load
    return BALANCED + abs(patch.solved.vertical / patch.bearing.vertical - 1.0) + friction


def _moved(patch: SolvedPatch) -> float:
    """Change of the approach over that of the coarse grid since the load was shared."""
    return abs(patch.solved.over_coarse / patch.bearing.over_coarse - 1.0)
