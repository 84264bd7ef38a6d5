"""The state without thermal deformation: Hertz pressure for similar bodies, a fixed point of pressure and shear for others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from thermoroll_cli.pipeline.contact import Contact, Pressure, Traction
from thermoroll_cli.pipeline.coupling import Coupled, Tolerances, couple, isothermal
from thermoroll_cli.pipeline.level import Level
from thermoroll_cli.solvers.prolongation import Prolongation

FIRST_GUESS = 1e-2
"""Residual at which the tractions under the Hertz pressure are good enough to start from."""


def mechanical(
    level: Level, starts: Sequence[Traction], tolerances: Tolerances, before: tuple[Level, Contact] | None
) -> tuple[Contact, Coupled | None]:
    """State without thermal deformation from the best of `starts`, and the account of its iterations.

    Shear between dissimilar bodies (Dundurs' β ≠ 0) changes the pressure; then, and only then, there are iterations: they
    start from the state on the level `before` (a coarser grid, or this one in an earlier problem)."""
    if not level.scene.feeds_back:
        return isothermal(level, starts, tolerances.tangential), None
    if before is None:
        guess, offset = isothermal(level, starts, FIRST_GUESS), np.zeros(level.grid.shape)
    else:
        coarse, contact = before
        guess = Contact(_pressure_guess(level, coarse, contact), starts[0])
        offset = Prolongation(coarse.grid, level.grid)(contact.offset)
    feedback = couple(level, guess, offset, tolerances, heated=False)
    return feedback.contact, feedback


def _pressure_guess(level: Level, coarse: Level, contact: Contact) -> Pressure:
    """Hertz pressure plus what shear has changed of it on another grid: the steep border need not be interpolated."""
    change = contact.normal.pressure - coarse.hertz.pressure
    pressure = np.maximum(level.hertz.pressure + Prolongation(coarse.grid, level.grid)(change), 0.0)
    return replace(level.hertz, pressure=np.where(level.hertz.covered > 0.3, pressure, 0.0))
