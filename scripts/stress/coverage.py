"""Error estimates held against the truth: each case is solved on coarse grids and on one several times as fine.

A pair is one scalar of one case; it is covered if its true error does not exceed the estimate. Random contacts and those of
the whole range are judged together by families of scalars, each other population as a family of its own.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from scripts.stress.checks import solved
from scripts.stress.outcome import Outcome, Pair
from tests.support.errors import relative
from thermoroll_cli.problem.names import SCALARS, STRENGTH_SCALARS, of_kind
from thermoroll_cli.problem.problem import Problem
from thermoroll_cli.problem.scalar_errors import error_scale
from thermoroll_cli.python_api import solve

GRIDS, REFERENCE, FINER = (32,), 160, 3
"""Elements per side, and those of the grid that stands for the truth: at least so many, and at least so many times as fine as
the finest other one. Below the surface its layers double, too."""
FEW_LAYERS = 16
HISTORY_GRID, HISTORY_REFERENCE = 24, 72
"""Elements per side for histories that go on outside the domain, the fewest with estimates from three grids, and those for the
truth on a domain of the same width."""
EXACT = 2e-6
"""A smaller true error is none: such pairs would make the median of estimate over true error look large."""
ROUNDING = 1e-12
COVERED, SHORT, SHORT_BY_TEN, MEDIAN, FAMILY_MEDIAN = 0.95, 0.01, 1.0 / 2000.0, 8.0, 12.0
INTERVALS, HELD = ("fits of two values", "fits of three values"), (0.90, 0.99)
"""Populations whose pairs are 95 % intervals, and the share of them that must hold the truth: no estimates of errors."""
DERIVED = ("T_gamma_N", "T_gamma_N_mm", "contact_area_mm2", "contact_width_mm", "pressure_max_MPa", "stick_area_mm2",
           "stick_width_mm", "surface_temperature_max_lower_K",
           "surface_temperature_max_upper_K")
"""Scalars whose error is that of another one."""
OF_PROFILES = "contact_area_mm2", "pressure_max_MPa"
"""Those of them that it is not without a Hertz ellipse: shares relate to what is found on the same grid."""

TOGETHER = ("coverage of random contacts", "coverage of contacts")
FAMILIES: dict[str, Sequence[str]] = {
    "integrals": of_kind("integral", "exchanged heat", "resultant"), "creepages found": of_kind("creepage"),
    "areas": of_kind("area", "relative area"), "stick": of_kind("stick"), "maxima": of_kind("peak", "peak flux"),
    "pressure, approach": of_kind("pressure", "peak pressure", "relative peak pressure"),
}
OTHERS = "temperatures, expansion"


def family(outcome: Outcome, pair: Pair) -> str:
    """The family by which a pair is judged."""
    if outcome.population not in TOGETHER:
        return outcome.population
    return next((name for name, scalars in FAMILIES.items() if pair.scalar in scalars), OTHERS)


def shortfall(pair: Pair) -> float:
    """True error over estimate; what symmetry makes zero has an estimate of zero and rounding for an error."""
    return 0.0 if pair.true < ROUNDING else pair.true / pair.estimate if pair.estimate > 0.0 else math.inf


def covered(problem: Problem, *grids: int | tuple[int, int]) -> Outcome:
    """Solve and check `problem` on the first of `grids` (default `GRIDS`); with its pairs, unless it does not converge or need
    not."""
    grids = grids or GRIDS
    outcome = solved(_on(problem, grids[0]))
    return replace(outcome, pairs=tuple(pairs_of(problem, *grids))) if outcome.converged and not outcome.excused else outcome


def covered_beyond(problem: Problem, *_: int) -> Outcome:
    """Solve and check `problem`, and compare its strength on a coarse grid with that of a domain twice as wide."""
    outcome = solved(_on(problem, HISTORY_GRID))
    if not outcome.converged or outcome.excused:
        return outcome
    return replace(outcome, pairs=tuple(pairs_of(problem, HISTORY_GRID, reference=HISTORY_REFERENCE, wider=2)))


def pairs_of(
    problem: Problem, *grids: int | tuple[int, int], reference: int | None = None, wider: int = 1
) -> Iterator[Pair]:
    """The pairs of `problem` on `grids` (elements per side, or along and across), against a grid of `reference` elements per
    side; none if it does not converge. With a domain `wider` than the problem's, those of strength alone."""
    reference = reference or max(REFERENCE, *(FINER * _side(grid) for grid in grids))
    solved_on = {grid: solve(_on(problem, grid)) for grid in grids}
    wide = replace(problem, numerics=replace(problem.numerics, extent=wider * problem.numerics.extent))
    fine = solve(_on(_with_layers_between(wide), wider * reference))
    if not all(result.converged for result in (fine, *solved_on.values())):
        return
    truth = fine.summary()
    for grid, coarse in solved_on.items():
        summary = coarse.summary()
        names = tuple(coarse.subsurface.scalars) if coarse.subsurface is not None else tuple(coarse.coupled.scalars)
        if problem.wear is not None or wider > 1:
            names = tuple(name for name in (*names, *SCALARS) if name in STRENGTH_SCALARS or name.startswith("wear_"))
        for name in names:
            scale, estimate = error_scale(name, summary), relative(summary).get(name, math.nan)
            # The fine grid may lack a maximum below the surface that the coarse one has: that error is not known.
            own = name not in DERIVED or (name in OF_PROFILES and not problem.geometry.elliptic)
            if own and math.isfinite(estimate) and scale > 0.0 and math.isfinite(truth[name]):
                yield Pair(_side(grid), name, estimate, abs(summary[name] - truth[name]) / scale)


