"""Scalars beyond the finest grids: what both tables of references are made of."""

from __future__ import annotations

from collections.abc import Iterable

from thermoroll_cli.problem.result import Result
from thermoroll_cli.refinement.error_estimates import EXTRAPOLATED


def extrapolated(coarse: Result, fine: Result, names: Iterable[str]) -> dict[str, float]:
    """Scalars of the coupled state, nine digits, from two grids of which one has twice the elements per side of the other."""
    values = {}
    for name in names:
        before, last = coarse.coupled.scalars[name], fine.coupled.scalars[name]
        # Integrals are reported extrapolated already.
        values[name] = float(f"{last if name in EXTRAPOLATED else last + (last - before) / 3.0:.9g}")
    return values
