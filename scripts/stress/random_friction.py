"""Seeded contacts with friction that falls or rises with slip, memory and interlayers, and some of strength and wear."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from scripts.stress.random_contacts import random_contact
from scripts.stress.random_profiles import random_profile_contact
from thermoroll_cli.one_contact.refinement.plan import share_below
from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities, rubbed
from thermoroll_cli.physics.rolling.rolling_gradient import RollingGradient
from thermoroll_cli.problem.friction import Friction, FrictionLaw, Interlayer
from thermoroll_cli.problem.problem import Heating, Problem, Strength, SubsurfaceRequest, Wear, WornBody

WELL_POSED = 0.6
"""Criterion of falling friction without memory up to which there is one solution."""
STEEPEST = 10.0
"""Criterion with memory, at most."""
LAYER_SHARE, MEMORY_SHARE, WARM_SHARE, COMPLIANT_SHARE = 0.3, 0.5, 0.3, 0.5


def random_friction(seed: int, contact: Callable[[int], Problem] = random_contact) -> Problem:
    """The contact of `seed` with a law of friction, always the same: criterion up to 0.6, with memory up to 10."""
    rng = np.random.default_rng([11, seed])
    problem = contact(70000 + seed)
    if rng.random() > WARM_SHARE:
        problem = replace(problem, heating=Heating(heat=False))
    limit = float(rng.uniform(0.2, 0.9))
    layered = bool(rng.random() < LAYER_SHARE)
    remembers = layered or bool(rng.random() < MEMORY_SHARE)
    wanted = 10.0 ** rng.uniform(-2.0, math.log10(STEEPEST if remembers else WELL_POSED))
    kind = str(rng.choice(["exponential", "rational", "linear", "table"]))
    derived = DerivedQuantities(problem)
    a, b, own = derived.hertz.semi_axis_x, derived.hertz.semi_axis_y, _own_gradient(derived)
    # A law falls by `steepness` per half slip at most.
    steepness = {"exponential": math.log(2.0), "rational": 1.0, "linear": 0.5, "table": 1.0}[kind] * (1.0 - limit)
    half = derived.hertz.peak_pressure * problem.friction.coefficient * steepness * problem.motion.speed * own / wanted
    law = FrictionLaw(kind, limit, half)  # type: ignore[arg-type]
    if kind == "table":
        law = FrictionLaw("table", table=((0.0, 1.0), (0.5 * half, 0.5 * (1.0 + limit)), (2.0 * half, limit)))
    if remembers:
        size = math.sqrt(a * b) * derived.saturation_creepage
        if layered:
            # The layer shears by 0.1 to 3 times as much as the surfaces under the same traction.
            problem = replace(problem, interlayer=Interlayer(10.0 ** rng.uniform(-1.0, 0.5) * a * own))
            size = max(size, DerivedQuantities(problem).interlayer_shear * (1.0 - limit))
        law = replace(law, memory=size * 10.0 ** rng.uniform(0.0, 1.0), memory_slip=1e-3 * problem.motion.speed)
    return replace(problem, friction=replace(problem.friction, law=law))


def _own_gradient(derived: DerivedQuantities) -> float:
    """Displacement gradient of the contact as a single element, under unit traction, in 1/Pa."""
    shape = derived.scales.semi_axis_x, derived.scales.semi_axis_y
    return RollingGradient((1, 1), *shape, derived.bodies).self_gradient[0]


def random_yield(seed: int, contact: Callable[[int], Problem] = random_contact) -> Problem:
    """The contact of `seed` with a layer that yields at 0.2 to 0.95 of the largest Coulomb bound; half of them also shear
    elastically, and half harden or soften, by up to the bound itself. A force is at most nine tenths of what the layer carries
    before it has hardened, or half of that if it softens."""
    rng = np.random.default_rng([19, seed])
    problem = contact(110000 + seed)
    derived = DerivedQuantities(problem)
    share = float(rng.uniform(0.2, 0.95))
    bound = problem.friction.coefficient * derived.hertz.peak_pressure
    layer = 0.0
    if rng.random() < COMPLIANT_SHARE:
        layer = 10.0 ** float(rng.uniform(-1.0, 0.5)) * derived.saturation_creepage * derived.hertz.semi_axis_x / bound
    motion, carried = problem.motion, 0.9 * share_below(share, line=problem.line) * problem.traction_limit
    if motion.force_x is not None:
        motion = replace(motion, force_x=math.copysign(min(abs(motion.force_x), carried), motion.force_x))
    hardening = 0.0
    if rng.random() < 0.5:
        slip = max(float(np.hypot(motion.creepage_x or 0.0, motion.creepage_y or 0.0)), derived.saturation_creepage)
        hardening = 10.0 ** float(rng.uniform(-1.5, 0.5)) * bound / (slip * derived.hertz.semi_axis_x)
        if rng.random() < 0.3:
            hardening *= -0.3
            if motion.force_x is not None:
                motion = replace(motion, force_x=0.5 * motion.force_x)
    return replace(problem, motion=motion, interlayer=Interlayer(layer, share * bound, hardening))


def random_rising(seed: int, contact: Callable[[int], Problem] = random_contact) -> Problem:
    """The contact of `seed` with friction that rises with slip by up to three times, linearly or to a plateau in two pieces,
    over 0.03 to 30 times the slip of saturation; half of them over an interlayer. Without one, half of those that roll at given
    creepages fall again, as steeply as is well posed or less. Where there is heat friction also rises or falls by up to a third
    with temperature. A third of the forces that are given exceed μ₀W."""
    rng = np.random.default_rng([23, seed])
    problem = contact(130000 + seed)
    derived = DerivedQuantities(problem)
    if rng.random() > WARM_SHARE:
        problem = replace(problem, heating=Heating(heat=False))
    if rng.random() < COMPLIANT_SHARE:
        bound = problem.friction.coefficient * derived.scales.peak_pressure
        shear = derived.saturation_creepage * derived.scales.semi_axis_x
        problem = replace(problem, interlayer=Interlayer(10.0 ** float(rng.uniform(-1.0, 1.0)) * shear / bound))
    top = 1.0 + 10.0 ** float(rng.uniform(-2.0, 0.5))
    slip = 10.0 ** float(rng.uniform(-1.5, 1.5)) * derived.saturation_creepage * problem.motion.speed
    middle = float(rng.uniform(1.0, top))
    table = ((0.0, 1.0), (slip, top)) if rng.random() < 0.5 else ((0.0, 1.0), (0.3 * slip, middle), (slip, top))
    motion = problem.motion
    if not problem.interlayer.compliance and motion.force_x is None and rng.random() < 0.5:
        # The slip in which friction falls by its coefficient, at a criterion of one.
        one = derived.scales.peak_pressure * problem.friction.coefficient * problem.motion.speed * _own_gradient(derived)
        fall = float(rng.uniform(0.2, 1.0)) * (top - 0.5)
        table = (*table, (slip + fall * one / (WELL_POSED * 10.0 ** float(rng.uniform(-2.0, 0.0))), top - fall))
    friction = replace(problem.friction, law=FrictionLaw("table", table=table), slope=float(rng.uniform(-1e-4, 1e-4)))
    if motion.force_x is not None and rng.random() < 1.0 / 3.0:
        motion = replace(motion, force_x=math.copysign((1.0 + 0.5 * (top - 1.0)) * problem.traction_limit, motion.force_x))
    return replace(problem, friction=friction, motion=motion)


def random_from_zero(seed: int) -> Problem:
    """The contact of `seed` with differential slip and friction that begins at zero, or at 1e-6 to 0.3 of its largest,
    and rises over 0.03 to 30 times the slip of saturation; a third rise beyond a threshold only."""
    rng = np.random.default_rng([29, seed])
    problem = random_contact(150000 + seed)
    if rng.random() > WARM_SHARE:
        problem = replace(problem, heating=Heating(heat=False))
    relative = problem.geometry.curvature_y
    own = relative * float(rng.uniform(-3.0, 4.0))
    geometry = replace(problem.geometry, lower_radius_y=1.0 / (relative - own), upper_radius_y=1.0 / own)  # type: ignore[arg-type]
    problem = replace(problem, geometry=geometry, motion=replace(problem.motion, differential_slip=True))
    least = 0.0 if rng.random() < 0.25 else 10.0 ** float(rng.uniform(-6.0, -0.5))
    slip = 10.0 ** float(rng.uniform(-1.5, 1.5)) * DerivedQuantities(problem).saturation_creepage * problem.motion.speed
    middle = ((0.5 * slip, least),) if rng.random() < 1.0 / 3.0 else ()
    law = FrictionLaw("table", table=((0.0, least), *middle, (slip, 1.0), (1e3 * slip, 1.0)))
    return replace(problem, friction=replace(problem.friction, law=law))


def random_steps(seed: int) -> Problem:
    """The contact of `seed`, every fourth one of profiles, with friction that changes across it in a step, in a stripe of more
    or less friction, or in a spike, anywhere; stripes and ramps from 0.003 to 0.6 semi-axes wide, the lesser friction from none
    to 0.8 of the larger one. Forces are the same share of friction's limit."""
    rng = np.random.default_rng([31, seed])
    problem = random_profile_contact(3 * seed) if seed % 4 == 3 else random_contact(170000 + seed)
    scales = DerivedQuantities(problem).scales
    place, ramp, width = rng.uniform(-0.9, 0.9), *(10.0 ** rng.uniform((-4.0, -2.5), (-1.0, -0.2)))
    low, high = rng.permutation([0.0 if rng.random() < 0.2 else rng.uniform(0.0, 0.8), 1.0])
    step, spike = [(0.0, low), (ramp, high)], [(0.0, low), (0.5 * width, high), (width, low)]
    shape = (step, spike, [*step, (ramp + width, high), (2.0 * ramp + width, low)])[int(rng.integers(3))]
    points = [(scales.centre + scales.semi_axis_y * float(place + y), float(share)) for y, share in shape]
    stepped, motion = rubbed(problem, points), problem.motion
    if motion.force_x is not None:
        motion = replace(motion, force_x=motion.force_x * stepped.traction_limit / problem.traction_limit)
    return replace(stepped, motion=motion)


