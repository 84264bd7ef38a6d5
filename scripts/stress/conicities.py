"""Seeded wheelsets on tracks whose equivalent conicity is computed, and what must hold of each."""

from __future__ import annotations

import copy
from dataclasses import dataclass
from typing import Any

import numpy as np

from scripts.stress.outcome import Outcome
from scripts.stress.wheelsets import RAILS, ROOT, WHEELS, worn_wheel
from thermoroll_cli import Case, conicity
from thermoroll_cli.many_contacts.wheelset.conicity import Conicity
from thermoroll_cli.problem.geometry import Unsolvable

EXACT, SAME = 1e-6, 1e-6
"""Relative departure of the conicity from a cone's, and of a mirrored wheelset from itself."""
WITHIN = 0.03, 0.01
"""Relative and absolute departure of a conicity from one that is integrated over its table."""
CONE = (-60.0, 60.0)
"""Ends (mm) of a wheel that is a cone."""


@dataclass(frozen=True)
class Track:
    """The tables of a wheelset on a track, the amplitudes (mm), and the conicity of wheels that are cones, nan of others."""

    content: dict[str, Any]
    amplitudes: list[float]
    cone: float


def random_track(seed: int) -> Track:
    """Pairs of shipped outlines, alike or not, or cones on them; any gauge, cant, radii and amplitudes."""
    rng = np.random.default_rng([53, seed])
    rails = [RAILS[rng.integers(len(RAILS))] for _ in range(2 if rng.random() < 0.3 else 1)]
    wheel, distance, back = WHEELS[rng.integers(len(WHEELS))]
    cone = float(rng.choice([0.01, 0.025, 0.05, 0.2])) if rng.random() < 0.3 else float("nan")
    profile: dict[str, Any] = {"file": str(ROOT / wheel)}
    if not np.isnan(cone):
        profile, back = {"points_mm": [[y, -cone * y] for y in CONE]}, -70.0
    radii = 460.0 + rng.uniform(-0.3, 0.3, 2) * (rng.random() < 0.4)
    return Track({
        "material": {"youngs_modulus_GPa": 210.0, "poisson_ratio": 0.28}, "load": {"friction_coefficient": 0.3},
        "rolling": {"speed_m_s": 1.0},
        "track": {"gauge_mm": 1435.0 + float(rng.uniform(-4.0, 20.0)), "cant": float(rng.choice([0.0, 0.025, 0.05])),
                  "left": {"rail_profile": {"file": str(ROOT / rails[0][0])}},
                  "right": {"rail_profile": {"file": str(ROOT / rails[-1][0])}}},
        "wheelset": {"nominal_radius_mm": 460.0, "vertical_N": 1e5, "flange_back_distance_mm": distance, "flange_back_mm": back,
                     "contact_distance_mm": float(rng.uniform(1200.0, 1600.0)), "wheel_profile": profile,
                     "left": {"nominal_radius_mm": float(radii[0])}, "right": {"nominal_radius_mm": float(radii[1])}},
    }, np.sort(rng.uniform(0.2, 9.0, int(rng.integers(1, 8)))).tolist(), cone)


def check(track: Track) -> Outcome:
    """A number, or nan and a warning; a cone has its own; the mirror image, and another distance of the contacts, change
    nothing."""
    try:
        found = conicity(Case.from_dict(track.content), track.amplitudes)
    except Unsolvable as cause:
        return Outcome(reason=str(cause), excused=True)
    broken, known = [], ~np.isnan(found.conicity)
    gaps = (known[1:] & ~known[:-1]).any() and not any("no motion has an amplitude" in text for text in found.warnings)
    if gaps or not (known.all() or found.warnings):
        broken.append(f"conicities {found.conicity} with the warnings {found.warnings}")
    if (found.conicity[known] <= 0.0).any():
        broken.append(f"conicities {found.conicity}")
    if not np.isnan(track.cone) and not np.allclose(found.conicity[known], track.cone, rtol=EXACT):
        broken.append(f"the cone of {track.cone} has {found.conicity}")
    other = conicity(Case.from_dict(mirrored(track.content)), track.amplitudes)
    if not _agree(found, other):
        broken.append(f"{found.conicity}, mirrored {other.conicity}")
    back = np.interp(-found.shifts, other.shifts, other.radius_difference) if len(other.shifts) else other.shifts
    if len(found.shifts) != len(other.shifts) or not np.allclose(back, -found.radius_difference, atol=1e-9):
        broken.append("the rolling radii of the mirror image are others")
    return Outcome(True, broken=tuple(broken))


