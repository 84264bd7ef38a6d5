"""Places of balls and of the inner ring, and the loads of all contacts: the minimum of the elastic energy.

The grooves' centres are (A₁, A₂) apart, axially and outwards, and a ball's centre lies at X from that of its outer groove. The
contacts are loaded by Hertz's law over |X| and |A − X| less their lengths without load (Jones 1960; ISO/TS 16281). With Hertz's
constants held, the energy less the work of given forces is convex in X and in the displacements of the ring, so that Newton's
method with a line search finds its minimum from anywhere. The constants follow the contact angles, on which they hardly depend.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from thermoroll_cli.many_contacts.bearing.bearing_problem import BearingProblem
from thermoroll_cli.tools.arrays import Array

MOST_STEPS, MOST_ROUNDS = 200, 30
BALANCED = 1e-12
"""Forces left over, over the largest force."""
SETTLED = 1e-11
"""Change of the contact angles (rad) from round to round that ends them."""
SINGULAR = 1e-10
"""Stiffness over the largest one that stands for none: that of balls that are free."""

LIGHT = 1e-4
"""Load of a ball over the largest of all below which it counts as free: it rolls as others carry it along."""
STEEPEST = math.radians(89.0)
"""Largest contact angle of a ball that rolls."""
NOTHING_PRESSED = "no ball touches both rings: more load, or a displacement beyond the play, presses them"


class Placement(NamedTuple):
    """Where all is: `ring`, the displacements of the inner ring (axial from the middle, radial towards ball 1 and across, in m;
    tilts in rad), for each ball the `centre` (n, 2) of a ball from that of its outer groove in m, `loads` (n, 2) in N and
    contact `angles` (n, 2) in rad at the inner and the outer ring; `stiffness` (5, 5) of the ring in N/m, N and N m; `turned`,
    by how much the angles of a ball turn for forces on any ball, axially and outwards, and for those that it passes on to the
    inner ring, in rad/N, (n, 2, n, 4); `reason` says what is not in balance."""

    ring: Array
    centre: Array
    loads: Array
    angles: Array
    stiffness: Array
    turned: Array
    reason: str = ""


def place(
    problem: BearingProblem, centrifugal: Array, on_balls: Array, on_ring: Array, start: Placement | None = None
) -> Placement:
    """The bearing in balance.

    Parameters:

    - `centrifugal`: force of each ball in N, (n,);
    - `on_balls`: other forces on each ball, axially and outwards, in N, (n, 2): those of friction;
    - `on_ring`: such forces of each ball on the inner ring, (n, 2);
    - `start`: where the search begins.
    """
    psi, arm = problem.places, problem.arm
    cosine, sine, nothing, one = np.cos(psi), np.sin(psi), np.zeros(len(psi)), np.ones(len(psi))
    # Tilts count at the arm here, so that all displacements are lengths.
    moves = np.stack([np.stack([one, nothing, nothing, cosine, sine], -1),
                      np.stack([nothing, cosine, sine, nothing, nothing], -1)], axis=1)
    free = np.array([problem.axial_displacement is None, True, True, *[problem.moments is not None] * 2])
    moments = problem.moments or (0.0, 0.0)
    given = np.array([problem.axial, problem.radial, 0.0, moments[0] / arm, moments[1] / arm])
    given = given + np.einsum("jki,jk->i", moves, on_ring)
    on_balls = on_balls + np.stack([nothing, centrifugal], -1)
    unloaded = np.array([0.0, problem.groove_distance * math.cos(problem.contact_angle) + problem.widening * arm])
    largest = max(float(np.abs(given[free]).max()), float(np.abs(on_balls).max()), 1e-9)
    # A warm inner ring grows with its groove.
    grown = problem.widening * problem.conformity[0] * problem.ball_diameter
    lengths, scale = np.array(problem.lengths) + np.array([grown, 0.0]), np.array([1.0, 1.0, 1.0, arm, arm])
    if start is None:
        ring, centre = _start(problem, given, float(largest))
    else:
        ring, centre = start.ring * scale, start.centre
    if problem.axial_displacement is not None:
        ring = np.array([problem.axial_displacement, *ring[1:]])
    count, reason, loaded = len(psi), "", np.ones((len(psi), 2), bool)
    angles = np.full((len(psi), 2), np.inf)

    def state(ring: Array, centre: Array) -> tuple[Array, Array]:
        """Vectors and lengths between the centres of ball and groove, (n, 2, …)."""
        between = np.stack([unloaded + moves @ ring - centre, centre], axis=1)
        return between, np.maximum(np.linalg.norm(between, axis=-1), 1e-12)

    def energy(ring: Array, centre: Array, soft: Array) -> float:
        over = np.maximum(state(ring, centre)[1] - lengths, 0.0)
        return float((0.4 * over**2.5 / soft**1.5).sum() - (on_balls * centre).sum() - given @ ring)

    for _ in range(MOST_ROUNDS):
        between, distance = state(ring, centre)
        new = np.arctan2(between[..., 0], between[..., 1])
        if float(np.abs(np.where(loaded, new - angles, 0.0)).max()) < SETTLED:
            break
        angles = new
        soft = problem.unit_approaches(angles)
        for _ in range(MOST_STEPS):
            between, distance = state(ring, centre)
            over = np.maximum(distance - lengths, 0.0)
            loads = (over / soft) ** 1.5
            loaded = loads > 0.0
            unit = between / distance[..., None]
            force = loads[..., None] * unit
            along = np.einsum("jki,jk->i", moves, force[:, 0]) - given
            across = force[:, 1] - force[:, 0] - on_balls
            left = max(float(np.abs(along[free]).max(initial=0.0)), float(np.abs(across).max()))
            stiff = np.where(loaded, 1.5 * loads / np.where(loaded, over, 1.0), 0.0)
            turn = (loads / distance)[..., None, None]
            outer = unit[..., :, None] * unit[..., None, :]
            of_contacts = stiff[..., None, None] * outer + turn * (np.eye(2) - outer)
            # Balls touch the rings alone: each is eliminated by itself, and leaves the stiffness of the inner ring.
            of_ring, of_balls = np.einsum("jki,jkl,jlm->im", moves, of_contacts[:, 0], moves), of_contacts.sum(axis=1)
            held = SINGULAR * max(float(np.abs(of_ring).max()), float(np.abs(of_balls).max()), 1.0)
            soft_balls = np.linalg.inv(of_balls + held * np.eye(2))
            carried = np.einsum("jki,jkl,jlm->jim", moves, of_contacts[:, 0], soft_balls)  # of a force on a ball, by the ring
            stiffness = of_ring + held * np.eye(5) - np.einsum("jim,jmk,jkl->il", carried, of_contacts[:, 0], moves)
            if left <= BALANCED * max(largest, float(loads.max())):
                break
            way = np.zeros(5)
            way[free] = -np.linalg.solve(stiffness[np.ix_(free, free)], (along + np.einsum("jim,jm->i", carried, across))[free])
            ways = np.einsum("jim,i->jm", carried, way) - np.einsum("jkl,jl->jk", soft_balls, across)
            share = min(1.0, 0.3 * float(lengths.min()) / max(float(np.abs(way).max()), float(np.abs(ways).max()), 1e-300))
            before, fall = energy(ring, centre, soft), float(along @ way + (across * ways).sum())
            while share > 1e-12 and energy(ring + share * way, centre + share * ways, soft) > (
                    before + 1e-4 * share * fall + 1e-14 * abs(before)):
                share *= 0.5
            ring, centre = ring + share * way, centre + share * ways
    if left > 1e-6 * max(largest, float(loads.max())):
        reason = (f"the balls do not hold the inner ring: {left / largest:.1e} of the largest force is left over; more balls, "
                  "or a ring that is held straight, without moment_Nm, hold it")
    elif not (pressed := (loads > LIGHT * loads.max()).all(axis=1)).any():
        reason = NOTHING_PRESSED
    elif (steep := float(np.abs(angles[pressed]).max())) > STEEPEST:
        reason = (f"the contact angle is {math.degrees(steep):.1f} degrees, where balls do not roll: more balls, radial load, "
                  "less speed or less widening hold the inner ring radially")
    # How the ring, and with it each ball, moves for forces on any ball, (…, 2), and for those that it passes on, (…, 2).
    on_any = np.concatenate([np.moveaxis(carried, 0, 1), np.moveaxis(moves, 2, 0)], axis=-1)
    moved = np.zeros((5, count, 4))
    own = stiffness[np.ix_(free, free)]
    moved[free] = np.linalg.solve(own, on_any[free].reshape(len(own), -1)).reshape(-1, count, 4)
    of_centres = np.einsum("jim,ibf->jmbf", carried, moved)
    of_centres[range(count), :, range(count), :2] += soft_balls
    apart = np.stack([np.einsum("jki,ibf->jkbf", moves, moved) - of_centres, of_centres], axis=1)
    turned = (between[..., 1, None, None] * apart[:, :, 0] - between[..., 0, None, None] * apart[:, :, 1]) / (
        distance[..., None, None] ** 2)
    return Placement(ring / scale, centre, loads, angles, stiffness * np.outer(scale, scale), turned, reason)


def _start(problem: BearingProblem, given: Array, largest: float) -> tuple[Array, Array]:
    """Displacements of the ring and places of the balls with which the loads are about carried."""
    free_place = problem.groove_distance * math.sin(problem.contact_angle)
    share = largest / problem.balls
    soft = problem.unit_approaches(np.array([problem.contact_angle] * 2))
    deep = soft * share ** (2.0 / 3.0)
    ring = np.zeros(5)
    if given[0]:
        ring[0] = math.copysign(free_place + float(deep.sum()), given[0])
    clearance = problem.groove_distance * (1.0 - math.cos(problem.contact_angle)) if not given[0] else 0.0
    across = float(np.hypot(given[1], given[2]))
    if across:
        ring[1:3] = given[1:3] / across * (clearance + float(deep.sum()))
    angle = math.copysign(problem.contact_angle, ring[0]) if ring[0] else 0.0
    centre = (problem.lengths[1] + float(deep[1])) * np.array([math.sin(angle), math.cos(angle)])
    return ring, np.tile(centre, (problem.balls, 1))
