"""Plan of the stage below the surface: its depths, its heat, its cost."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.physics.stress.superposition import TABLE_BYTES
from thermoroll_cli.problem.problem import BODIES, Material, SubsurfaceRequest
from thermoroll_cli.tools.arrays import Array

FIRST, RATIO, DEPTH = 0.05, 1.157, 2.2
"""First depth below the surface, in the smaller semi-axis of the contact; ratio of one depth to the next above;
the largest depth. That makes 28 depths; the largest von Mises stress of round and line contacts lies at 0.48 and 0.70."""
SKIN = 0.3
"""First depth in thicknesses of the heated skin. Without: at a Péclet number of 2e4 no depth lies in the skin, the largest
tensile stress is off by 1.1 % instead of 0.01 %, those of fatigue by 0.6 %."""
STEPS_THROUGH = 4
"""Steps from the upper to the lower face of a layer of a coating, at least. With 1: the stresses of 12 bodies
with thin layers are off by 0.6 % in the mean, 32 % at most, instead of 0.03 % and 1.4 %."""


def skin_depth(semi_axis: float, peclet: float) -> float:
    """Depth 2a/√Pe to which heat spreads while the material passes the contact, in m; infinite without motion."""
    return 2.0 * semi_axis / math.sqrt(peclet) if peclet > 0.0 else math.inf


def usual_depths(width: float, depth: float | None = None, layers: int | None = None, skin: float = math.inf) -> Array:
    """Depths in m: the surface, then a geometric sequence down to `depth` (default 2.2 of `width`).

    `width` is the smaller semi-axis of the contact. The first depth is 0.05 of it, or 0.3 of `skin` if heat enters less deep.
    If equal steps of so many `layers` are shorter than that, steps are equal. Without `layers` the ratio of depths is 1.157."""
    last = DEPTH * width if depth is None else depth
    first = min(FIRST * width, SKIN * skin, 0.5 * last)
    if layers is None:
        layers = 2 + math.ceil(math.log(last / first) / math.log(RATIO) - 1e-9)
    first = min(first, last / (layers - 1))
    if first * (layers - 1) >= last * (1.0 - 1e-12):
        return np.linspace(0.0, last, layers)
    return np.concatenate([[0.0], np.geomspace(first, last, layers - 1)])


def few_depths(depths: Array, width: float) -> bool:
    """Whether `depths` of a contact with the smaller semi-axis `width` are sparser than every second one of the default."""
    steps, reach = np.diff(depths), np.maximum(FIRST * width, (RATIO**2 - 1.0) * depths[:-1])
    return bool(np.any(steps > reach * (1.0 + 1e-9)))


def with_interfaces(depths: Array, interfaces: tuple[float, ...]) -> Array:
    """`depths` moved so that both sides of each of the `interfaces` above the last depth are among them: the depth of the
    interface for its upper side, the next larger number for its lower side. Steps through thin bonded layers are equal: a
    stiff layer bends, and polynomials through uneven steps would overshoot between its faces."""
    faces = [0.0, *(face for face in interfaces if face < depths[-1]), float(depths[-1])]
    if len(faces) == 2:
        return depths
    numbers, parts = np.arange(float(len(depths))), []
    for top, bottom in pairwise(faces):
        first, last = np.interp([top, bottom], depths, numbers)
        points = max(STEPS_THROUGH, math.ceil(last - first)) + 1
        thin = top < interfaces[-1] and points <= 2 * STEPS_THROUGH + 1
        part = np.linspace(top, bottom, points) if thin else np.interp(np.linspace(first, last, points), numbers, depths)
        part[0], part[-1] = np.nextafter(top, np.inf) if top else 0.0, bottom
        parts.append(part)
    return np.concatenate(parts)


def depths_of(request: SubsurfaceRequest, derived: DerivedQuantities, body: str, *, heated: bool) -> Array:
    """Depths in m at which stresses of a `body` are computed, with thermal stresses or without (`heated`)."""
    width = min(derived.scales.semi_axis_x, derived.scales.semi_axis_y)
    skin = math.inf
    if heated and derived.problem.heating.peclet == "rolling":
        skin = min(skin_depth(derived.scales.semi_axis_x, derived.peclet(getattr(derived.problem, each)))
                   for each in request.bodies)
    return with_interfaces(usual_depths(width, request.depth, request.layers, skin), getattr(derived.problem, body).interfaces)


STAGE, THERMAL, STRENGTH = "below the surface", "thermal stresses", "shakedown and fatigue"
FASTEST = 1e6
"""Largest Péclet number V a0/κ: above it the heated skin is thinner than 2a/1000, and its thermal tables cost too much:
1.3 s in all at 2e4 on 32² elements, 5 s at 2e5, more than a minute at 2e6."""
LAYERED_SECONDS = 2e-6
"""Time that the tables of a coated body take per element and depth. Without: the plan says a third of the time on 128²
elements; with it, within 30 % (three random contacts)."""
SIDEWAYS = 0.5
"""Largest lateral speed of a body over its speed along rolling: above it the lateral drift takes too many shifts. Without:
ten times the time and 1 GB on 32² elements where both speeds are alike."""


def subsurface_plan(
    request: SubsurfaceRequest, derived: DerivedQuantities, shape: tuple[int, int], *, heated: bool
) -> tuple[list[str], dict[str, str], dict[str, float], int, float]:
    """Stages that run and those that are skipped, with reasons; numbers known before; memory (bytes) and time (s) on one core:
    of one problem on a grid of `shape`, with heat in the contact or not (`heated`)."""
    run, skipped = [STAGE], {}
    if request.lower_strength is not None or request.upper_strength is not None:
        run.append(STRENGTH)
    hot = hot_bodies(request, derived, heated=heated)
    for body in BODIES:
        if body not in request.bodies:
            skipped[f"{STAGE}, {body} body"] = "not asked for"
        elif hot and body not in hot:
            skipped[f"{THERMAL}, {body} body"] = _out_of_reach(derived, body) or "no heat enters it"
    if hot:
        run.append(THERMAL)
    elif heated and derived.problem.heating.peclet == "sliding":
        skipped[THERMAL] = 'not computed with thermal.peclet = "sliding", where every source moves at a speed of its own'
    else:
        far = next(filter(None, (_out_of_reach(derived, body) for body in request.bodies)), "")
        skipped[THERMAL] = "no heat" if not heated else "switched off" if not request.thermal else (
            far or "no heat enters the bodies asked for")
    if not derived.kinematics.has_traction:
        skipped[f"{STAGE}, shear"] = "no traction acts on the surfaces"
    mirrored = derived.kinematics.mirror_on(shape[1], heated=bool(hot)) == (1, -1)
    if mirrored:
        skipped[f"{STAGE}, y < 0"] = "the mirror image of y > 0"
    if len(request.bodies) == 2 and len(_tables(request, derived)) == 1:
        alike = "coatings" if derived.problem.lower.layers else "Poisson ratio"
        skipped[f"{STAGE}, tables of the second body"] = f"both bodies have the same {alike}"
    depths = {body: depths_of(request, derived, body, heated=bool(hot)) for body in request.bodies}
    most, last = max(map(len, depths.values())), float(depths[request.bodies[0]][-1])
    for body in request.bodies:
        if below := [face for face in getattr(derived.problem, body).interfaces if face >= last]:
            skipped[f"{STAGE}, interface of the {body} body"] = (
                f"it lies {below[0] * 1e3:.4g} mm deep: set a larger subsurface.depth_mm")
    facts = {"subsurface_layers": float(most), "subsurface_depth_mm": last * 1e3}
    return run, skipped, facts, *_cost(request, derived, shape, most, hot, mirrored=mirrored)


def _tables(request: SubsurfaceRequest, derived: DerivedQuantities) -> set[float | Material]:
    """Constants on which elastic tables depend: the Poisson ratio of homogeneous bodies, all constants of coated ones."""
    bodies = (getattr(derived.problem, body) for body in request.bodies)
    return {body if body.layers else body.poisson_ratio for body in bodies}


def hot_bodies(request: SubsurfaceRequest, derived: DerivedQuantities, *, heated: bool) -> tuple[str, ...]:
    """The bodies with thermal stresses."""
    partition = derived.problem.heating.partition
    if not (heated and request.thermal) or derived.problem.heating.peclet == "sliding":
        return ()
    return tuple(body for body in request.bodies
                 if partition != (0.0 if body == "lower" else 1.0) and not _out_of_reach(derived, body))


def _out_of_reach(derived: DerivedQuantities, body: str) -> str:
    """Reason why thermal stresses of a moving body are not computed; empty if they are."""
    if derived.problem.heating.peclet != "rolling":
        return ""
    motion = derived.problem.motion
    along, across = 0.5 * abs(motion.creepage_x or 0.0), 0.5 * abs(motion.creepage_y or 0.0)
    if derived.peclet(getattr(derived.problem, body)) * (1.0 + max(along, across)) > FASTEST:
        return f"at a Péclet number above {FASTEST:.0e} the heated skin is too thin to be worth its cost"
    if across > SIDEWAYS * max(1.0 - along, SIDEWAYS):
        return "its material moves sideways about as fast as along rolling"
    return ""


def _cost(
    request: SubsurfaceRequest, derived: DerivedQuantities, shape: tuple[int, int], layers: int, hot: tuple[str, ...], *,
    mirrored: bool,
) -> tuple[int, float]:
    """Rough memory (bytes) and time (s, one core): fields of single precision, tables, transforms times their size."""
    elements, columns = shape[0] * shape[1], 0.5 if mirrored else 1.0
    judged = sum(5.0 if body in hot else 2.0 for body in request.bodies) * columns
    kept = {"plane": 0.0, "von_mises": sum(3.0 if body in hot else 1.0 for body in request.bodies) * (mirrored)}
    kept["full"] = kept["von_mises"] + 6.0 * len(request.bodies) * (1.0 + columns * mirrored)
    thermal = min(1.4 * TABLE_BYTES, 8.0 * 14.0 * layers * elements) if hot else 0.0
    memory = 4.0 * layers * elements * (judged + kept[request.fields]) + thermal + 8.0 * 4.0 * elements * 60.0
    tables = _tables(request, derived)
    padded = 4.0 * elements
    transforms = (12.0 if derived.kinematics.has_traction else 6.0) * len(tables) + 14.0 * len(hot)
    each = transforms * padded * math.log2(padded) * 1.2e-9 + judged * elements * 8e-8
    each += sum(isinstance(body, Material) for body in tables) * elements * LAYERED_SECONDS
    # Histories go on outside the domain.
    each *= 1.0 + (request.lower_strength is not None or request.upper_strength is not None)
    # Coarser grids, for the error estimates, add a third.
    return int(memory), 1.33 * layers * each + 0.5 * len(hot)
