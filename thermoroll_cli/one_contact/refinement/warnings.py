"""Warnings about solved contacts: what their grids do not resolve, temperatures that no solid survives, heat inside bodies and
sideways, several steady states, and thermal expansion along the surfaces.

**Expansion along the surfaces.** Heat makes a free surface rise by u_z and stretch along itself: the surface displacement of a
thermoelastic half-space (quasi-static, Goodier's potential plus Boussinesq's correction, m and n the wavenumbers along x and y,
w = sqrt(m² + n²)) is

    û_z = 2(1+ν)α T^/(w + w')      û_x = −(i m/w) û_z      û_y = −(i n/w) û_z       w'² = w² + i m s/κ,

which for material moving with speed s along x, since 1/(w + w') = κ (w' − w)/(i m s), is in real space

    ∂u_x/∂x = 2(1+ν)α κ/s · ∂(T − T_0)/∂x,      ∂u_y/∂x = 2(1+ν)α κ/s · ∂(T − T_0)/∂y

with T_0 the temperature that the same heat would make in material at rest (where the strains add up to (1+ν)αT). Bodies
alike in all this expand alike, and their slip does not feel it; the difference of two other bodies belongs into the slip
equation, ṡ/V = ξ − ∂u/∂x, but is left out: in realistic cases it is below one per cent of the creepage at which the contact
slides (docs/physics.md). There is a warning if it is more.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from thermoroll_cli.one_contact.refinement.level import Level
from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.physics.halfspace.coatings import THICK
from thermoroll_cli.physics.heat.frictional_heat import Heat
from thermoroll_cli.physics.heat.sliding_heat import SlidingHeatResponse
from thermoroll_cli.physics.numerics.grid import Grid
from thermoroll_cli.problem.curved_patch import CurvedPatch
from thermoroll_cli.problem.problem import BODIES, Layer, Material
from thermoroll_cli.tools.arrays import Array

LARGEST_RISE = 2000.0
"""K. Steel melts at 1500 °C, and no constant stays one that far."""
NO_SOLID = f"no solid stands {LARGEST_RISE:g} K with these constants"

SHARP_EDGE, ELEMENTS_TO_EDGE = 0.05, 4.0
"""Error of the largest pressure by an edge that is not resolved from which it is worth a warning; elements that resolve it."""
INNER_HEAT = 0.05
"""Share of all heat from which the heat that is made inside bodies is worth a warning."""
SIDEWAYS_SHARE = 0.1
"""Share of heat from sideways slip, times a Péclet number below one, from which its direction is worth a warning."""
RESOLVED_BORDER = 0.5
"""Part to which half-spaces describe a border within an element (`ShearCompliance.trust`), at least."""


def unresolved_coatings(derived: DerivedQuantities, grid: Grid) -> Iterator[str]:
    """Doubt about coatings as thin as an element, which matter at the border and for the stresses in them."""
    bodies, request, element = derived.bodies.at_once, derived.problem.subsurface, min(grid.dx, grid.dy)
    for body in () if request is None else request.bodies:
        for layer in getattr(derived.problem, body).layers[:1]:
            if layer.thickness < THICK * element:
                yield (f"the top layer of the {body} body's coating is {layer.thickness / element:.2g} elements thick: near "
                       "borders of contact and stick its stresses vary within elements; "
                       f"{_resolving(grid, layer.thickness)} would resolve them")
    coatings = (derived.problem.lower.elastic_layers, derived.problem.upper.elastic_layers)
    if not any(coatings) or bodies.near_border(grid.dx, grid.dy).shear.trust >= RESOLVED_BORDER:
        return
    thickness = min(layers[0].thickness for layers in coatings if layers)
    yield (f"the grid does not resolve the top layer of a coating, {thickness / element:.2g} elements thick: the contact ends "
           f"at the border of an element, which shows in areas; {_resolving(grid, thickness)} would resolve it")


def _resolving(grid: Grid, thickness: float) -> str:
    """The grid of which `THICK` elements are as thick as a layer of a coating."""
    finer = THICK * min(grid.dx, grid.dy) / thickness
    nx, ny = (math.ceil(finer * side) for side in grid.shape)
    return f"numerics.grid = {nx}" if nx == ny else f"numerics.grid = [{nx}, {ny}]"


def surface_of_substrates(derived: DerivedQuantities) -> Iterator[str]:
    """Doubt about a curved patch whose surface, and so its slip, was there before the share of its coatings was known."""
    geometry = derived.problem.geometry
    slips = derived.kinematics.has_traction and derived.problem.motion.differential_slip
    if not (slips and derived.bodies.dispersive and isinstance(geometry, CurvedPatch)):
        return
    taken, share = derived.problem.compliance_shares[0], derived.compliance_shares[0]
    slip = abs(share - taken) * derived.scales.approach * geometry.curvature_x / derived.saturation_creepage
    if slip > WORTH_TELLING:
        yield (f"the surface of this patch is curved by the shares of the substrates, {100.0 * taken:.0f} % for the lower "
               f"body; with its coatings that is {100.0 * share:.0f} %: slip by the shapes is wrong by up to "
               f"{100.0 * slip:.0f} % of the saturation creepage; a body all of the coating's material shows what this changes")


def warnings_after(derived: DerivedQuantities, level: Level, heat: Heat | None, edge: float) -> Iterator[str]:
    """Doubts about the state of a `level` with its `heat` (None: there is none); `edge` is the error of the largest pressure by
    an edge that is not resolved."""
    grid = level.here.grid
    if edge >= SHARP_EDGE:
        place, _ = derived.bodies.leading_edge(derived.scales.semi_axis_x)
        wanted = math.ceil(ELEMENTS_TO_EDGE * grid.dx / place * grid.nx)
        yield (f"the pressure has a maximum about {place * 1e6:.2g} µm behind the leading edge, {place / grid.dx:.2g} "
               f"elements, where the bodies have not relaxed yet: the largest pressure and traction may be "
               f"{100.0 * edge:.0f} % off; numerics.grid = [{wanted}, {grid.ny}] would resolve it")
    if heat is None:
        return
    scalars, fields = level.reported.scalars, level.reported.fields
    rises = fields["temperature_rise_lower"], fields["temperature_rise_upper"]
    if isinstance(heat.response, SlidingHeatResponse) and (total := float(heat.flux.sum())):
        slip, peclet = level.contact.tangential.slip, heat.response.mean_peclet(heat.flux)
        share = float(heat.flux[np.abs(slip[1]) > np.abs(slip[0])].sum()) / total
        if share * min(peclet, 1.0) > SIDEWAYS_SHARE:
            yield (f"{100 * share:.0f} % of the heat is made by sideways slip, at a mean Péclet number of {peclet:.2g}: "
                   'thermal.peclet = "sliding" carries all heat along x, whatever the direction of slip')
    if derived.kinematics.has_traction:
        stretched = tangential_expansion(derived, *rises) / derived.saturation_creepage
        if stretched > WORTH_TELLING:
            yield (f"the heated surfaces stretch along each other by about {100 * stretched:.0f} % of the saturation creepage: "
                   "the slip equation does not contain this part of the thermal expansion")
    if (highest := max(scalars[f"temperature_rise_max_{body}_K"] for body in BODIES)) > LARGEST_RISE:
        yield f"temperature rises by up to {highest:.4g} K: {NO_SOLID}"
    if derived.problem.relaxes:
        inside = scalars["hysteresis_W"]
        if (share := inside / (inside + scalars["Q_F_W"])) > INNER_HEAT:
            yield (f"{100.0 * share:.0f} % of all heat, {inside:.3g} W, is made inside bodies that relax: temperatures and "
                   "thermal expansion do not contain it")
    if level.contact.friction is not None:
        yield from feedback_warning(derived, rises, level.contact.friction)


def feedback_warning(derived: DerivedQuantities, rises: tuple[Array, Array], friction: Array) -> Iterator[str]:
    """If friction rises with temperature, a change of friction μ changes the temperature, and that the friction again. Several
    steady states are possible if the gain of this loop exceeds one. The temperature rise is in proportion to μ, so the gain is
    |dμ/dT| ΔT/μ, with the mean rise ΔT of both surfaces."""
    law, heating = derived.problem.friction, derived.problem.heating
    rise = 0.5 * (rises[0] + rises[1])
    without = rise * law.coefficient / np.where(friction > 0.0, friction, law.coefficient)  # with μ₀
    gain = -law.slope * float(without.max())
    hottest = 0.5 * (heating.bulk_lower + heating.bulk_upper) + law.maximum * float(without.max())
    if gain > 1.0 and hottest > law.start:
        yield (f"friction rises steeply with temperature: through its heat a change of friction causes one up to {gain:.2g} "
               "times as large, so there may be several steady states, and the start may decide which one is found; sweep "
               "rolling.speed_m_s up and down")


WORTH_TELLING = 0.02
"""Part of the saturation creepage from which the warning is given; the true gradient may be 2–3 times as large locally."""


def tangential_expansion(derived: DerivedQuantities, rise_lower: Array, rise_upper: Array) -> float:
    """Estimate of the largest |∂u/∂x| between the surfaces by their thermal expansion, from their temperature rises in K.

    Of each body (1+ν)α T · 2w/|w + w'| with w = 1/a0, that is 2/(1 + (1 + P²)^¼): within a factor of two of the closed
    form above for smooth heat and Péclet numbers P = V a0/κ up to 5000."""
    lower, upper = derived.problem.lower, derived.problem.upper
    difference = _strain_per_kelvin(derived, lower) * rise_lower - _strain_per_kelvin(derived, upper) * rise_upper
    return float(np.abs(difference).max())


def _strain_per_kelvin(derived: DerivedQuantities, body: Material) -> float:
    # Only in rolling mode does every point of the material pass at the same known speed.
    peclet = derived.peclet(body) if derived.problem.heating.peclet == "rolling" else 0.0
    parts: tuple[Material | Layer, ...] = (body, *body.layers)
    free = max((1.0 + part.poisson_ratio) * part.expansion for part in parts if part.expansion is not None)
    return free * 2.0 / (1.0 + (1.0 + peclet**2) ** 0.25)