def _side(grid: int | tuple[int, int]) -> int:
    """Elements per side of a square grid with about as many elements, a power of two for slender grids."""
    return grid if isinstance(grid, int) else 2 ** round(0.5 * math.log2(grid[0] * grid[1]))


def _on(problem: Problem, grid: int | tuple[int, int]) -> Problem:
    shape = (grid, grid) if isinstance(grid, int) else grid
    return replace(problem, numerics=replace(problem.numerics, grid=shape, accuracy=None))


def _with_layers_between(problem: Problem) -> Problem:
    """The problem with further layers between any two layers below the surface, and with more than `FEW_LAYERS`."""
    if problem.subsurface is None:
        return problem
    layers = problem.subsurface.layers or len(next(iter(solve(_on(problem, 16)).bodies.values())).depths)
    layers = 2 * layers - 2
    while layers <= FEW_LAYERS:
        layers = 2 * layers - 2
    return replace(problem, subsurface=replace(problem.subsurface, layers=layers))


Judged = tuple[str, Pair]
"""A family and one of its pairs."""


def _judged(outcomes: list[Outcome]) -> list[Judged]:
    return [(family(outcome, pair), pair) for outcome in outcomes for pair in outcome.pairs]


def table(outcomes: list[Outcome]) -> str:
    """In Markdown, by family and grid: pairs, covered, short by three and ten times, median of estimate over true error."""
    judged = _judged(outcomes)
    apart = {name for name, _ in judged} - {*FAMILIES, OTHERS}
    lines = [["", "N", "pairs", "covered", "short by 3", "by 10", "median"], ["---", *["---:"] * 6]]
    for name, families in ({name: {name} for name in (*FAMILIES, OTHERS)} | {"**all of these**": {*FAMILIES, OTHERS}}
                           | {name: {name} for name in sorted(apart)}).items():  # fmt: skip
        some = [pair for own, pair in judged if own in families]
        for n in sorted({pair.grid for pair in some}):
            lines.append([name.removeprefix("coverage ").removeprefix("of "), str(n),
                          *_figures([pair for pair in some if pair.grid == n])])
    return "".join("| " + " | ".join(cells) + " |\n" for cells in lines)


def _figures(some: list[Pair]) -> list[str]:
    short = np.array([shortfall(pair) for pair in some])
    return [str(len(some)), f"{np.mean(short <= 1.0):.1%}", f"{np.mean(short > 3.0):.1%}", str(int((short > 10.0).sum())),
            "" if math.isnan(median := _median(some)) else f"{median:.1f}"]


def _median(some: list[Pair]) -> float:
    inexact = [pair.estimate / pair.true for pair in some if pair.true > EXACT]
    return float(np.median(inexact)) if inexact else math.nan


def missed(outcomes: list[Outcome]) -> list[str]:
    """Targets that were not met, and the worst pairs."""
    judged, found = _judged([o for o in outcomes if o.population not in INTERVALS]), []
    for name in INTERVALS:
        held = [shortfall(pair) <= 1.0 for outcome in outcomes if outcome.population == name for pair in outcome.pairs]
        if held and not HELD[0] <= np.mean(held) <= HELD[1]:
            found.append(f"{name}: {np.mean(held):.1%} of {len(held)} intervals hold the truth")
    for name in sorted({name for name, _ in judged}):
        some = [pair for own, pair in judged if own == name]
        short = np.array([shortfall(pair) for pair in some])
        # One more pair than the share allows: a few pairs tell no shares.
        if (short > 1.0).sum() > math.ceil((1.0 - COVERED) * len(some)) or (short > 3.0).sum() > math.ceil(SHORT * len(some)):
            found.append(f"{name}: {np.mean(short <= 1.0):.1%} covered, {np.mean(short > 3.0):.1%} short by three times")
        if _median(some) > FAMILY_MEDIAN:
            found.append(f"{name}: median of estimate over true error {_median(some):.1f}")
    worst = [f"short by ten times: {outcome.population} {outcome.seed}, {pair}"
             for outcome in outcomes if outcome.population not in INTERVALS
             for pair in outcome.pairs if shortfall(pair) > 10.0]
    found += worst if len(worst) > math.ceil(SHORT_BY_TEN * len(judged)) else []
    if (median := _median([pair for _, pair in judged])) > MEDIAN:
        found.append(f"all: median of estimate over true error {median:.1f}")
    return found
