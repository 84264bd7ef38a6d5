"""Seeded contacts of bodies with transverse profiles: crowned rollers, lopsided shapes, two bumps, arcs of unlike radii that
meet with a kink in the curvature; what such shapes leave out: edges, places far from y = 0, conformal grooves, polygons,
profiles that end inside the contact, ridges of a few elements, roughness."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities, rubbed
from thermoroll_cli.problem.curved_patch import conformal_patch
from thermoroll_cli.problem.friction import Friction
from thermoroll_cli.problem.geometry import Geometry, Profile
from thermoroll_cli.problem.problem import Heating, Material, Motion, Numerics, Problem

KINDS = ("crown", "cubic", "bumps", "kink")
AWKWARD = ("edge", "off centre", "groove")
SHARP = ("polygon", "end")
NARROW = ("ridges",)
ROUGH = ("rough",)
WAVES, SHORTEST_WAVE, LONGEST_WAVE = 6, 0.08, 0.8
"""Waves of a rough profile, and their lengths over the half-width of the contact of the smooth one: from one element of 32, and
longer than four of 160, to nearly all of it."""
SPIN_SHARE, FORCED_SHARE, DISSIMILAR_SHARE, HEATED_SHARE, LOWER_SHARE = 0.3, 0.2, 0.15, 0.25, 0.3
POINTS, ROUGH_POINTS = 241, 4001
GRIDS = ((16, 16), (24, 24), (32, 32), (33, 47), (24, 64), (48, 48), (64, 32))


def random_profile_contact(seed: int, kinds: tuple[str, ...] = KINDS) -> Problem:
    """The contact of `seed`, always the same; its kind is `kinds[seed % len(kinds)]`, of `KINDS`, `AWKWARD`, `SHARP`,
    `NARROW` or `ROUGH`."""
    rng = np.random.default_rng([13, seed])
    while True:
        kind = kinds[seed % len(kinds)]
        problem = _groove(rng) if kind == "groove" else _rough(rng) if kind == "rough" else _drawn(rng, kind)
        try:
            scales = DerivedQuantities(problem).scales
        except ValueError:
            continue  # no contact is found
        ends = any(scales.ends) if kind == "end" else not all(scales.ends)
        if ends and scales.semi_axis_x < 0.3 * abs(1.0 / problem.geometry.curvature_x):
            return replace(problem, motion=_motion(rng, problem))


def profile_on_a_grid(seed: int, kinds: tuple[str, ...] = KINDS) -> Problem:
    """The contact of `seed` on one of `GRIDS`."""
    return replace(random_profile_contact(seed, kinds), numerics=Numerics(grid=GRIDS[seed % len(GRIDS)]))


def friction_across(seed: int) -> Problem:
    """A contact of `seed` with one to six shares of its friction at places inside the contact, at its rim and outside, some
    zero, some next to each other like a step. A third of the forces that are given exceed what friction may carry there."""
    rng = np.random.default_rng([43, seed])
    problem = replace(random_profile_contact(seed, (*KINDS, "off centre")), numerics=Numerics(grid=GRIDS[seed % len(GRIDS)]))
    scales = DerivedQuantities(problem).scales
    count = int(rng.integers(1, 7))
    y = np.sort(scales.centre + scales.semi_axis_y * rng.uniform(-1.5, 1.5, count))
    if count > 1 and rng.random() < 0.3:
        y[1] = y[0] + 1e-3 * scales.semi_axis_y
        y.sort()
    shares = np.where(rng.random(count) < 0.2, 0.0, rng.uniform(0.2, 1.0, count))
    shares[int(rng.integers(count))] = 1.0
    return rubbed(problem, list(zip(y.tolist(), shares.tolist(), strict=True)))


def shifted_profile(seed: int) -> tuple[Problem, Problem]:
    """A contact of `seed` with creepages of the contact point, and the same elsewhere: all profiles shifted as far as they have
    material at y = 0, with creepages of the contact point or of the origin."""
    rng = np.random.default_rng([31, seed])
    problem = replace(random_profile_contact(seed, (*KINDS, "off centre")), numerics=Numerics(grid=GRIDS[seed % len(GRIDS)]))
    problem = replace(problem, motion=replace(problem.motion, at="contact"))
    low, high = problem.geometry.limits
    shift = 0.9 * float(rng.uniform(-high, -low))
    there = {f"{body}_profile": replace(profile, offset=profile.offset + shift)
             for body, profile in problem.geometry.profiles}
    other = replace(problem, geometry=replace(problem.geometry, **there))  # type: ignore[type-var]
    if rng.random() < 0.5:
        along, across, spin = DerivedQuantities(other).kinematics.at_origin
        motion = replace(other.motion, at="origin", spin=spin, creepage_y=across,
                         creepage_x=None if other.motion.creepage_x is None else along)
        other = replace(other, motion=motion)
    return problem, other


def _drawn(rng: np.random.Generator, kind: str) -> Problem:
    half = _log(rng, -3.0, -1.7)
    profile = {"crown": _crown, "cubic": _cubic, "bumps": _bumps, "kink": _kink, "edge": _edge, "off centre": _off_centre,
               "polygon": _polygon, "end": _end, "ridges": _ridges}[kind](rng, half)
    radius_x = half * _log(rng, 0.3, 2.0)
    flat = math.inf
    geometry = Geometry(flat, flat, radius_x, flat, upper_profile=profile)
    if rng.random() < LOWER_SHARE:
        geometry = Geometry(radius_x, flat, flat, flat, lower_profile=profile)
    heated = bool(rng.random() < HEATED_SHARE)
    lower = _material(rng, heated)
    unlike = bool(rng.random() < DISSIMILAR_SHARE)
    upper = replace(lower, youngs_modulus=lower.youngs_modulus * _log(rng, -0.7, 0.7)) if unlike else lower
    load = lower.youngs_modulus * half**2 * _log(rng, -6.0, -3.5)
    heating = Heating(peclet=("rolling", "stationary")[int(rng.integers(2))]) if heated else Heating(heat=False)
    return Problem(lower, upper, geometry, load, Friction(float(rng.uniform(0.05, 0.6))), Motion(1.0), heating)


def _material(rng: np.random.Generator, heated: bool) -> Material:
    thermal = (50.0, 11.7e-6, 1e-5) if heated else (None, None, None)
    return Material(_log(rng, 0.5, 2.4) * 1e9, float(rng.uniform(0.1, 0.45)), *thermal)


def _motion(rng: np.random.Generator, problem: Problem) -> Motion:
    derived = DerivedQuantities(problem)
    size, angle = derived.saturation_creepage * _log(rng, -1.3, 0.7), float(rng.choice([0.0, rng.uniform(0.0, 2.0 * math.pi)]))
    spin = float(rng.choice([-1.0, 1.0])) * size / derived.scales.semi_axis_y if rng.random() < SPIN_SHARE else 0.0
    motion = Motion(1.0, size * math.cos(angle), size * math.sin(angle), spin)
    if rng.random() < FORCED_SHARE:
        share = float(rng.uniform(-0.3, 0.3))
        motion = replace(motion, creepage_x=None, creepage_y=0.0, force_x=share * problem.traction_limit)
    return motion


def _crown(rng: np.random.Generator, half: float) -> Profile:
    flat = float(rng.choice([0.0, rng.uniform(0.1, 0.8)]))
    return Profile(length=2.0 * half, drop=half * _log(rng, -4.0, -3.0), flat=2.0 * half * flat)


def _cubic(rng: np.random.Generator, half: float) -> Profile:
    lean = float(rng.uniform(-0.25, 0.25))
    return _points(lambda t: -(t**2) - lean * t**3, half, half * _log(rng, -1.6, -0.5))


def _bumps(rng: np.random.Generator, half: float) -> Profile:
    lean, place = float(rng.uniform(-0.04, 0.04)), float(rng.uniform(0.35, 0.6))
    return _points(lambda t: -((1.0 - (t / place) ** 2) ** 2) * place**2 + lean * t, half, half * _log(rng, -2.0, -1.0))


def _kink(rng: np.random.Generator, half: float) -> Profile:
    ratio, place = _log(rng, 0.2, 1.0), float(rng.uniform(-0.1, 0.1))
    place = round(0.5 * place * (POINTS - 1)) / (0.5 * (POINTS - 1))

    def arcs(t: np.ndarray) -> np.ndarray:
        return np.where(t < place, -0.5 * (t - place) ** 2, -0.5 * ratio * (t - place) ** 2)

    return _points(arcs, half, half * _log(rng, -1.6, -0.7))


def _edge(rng: np.random.Generator, half: float) -> Profile:
    """Two straight lines that meet at y = 0 or beside it."""
    place, steep = float(rng.choice([0.0, rng.uniform(-0.2, 0.2)])), _log(rng, -3.0, -1.7)
    left, right = half * steep * (1.0 + place), half * steep * (1.0 - place) * float(rng.uniform(0.5, 2.0))
    return Profile(((-half, -left), (half * place, 0.0), (half, -right)), "linear")


def _off_centre(rng: np.random.Generator, half: float) -> Profile:
    """A lopsided arc that touches up to 0.8 of its half-width from y = 0."""
    return replace(_cubic(rng, half), offset=half * float(rng.uniform(-0.8, 0.8)))


def _polygon(rng: np.random.Generator, half: float) -> Profile:
    """Three to seven straight pieces of different lengths, about an arc."""
    t = np.sort(np.concatenate([[-1.0, 1.0], rng.uniform(-0.8, 0.8, int(rng.integers(2, 7)))]))
    return Profile(tuple(zip((half * t).tolist(), (-half * _log(rng, -3.0, -1.0) * t**2).tolist(), strict=True)), "linear")


def _end(rng: np.random.Generator, half: float) -> Profile:
    """An arc about a place within, beyond or at the end of the profile, so flat that the contact reaches one end or both."""
    place = float(rng.uniform(0.3, 1.3))
    return _points(lambda t: -((t - place) ** 2), half, half * _log(rng, -6.0, -3.0))


def _ridges(rng: np.random.Generator, half: float) -> Profile:
    """A wide arc with one to three sharp ridges beside it, on the grids here one to a few elements wide."""
    t = np.linspace(-1.0, 1.0, 8 * POINTS + 1)
    shape = -((t + 0.4) ** 2) / _log(rng, 0.0, 1.0)
    for _ in range(int(rng.integers(1, 4))):
        height, place = float(rng.choice([0.0, rng.uniform(-1e-3, 1e-3)])), float(rng.uniform(0.1, 0.8))
        shape = np.maximum(shape, height - (t - place) ** 2 / _log(rng, -2.5, 0.0))
    return Profile(tuple(zip((half * t).tolist(), (0.5 * half * shape).tolist(), strict=True)))


def _rough(rng: np.random.Generator) -> Problem:
    """A lopsided arc with waves of random lengths, each of which alone would change the pressure by up to a half of the largest
    one of the smooth arc: E* π h/λ. Without heat, which takes minutes on so many lobes."""
    problem = replace(_drawn(rng, "cubic"), heating=Heating(heat=False))
    smooth = DerivedQuantities(problem).scales
    (body, profile), = problem.geometry.profiles
    y, z = np.array(profile.points).T
    fine = np.linspace(y[0], y[-1], ROUGH_POINTS)
    height = np.interp(fine, y, z)
    for _ in range(WAVES):
        length = smooth.semi_axis_y * _log(rng, math.log10(SHORTEST_WAVE), math.log10(LONGEST_WAVE))
        amplitude = smooth.peak_pressure * length / (math.pi * problem.contact_modulus) * _log(rng, -2.0, math.log10(0.5))
        height += amplitude * np.cos(2.0 * math.pi * (fine / length + rng.random()))
    rough = replace(profile, points=tuple(zip(fine.tolist(), height.tolist(), strict=True)))
    return replace(problem, geometry=replace(problem.geometry, **{f"{body}_profile": rough}))  # type: ignore[type-var]


def _groove(rng: np.random.Generator) -> Problem:
    """A ball in a groove that follows it, up to half a radian to either side."""
    radius, half = _log(rng, -3.0, -1.7), float(rng.uniform(0.05, 0.45))
    geometry = Geometry(float(rng.choice([math.inf, 4.0 * radius])), -radius * float(rng.uniform(1.02, 1.3)), radius, radius)
    body = _material(rng, heated=False)
    problem = Problem(body, body, geometry, 1.0, Friction(float(rng.uniform(0.05, 0.4))), Motion(1.0), Heating(heat=False))
    load = (half * radius / DerivedQuantities(problem).scales.semi_axis_y) ** 3
    return replace(problem, normal_force=load, geometry=conformal_patch(geometry, problem.compliance_shares))


def _points(shape: Callable[[np.ndarray], np.ndarray], half: float, height: float) -> Profile:
    t = np.linspace(-1.0, 1.0, POINTS)
    return Profile(tuple(zip((half * t).tolist(), (height * shape(t)).tolist(), strict=True)))


def _log(rng: np.random.Generator, low: float, high: float) -> float:
    return float(10.0 ** rng.uniform(low, high))
