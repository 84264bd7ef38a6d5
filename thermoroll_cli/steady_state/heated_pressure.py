"""The pressure in balance with its own heat: heat is proportional to pressure, so both are solved for together.

The heat flux q and the pressure p of an iteration give the heat per pressure w = q/p on the contact, which depends on slip and
friction. Let E be the expansion by heat, and keep all parts that are not proportional to the pressure (uneven shares of the
bodies, conduction, shear of dissimilar bodies, the correction by the resolved border). The state after the next iteration then
solves

    (A − E[w ·]) p = δ − h + r,     r = E[q] − E[w p] + displacement by shear + (A p − δ + h − u on the contact)

where the last term is zero except in border elements. In the steady state this changes nothing: it is a step towards the same
fixed point that includes the dependence of the heat on the pressure, which mixing would only learn over many iterations.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from thermoroll_cli.arrays import Array
from thermoroll_cli.contact.heated_contact import HeatedContactSolver
from thermoroll_cli.heat.heat_response import DividedHeat
from thermoroll_cli.problem.contact import Contact
from thermoroll_cli.steady_state.discretisation import Discretisation


@dataclass(frozen=True)
class HeatedStep:
    """`pressure` of whole elements (Pa) and `expansion` (m), (nx, ny), the start of the next iteration; `reached` is the share
    of the heat at which such a state was found, `applications` the cost; `raised` says whether the heat was raised from
    zero."""

    pressure: Array
    expansion: Array
    reached: float
    applications: int
    converged: bool
    raised: bool


def heated_step(discretisation: Discretisation, before: Contact, after: Contact, tolerance: float) -> HeatedStep:
    """Pressure and expansion in balance, from the iteration that led from `before` to `after`, solved to `tolerance` of the
    elastic displacement."""
    assert before.expansion is not None and after.expansion is not None
    normal, heat = after.normal, discretisation.heat(after)
    contact = normal.contact
    loaded = contact & (normal.pressure > 0.0)
    per_pressure = np.where(loaded, heat.flux / np.where(loaded, normal.pressure, 1.0), 0.0)
    share = heat.mean_share if np.isfinite(heat.mean_share) else 0.5

    def expand(pressure: Array) -> Array:
        return heat.response.displacement(DividedHeat(per_pressure * pressure, share))

    rest = after.expansion - expand(normal.pressure)
    offset = before.offset
    assert offset is not None
    defect = np.where(contact, normal.displacement + discretisation.pressure.undeformed_gap - offset - normal.approach, 0.0)
    beside = 0.0 if after.shear_displacement is None else after.shear_displacement
    gap = discretisation.pressure.undeformed_gap - rest - beside - defect
    solver = HeatedContactSolver(discretisation.pressure.solver, expand, gap, discretisation.derived.problem.normal_force)
    found = solver.continued(normal.pressure, tolerance)
    # If no contact is found even without heat, the result does not limit the heat.
    reached = found.reached if found.reached > 0.0 else 1.0
    return HeatedStep(found.pressure, found.expansion + rest, reached, found.applications, found.converged, found.raised)
