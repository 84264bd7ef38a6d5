"""What each patch of a contact carries: profiles may touch at several places across the rolling direction."""

from __future__ import annotations

import numpy as np

from thermoroll_cli.numerics.peak import peak_inside
from thermoroll_cli.problem.contact import Contact
from thermoroll_cli.steady_state.discretisation import Discretisation


def patches_of(discretisation: Discretisation, contact: Contact) -> list[dict[str, float]]:
    """Of each patch, from −y to +y: where its pressure acts, its forces, area and largest pressure, in the units of the names.

    Patches are separated by columns of elements without contact: the gap is a function of x plus one of y, so no patch lies
    beside another along x."""
    grid, normal = discretisation.grid, contact.normal
    loaded = np.flatnonzero(normal.contact.any(axis=0))
    out = []
    for columns in np.split(loaded, np.flatnonzero(np.diff(loaded) > 1) + 1):
        here = np.zeros(grid.ny, dtype=bool)
        here[columns] = True
        pressure, covered = normal.pressure * here, normal.covered * here
        force = (contact.tangential.traction * here).sum(axis=(1, 2)) * grid.element_area
        out.append({
            "y_mm": float((pressure.sum(axis=0) * grid.y).sum() / pressure.sum()) * 1e3,
            "normal_N": float(pressure.sum()) * grid.element_area,
            "force_x_N": float(force[0]),
            "force_y_N": float(force[1]),
            "area_mm2": float(covered.sum()) * grid.element_area * 1e6,
            "pressure_max_MPa": peak_inside(pressure, covered, discretisation.at_ends) * 1e-6,
        })
    return out
