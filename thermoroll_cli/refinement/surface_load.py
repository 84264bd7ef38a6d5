"""What acts on the surface of each body: pressure, traction and heat, with the signs of that body."""

from __future__ import annotations

from thermoroll_cli.problem.contact import Contact
from thermoroll_cli.steady_state.derived import DerivedQuantities
from thermoroll_cli.steady_state.discretisation import Discretisation
from thermoroll_cli.stress.superposition import SurfaceLoad

TRACTION_SIGNS = {"lower": -1.0, "upper": 1.0}
"""τ points along the slip of the lower body: it brakes the lower body and drives the upper one."""


def recirculating(derived: DerivedQuantities) -> tuple[str, ...]:
    """Bodies that bring heat of earlier passes back to the contact, whose surfaces are warmer than this pass makes them."""
    heating = derived.problem.heating
    tracks = {"lower": heating.lower_track, "upper": heating.upper_track}
    return tuple(body for body, track in tracks.items() if track is not None and heating.recirculates)


def surface_loads(
    discretisation: Discretisation, contact: Contact, bodies: tuple[str, ...], thermal: bool
) -> dict[str, SurfaceLoad]:
    """The loads of a steady state on each of the `bodies`, with heat if thermal stresses are wanted."""
    derived = discretisation.derived
    materials = {"lower": derived.problem.lower, "upper": derived.problem.upper}
    traction = contact.tangential.traction if contact.tangential.traction.any() else None
    loads = {}
    heated = dict(zip(materials, derived.heated_bodies(*contact.tangential.creepage), strict=True)) if thermal else {}
    heat_of_both = discretisation.heat(contact) if thermal else None
    rises = dict(zip(materials, heat_of_both.temperatures(), strict=True)) if heat_of_both is not None else {}
    for body in bodies:
        material = materials[body]
        plain = SurfaceLoad(contact.normal.pressure, traction, None, material.poisson_ratio, TRACTION_SIGNS[body])
        heat = None if heat_of_both is None else getattr(heat_of_both.into, body)
        if heat is None or not heat.any():
            loads[body] = plain
            continue
        moving = heated[body]
        assert material.expansion is not None
        loads[body] = SurfaceLoad(
            plain.pressure, traction, heat, material.poisson_ratio, plain.sign,
            thermal_modulus=material.youngs_modulus * material.expansion / (1.0 - material.poisson_ratio),
            conductivity=moving.conductivity, diffusivity=moving.diffusivity, speed=(moving.speed_x, moving.speed_y),
            surface_rise=None if body in recirculating(derived) else rises[body])
    return loads