def mirrored(content: dict[str, Any]) -> dict[str, Any]:
    """The wheelset seen from behind, at another distance of the contacts, on which the conicity does not depend."""
    other = copy.deepcopy(content)
    for name in ("track", "wheelset"):
        other[name]["left"], other[name]["right"] = content[name]["right"], content[name]["left"]
    other["wheelset"]["contact_distance_mm"] = 2900.0 - content["wheelset"]["contact_distance_mm"]
    return other


def _agree(one: Conicity, other: Conicity) -> bool:
    return bool(np.allclose(one.conicity, other.conicity, rtol=SAME, atol=0.0, equal_nan=True))


def by_integration(shifts: np.ndarray, difference: np.ndarray, amplitude: float, product: float) -> float:
    """tan γ_e of Klingel's wave at an `amplitude` (m), y'' = −Δr/(e r₀), followed step by step from the side where it turns:
    the orbit around the least of the potential that spans twice the amplitude."""
    y = np.linspace(shifts[0], shifts[-1], 40001)
    dr = np.interp(y, shifts, difference)
    level = np.concatenate(([0.0], np.cumsum(0.5 * np.diff(y) * (dr[1:] + dr[:-1]))))
    bottom = int(np.argmin(level))
    # Places on the left at least as high as all between them and the bottom, and the last ones on the right that are no higher.
    left, right = level[: bottom + 1][::-1], np.maximum.accumulate(level[bottom:])
    turns = bottom - np.flatnonzero(left >= np.maximum.accumulate(left))
    ends = bottom + np.searchsorted(right, level[turns], side="right") - 1
    k, end = next((k, end) for k, end in zip(turns, ends, strict=True) if end + 1 < len(y) and y[end] - y[k] >= 2.0 * amplitude)
    inside = level[k] - level[k + 1 : end]
    # x = ∫ dy/√(2 (E − S)/(e r₀)); the steps at the turning points by their slope.
    whole = float((np.diff(y)[0] / np.sqrt(2.0 * np.maximum(inside, 1e-30) / product)).sum())
    for place in (k, end):
        whole += float(np.sqrt(2.0 * np.diff(y)[0] * product / max(abs(dr[place]), 1e-12)))
    return float((np.pi / (2.0 * whole)) ** 2 * 2.0 * product)


@dataclass(frozen=True)
class WornTrack:
    """The tables of a wheelset whose wheels look measured, and the amplitudes (mm)."""

    content: dict[str, Any]
    amplitudes: list[float]


def worn_track(seed: int) -> WornTrack:
    """A track under wheels as instruments find them (`worn_wheel`)."""
    rng = np.random.default_rng([59, seed])
    profile, back = worn_wheel(rng)
    rail, cant = RAILS[rng.integers(len(RAILS))]
    return WornTrack({
        "material": {"youngs_modulus_GPa": 210.0, "poisson_ratio": 0.28}, "load": {"friction_coefficient": 0.3},
        "rolling": {"speed_m_s": 1.0},
        "track": {"rail_profile": {"file": str(ROOT / rail)}, "cant": cant,
                  "gauge_mm": 1435.0 + float(rng.uniform(-3.0, 10.0))},
        "wheelset": {"nominal_radius_mm": 460.0, "vertical_N": 1e5, "flange_back_mm": back, "wheel_profile": profile},
    }, [1.0, 2.0, 3.0, 5.0])


def check_worn(track: WornTrack) -> Outcome:
    """Each number is that of Klingel's wave, followed step by step over the table of the rolling radii; else a warning says
    why."""
    found = conicity(Case.from_dict(track.content), track.amplitudes)
    broken = [] if np.isfinite(found.conicity).all() or found.warnings else [f"conicities {found.conicity} without a warning"]
    product = found.problem.contact_distance * found.mean_radius
    for amplitude, value in zip(found.amplitudes, found.conicity, strict=True):
        if np.isfinite(value) and value > 0.0:
            expected = by_integration(found.shifts, found.radius_difference, amplitude, product)
            if abs(value - expected) > WITHIN[0] * expected + WITHIN[1]:
                broken.append(f"{value:.4f} at {1e3 * amplitude:g} mm, by integration {expected:.4f}")
    return Outcome(True, broken=tuple(broken))