def random_strength(seed: int) -> Problem:
    """The contact of `seed` with strength and wear of both bodies."""
    rng = np.random.default_rng([13, seed])
    problem = random_contact(90000 + seed)
    modulus = DerivedQuantities(problem).hertz.peak_pressure
    weak, strong = (Strength(float(modulus * rng.uniform(0.15, 0.5)), float(rng.uniform(0.0, 0.4))) for _ in range(2))
    return replace(problem, subsurface=SubsurfaceRequest(lower_strength=weak, upper_strength=strong),
                   wear=Wear(WornBody(1e-15, 1.0), WornBody(3e-15, 2.0)))


def random_history(seed: int) -> Problem:
    """The contact of `seed`, of little friction and without heat, with a Dang Van stress that states outside the domain decide:
    the hydrostatic stress counts much."""
    rng = np.random.default_rng([43, seed])
    problem = random_contact(130000 + seed)
    friction = Friction(float(rng.choice([0.0, rng.uniform(0.0, 0.1)])))
    strength = Strength(0.3 * DerivedQuantities(problem).hertz.peak_pressure, float(rng.uniform(0.3, 0.7)))
    force_free = replace(problem.motion, creepage_x=problem.motion.creepage_x or 0.0, force_x=None)
    return replace(problem, friction=friction, heating=Heating(heat=False), motion=force_free,
                   subsurface=SubsurfaceRequest(("lower",), layers=16, lower_strength=strength, thermal=False))
