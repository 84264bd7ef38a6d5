"""One iteration of the article's Fig. 2: press → roll → heat → expand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from thermoroll_cli.arrays import Array
from thermoroll_cli.heat.frictional_heat import Heat
from thermoroll_cli.problem.contact import Contact
from thermoroll_cli.steady_state.discretisation import Discretisation
from thermoroll_cli.steady_state.friction import friction_of
from thermoroll_cli.steady_state.solver_options import Tolerances


def iterate(discretisation: Discretisation, state: Contact, tolerances: Tolerances) -> Contact:
    """Press the bodies together, roll them, compute the heat, and the displacements of the surfaces by heat and shear.

    `state` is the start of the iteration: the fields that act back on the contact (`UNKNOWNS` of `fixed_point`; None if not
    active), and pressure and tractions from which the solvers start. Returns the state with the pressure and tractions for
    these fields, and with the fields that follow from them. In the steady state both sets of fields are equal.
    """
    normal = discretisation.press(state.offset, state.normal, tolerances.normal)
    tangential = discretisation.roll(normal, state.tangential, tolerances.tangential, state.friction)
    rolled = replace(state, normal=normal, tangential=tangential)
    if state.shear_displacement is not None:
        rolled = replace(rolled, shear_displacement=discretisation.traction.coupling.normal_displacement(tangential.traction))
    if state.expansion is None and state.friction is None:
        return rolled
    heat = discretisation.heat(rolled)
    expansion = None if state.expansion is None else expansion_in(heat, rolled)
    friction = None if state.friction is None else friction_of(discretisation, heat)
    return replace(rolled, expansion=expansion, friction=friction)


def expansion_in(heat: Heat, contact: Contact) -> Array:
    """Thermal expansion u_z^t of both bodies in m, (nx, ny); its mean over the contact is removed, because the approach absorbs
    constants."""
    expansion = heat.expansion()
    return np.asarray(expansion - expansion[contact.normal.contact].mean())
