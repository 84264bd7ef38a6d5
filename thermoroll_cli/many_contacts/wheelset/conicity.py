"""Equivalent conicity after EN 15302, from profiles alone: nothing is loaded, and the roll is fixed.

A free wheelset at the lateral shift y, with the difference Δr of the rolling radii (right less left), moves as

    y″ = −Δr(y)/(e r₀)

with the mean radius r₀ and the distance e of the contact points. It oscillates between y_min and y_max of the amplitude
A = (y_max − y_min)/2, at both of which S(y) = ∫ Δr dy from the place where Δr = 0 is the same. With the slope ψ = dy/dx of its
path, and the wavelength λ,

    ψ² = 2 [S(A) − S(y)]/(e r₀),   λ = 2 ∫ dy/ψ,   tan γ_e = (π/λ)² 2 e r₀.

A cone has its own conicity. The conicity does not depend on e, the wavelength does."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from thermoroll_cli.exact.hertz import hertz_contact
from thermoroll_cli.many_contacts.wheelset.curves import curve
from thermoroll_cli.many_contacts.wheelset.first_contact import gauge_side_warnings, touching
from thermoroll_cli.many_contacts.wheelset.placement import Position, WheelSide
from thermoroll_cli.many_contacts.wheelset.search import Facing
from thermoroll_cli.many_contacts.wheelset.wheelset_problem import SIDES, SideName, WheelsetProblem, sign_of
from thermoroll_cli.problem.geometry import Unsolvable
from thermoroll_cli.tools.arrays import Array

STEP = 1e-4
"""Distance of the lateral shifts in m, half of what EN 15302 asks for; where a contact jumps, shifts are JUMP_STEP apart."""
JUMP_STEP = 1e-6
JUMP = 2e-4
"""Way (m) of a contact over the rail within JUMP_STEP from which on it has jumped."""
SUSPECT = 1e-3
"""Way (m) of a contact within STEP from which on it may have jumped."""
TOLD_JUMP = 1e-4
"""Jump of Δr (m) that is reported."""
MOST_REACH = 3.0
"""Largest shift over the amplitude: a wheelset that swings about another place than the middle needs shifts beyond it."""
BEYOND = f"no shift further than {MOST_REACH:g} amplitudes was looked at"
"""Where a free wheelset is driven back to the middle at the furthest shift of all."""
FLANGE, STEEPEST = 0.01, 0.05
"""Least height of a flange in m; its steepest part has inclinations that differ by this (rad)."""
GAP_REACH = 1.5e-3
"""Distance (m) across within which the gap about a contact is fitted: about the half-width of loaded ones."""
ANGLES = 4000
"""Places of the integral for the wavelength, at the cosines of equal angles: exact for any even number of them where Δr is
linear."""
NOMINAL, NEIGHBOURS = 3e-3, (2e-3, 4e-3)
"""Amplitudes (m) of the conicity that a vehicle is judged by, and of Polach's nonlinearity parameter."""
NUMBERS = {"conicity_3mm": "equivalent conicity at an amplitude of 3 mm",
           "nonlinearity_1_mm": "Polach's nonlinearity parameter in 1/mm"}
"""Numbers of the whole, and their meanings."""


@dataclass(frozen=True)
class Touch:
    """Where a rigid wheel touches its rail, as of a right wheel: y and z (m, track axes) on the rail, y and the radius (m) in
    the axes of the wheelset, the inclination of both surfaces (rad) and their relative curvature across (1/m), of the parabola
    through their gap within `GAP_REACH`, positive where they part; and the places in their outlines (m)."""

    y: float
    z: float
    y_wheel: float
    radius: float
    angle: float
    curvature_across: float
    in_rail: float
    in_wheel: float

    @property
    def curvature_along(self) -> float:
        """Relative curvature along rolling in 1/m, of the wheel's surface of revolution (Meusnier)."""
        return math.cos(self.angle) / self.radius


Contacts = dict[SideName, Touch]
Ends = Mapping[int, str]
ENDED, CLIMBS = "a profile ends", "a flange climbs"
"""Why rigid bodies have no contact that a free wheelset rolls on."""


@dataclass(frozen=True)
class Conicity:
    """Equivalent conicity of a wheelset on a track, in SI units: `shifts` y and the `contacts` of each, and the `conicity`
    tan γ_e and the `wavelength` λ at the `amplitudes` A, nan where an amplitude is beyond the profiles, or no motion has it;
    `ends` says why no shift lies further in a direction (1, −1), if shifts were looked for there."""

    problem: WheelsetProblem
    shifts: Array
    contacts: tuple[Contacts, ...]
    amplitudes: Array
    ends: Ends = field(default_factory=dict)
    warnings: tuple[str, ...] = ()

    def __repr__(self) -> str:
        title = f"{self.problem.contact.title!r}, " if self.problem.contact.title else ""
        ends = f"{1e3 * self.amplitudes.min():g} to {1e3 * self.amplitudes.max():g} mm"
        return f"<Conicity {title}{self.conicity_at(3e-3):.4g} at 3 mm, {len(self.amplitudes)} amplitudes from {ends}>"

    @cached_property
    def radius_difference(self) -> Array:
        """Δr at the shifts: the rolling radius of the right wheel less that of the left one, in m."""
        return _difference(self.contacts)

    @property
    def mean_radius(self) -> float:
        """r₀ in m, of the nominal radii."""
        return float(np.mean([wheel.radius for wheel in self.problem.wheels.values()]))

    @cached_property
    def _potential(self) -> _Potential | None:
        return _potential(self.shifts, self.radius_difference)

    @cached_property
    def wavelength(self) -> Array:
        """λ in m."""
        return np.array([self.wavelength_at(amplitude) for amplitude in self.amplitudes])

    @property
    def conicity(self) -> Array:
        return self._conicity_of(self.wavelength)

    def wavelength_at(self, amplitude: float) -> float:
        """λ in m at an `amplitude` in m; nan beyond the profiles."""
        if self._potential is None:
            return math.nan
        return self._potential.wavelength(amplitude, self.problem.contact_distance * self.mean_radius)

    def conicity_at(self, amplitude: float) -> float:
        """tan γ_e at an `amplitude` in m; nan beyond the profiles."""
        return float(self._conicity_of(np.array(self.wavelength_at(amplitude))))

    @property
    def nonlinearity(self) -> float:
        """Polach's nonlinearity parameter [tan γ_e(4 mm) − tan γ_e(2 mm)]/(2 mm) in 1/m."""
        low, high = (self.conicity_at(amplitude) for amplitude in NEIGHBOURS)
        return (high - low) / (NEIGHBOURS[1] - NEIGHBOURS[0])

    def _conicity_of(self, wavelength: Array) -> Array:
        return np.asarray((math.pi / wavelength) ** 2 * 2.0 * self.problem.contact_distance * self.mean_radius)

    def record(self) -> dict[str, Any]:
        """What `thermoroll conicity --json` prints, in the units of the names; None where there is no number."""
        return {
            "amplitude_mm": _numbers(1e3 * self.amplitudes),
            "conicity": _numbers(self.conicity),
            "wavelength_m": _numbers(self.wavelength),
            "lateral_shift_mm": _numbers(1e3 * self.shifts),
            "rolling_radius_difference_mm": _numbers(1e3 * self.radius_difference),
            **{f"contact_y_{body}_{side}_mm": [round(1e3 * sign_of(side) * getattr(at[side], name), 9) for at in self.contacts]
               for side in SIDES for body, name in (("rail", "y"), ("wheel", "y_wheel"))},
            "contacts": self.contact_points(),
            "conicity_3mm": _numbers([self.conicity_at(NOMINAL)])[0],
            "nonlinearity_1_mm": _numbers([1e-3 * self.nonlinearity])[0],
            "warnings": list(self.warnings),
        }


    def contact_points(self) -> dict[str, list[Any]]:
        """Columns of the points of contact, a row for each shift and side: places in the axes of track and wheelset
        (`contact_y_…`) and in the profiles (`y_…`), inclination, relative curvatures, rolling radius, and Hertz's semi-axes at
        half the vertical load of the wheelset; None where surfaces do not part across."""
        half, modulus = 0.5 * (self.problem.vertical or math.nan), self.problem.contact.contact_modulus
        rows = []
        for shift, at in zip(self.shifts.tolist(), self.contacts, strict=True):
            for side in SIDES:
                touch, sign = at[side], sign_of(side)
                semi_axes = math.nan, math.nan
                if half > 0.0 and touch.curvature_across > 0.0:
                    hertz = hertz_contact(touch.curvature_along, touch.curvature_across, modulus, half / math.cos(touch.angle))
                    semi_axes = hertz.semi_axis_x, hertz.semi_axis_y
                rows.append((1e3 * shift, side, *_numbers([
                    1e3 * sign * touch.y, 1e3 * sign * touch.y_wheel, 1e3 * touch.in_rail, 1e3 * touch.in_wheel,
                    1e3 * sign * touch.angle, touch.curvature_along, touch.curvature_across, 1e3 * semi_axes[0],
                    1e3 * semi_axes[1], 1e3 * touch.radius, 0.0])))
        return {name: list(column) for name, column in zip(CONTACT_POINTS, zip(*rows, strict=True), strict=True)} if rows else (
            {name: [] for name in CONTACT_POINTS})


CONTACT_POINTS = (
    "lateral_shift_mm", "side", "contact_y_rail_mm", "contact_y_wheel_mm", "y_rail_mm", "y_wheel_mm", "contact_angle_mrad",
    "curvature_x_1_m", "curvature_y_1_m", "hertz_a_mm", "hertz_b_mm", "rolling_radius_mm", "roll_mrad")  # fmt: skip
"""Columns of the points of contact. The roll is 0, as in the values of EN 15302."""


def _numbers(values: Sequence[float] | Array) -> list[float | None]:
    return [float(f"{value:.12g}") if math.isfinite(value) else None for value in values]


def conicity_of(problem: WheelsetProblem, amplitudes: Array) -> Conicity:
    """The equivalent conicity at `amplitudes` (m) of a wheelset; yaw and roll of `problem` do not count.

    Raises Unsolvable for a single wheel, and where touching() does."""
    if set(problem.sides) != set(SIDES):
        raise Unsolvable("a single wheel has no equivalent conicity", "wheelset.wheels", '"both"')
    problem.refuse_variation("the equivalent conicity")
    centred = replace(problem, position=Position(), vertical=1.0, finds_roll=False)
    touching(centred)
    known: dict[Hashable, Touch | str] = {}

    def contacts_at(shift: float) -> Contacts | str:
        return _contacts(replace(centred, position=Position(y=shift)), known)

    shifts, contacts, ends = _followed(contacts_at, max(float(amplitudes.max()), *NEIGHBOURS))
    found = Conicity(problem, shifts, contacts, amplitudes, ends)
    return replace(found, warnings=tuple(_warnings(found)))


def _contacts(problem: WheelsetProblem, known: dict[Hashable, Touch | str]) -> Contacts | str:
    """Both contacts; `ENDED` or `CLIMBS` where one is none. A wheel like the other one touches at y as that does at −y: `known`
    keeps what was found."""
    found: Contacts = {}
    for side in SIDES:
        try:
            facing = problem.facing(side)
        except Unsolvable:
            return ENDED
        place = facing.rail, facing.wheel, facing.position
        if place not in known:
            known[place] = _touch(facing)
        touch = known[place]
        if isinstance(touch, str):
            return touch
        found[side] = touch
    return found


def _touch(facing: Facing) -> Touch | str:
    gap, y = facing.gap, facing.outlines[0].y
    k = int(np.argmin(gap))
    if k in (0, len(y) - 1):
        return ENDED
    # Heights are chords, whose lowest place is that of a sample. The slopes are equal where the surfaces touch.
    rail, wheel = (outline.within(slice(k - 1, k + 2)) for outline in facing.outlines)
    ours, others = (outline.of(samples[1]) / outline.of(samples[0])
                    for outline, samples in ((rail, facing.rail.samples[2:]), (wheel, facing.locus[3:])))
    apart = ours - others
    at = y[k]
    for j in (0, 1):
        if apart[j] < 0.0 <= apart[j + 1]:
            at = y[k - 1 + j] - apart[j] * (y[1] - y[0]) / (apart[j + 1] - apart[j])
    place = np.interp(at, wheel.y, wheel.index)
    low = min(int(place), facing.wheel.samples.shape[1] - 2)
    own, radius = (row[low] + (place - low) * (row[low + 1] - row[low]) for row in facing.wheel.samples[:2])
    height = np.interp(at, rail.y, rail.z)
    if own < _climbing(facing.wheel):
        return CLIMBS
    near = np.flatnonzero(np.abs(y - at) <= GAP_REACH)
    fitted = np.polyfit(y[near] - at, gap[near], 2)[0] if np.isfinite(gap[near]).all() and len(near) > 3 else math.nan
    slope = float(np.interp(at, rail.y, ours))
    cosine = 1.0 / math.hypot(1.0, slope)
    # Heights become distances along the normal, and y lengths along the surface.
    return Touch(float(at), float(height), float(own), float(radius), math.atan(slope), float(2.0 * fitted) * cosine**3,
                 *(float(np.interp(index, np.arange(len(rows)), rows)) for index, rows in (
                     (np.interp(at, rail.y, rail.index), curve(facing.rail.profile).samples[0]),
                     (place, curve(facing.wheel.profile).samples[0]))))


@lru_cache(maxsize=8)
def _climbing(wheel: WheelSide) -> float:
    """y (m, wheelset axes) below which a contact on the flange has passed its steepest part: the wheel climbs; −inf without a
    flange."""
    y, radius, dy, dr = wheel.samples
    tip = int(np.argmax(radius))
    if radius[tip] < wheel.radius + FLANGE:
        return -math.inf
    # The flange alone: a chamfer or the face of the rim on the field side may be steeper.
    tread = y[(y > y[tip]) & (radius < wheel.radius + 0.2 * FLANGE)].min(initial=math.inf)
    flange = (y > y[tip]) & (y < tread)
    angle = np.arctan2(-dr * np.sign(dy), np.abs(dy))[flange]
    return float(y[flange][angle > angle.max() - STEEPEST].min())


def _followed(contacts_at: Callable[[float], Contacts | str], amplitude: float) -> tuple[Array, tuple[Contacts, ...], Ends]:
    """Shifts in both directions, as far as an `amplitude` (m) needs them or the profiles reach, and more of them where a
    contact jumps; the contacts there, and why the shifts end, by direction."""
    found: dict[float, Contacts] = {}
    ends: dict[int, str] = {}
    reach = math.ceil(amplitude / STEP) + 2
    done = -1
    while done < reach:
        for direction in [way for way in (1, -1) if way not in ends]:
            for number in range(done + 1, reach + 1):
                # Multiples of the step are the same on both sides: what is symmetric has symmetric shifts.
                contacts = contacts_at(direction * number * STEP)
                if isinstance(contacts, str):
                    ends[direction] = contacts
                    break
                found[direction * number * STEP] = contacts
        done = reach
        places = sorted(found)
        potential = _potential(np.array(places), _difference([found[place] for place in places]))
        short = potential is None or potential.reach < amplitude + STEP
        if short and len(ends) < 2 and reach < MOST_REACH * amplitude / STEP:
            reach = math.ceil(1.3 * reach)
    for low, high in itertools.pairwise(places):
        while high - low > JUMP_STEP and _way(found[low], found[high]) > SUSPECT * (high - low) / STEP:
            middle = 0.5 * (low + high)
            between = contacts_at(middle)
            if isinstance(between, str):
                break
            found[middle] = between
            low, high = (low, middle) if _way(found[low], between) > _way(between, found[high]) else (middle, high)
    places = sorted(found)
    return np.array(places), tuple(found[place] for place in places), ends


def _difference(contacts: Sequence[Contacts]) -> Array:
    return np.array([at["right"].radius - at["left"].radius for at in contacts])


def _way(one: Contacts, other: Contacts) -> float:
    """The longer way (m) of both contacts over their rails."""
    return max(abs(one[side].y - other[side].y) for side in SIDES)


def _warnings(found: Conicity) -> Iterator[str]:
    shifts, difference = found.shifts, found.radius_difference
    yield from gauge_side_warnings(found.problem)
    if not found.contacts:
        yield f"in the middle of the track a wheel touches its rail where {found.ends[1]}"
        return
    if found._potential is None:
        yield ("the rolling radii are equal at no lateral shift at which they restore the wheelset to the middle: there is no "
               "conicity")
        return
    for side in SIDES:
        y = np.array([at[side].y for at in found.contacts])
        steps = np.abs(np.diff(difference))
        jumps = np.flatnonzero((np.diff(shifts) <= JUMP_STEP) & (np.abs(np.diff(y)) > JUMP) & (steps > TOLD_JUMP))
        if len(jumps):
            most = jumps[np.argmax(steps[jumps])]
            places = ", ".join(f"{1e3 * shifts[k]:.3g}" for k in jumps)
            yield (f"the contact of the {side} wheel jumps at shifts of {places} mm; "
                   f"at {1e3 * shifts[most]:.3g} mm the difference of the rolling radii by {1e3 * steps[most]:.2g} mm")
    missing, reach = found.amplitudes[np.isnan(found.wavelength)], found._potential.reach
    beyond, between = 1e3 * missing[missing > reach], 1e3 * missing[missing <= reach]
    if len(beyond):
        low, high = (1e3 * end for end in found._potential.ends(found._potential.most))
        yield (f"amplitudes from {beyond.min():.3g} mm on are beyond the profiles: the wheelset swings between shifts of "
               f"{low:.3g} and {high:.3g} mm at most, where {' and '.join(_limits(found._potential, found.ends))}")
    if len(between):
        span = f"{between.min():.3g} mm" if len(between) == 1 else f"{between.min():.3g} to {between.max():.3g} mm"
        yield (f"no motion has an amplitude of {span}: the wheelset swings to one side of a shift that drives it away, or "
               "around that shift with a larger amplitude")
    if abs(found._potential.middle) > STEP:
        yield f"the rolling radii are equal at a lateral shift of {1e3 * found._potential.middle:.3g} mm"


def _limits(potential: _Potential, ends: Ends) -> list[str]:
    """What limits the swing of a wheelset: of both directions, if they allow as much."""
    found = []
    for direction in (-1, 1):
        values = potential.value[potential.number :: direction]
        if values.max() > potential.most * (1.0 + 1e-9):
            continue
        # Δr restores the wheelset up to the last shift, or S is largest before.
        at_end = np.argmax(values) == len(values) - 1
        found.append(ends.get(direction, BEYOND) if at_end else "no wheel is larger any more on the side it moves to")
    return list(dict.fromkeys(found))


@dataclass(frozen=True)
class _Potential:
    """S(y) (m²) at the places `y` (m), between which Δr = `difference` (m) is linear, above its least value at `middle`. A
    wheelset with the level E moves where S ≤ E around the middle: over humps that lie lower, as a hollow wheel has them."""

    y: Array
    difference: Array
    value: Array
    number: int

    @property
    def middle(self) -> float:
        return float(self.y[self.number])

    @property
    def most(self) -> float:
        """The largest level that S reaches on both sides."""
        return float(min(self.value[: self.number + 1].max(), self.value[self.number :].max()))

    @property
    def reach(self) -> float:
        """The largest amplitude in m."""
        left, right = self.ends(self.most)
        return 0.5 * (right - left)

    def __call__(self, y: Array) -> Array:
        """S, quadratic between the places."""
        k = np.clip(np.searchsorted(self.y, y) - 1, 0, len(self.y) - 2)
        t = y - self.y[k]
        slope = (self.difference[k + 1] - self.difference[k]) / (self.y[k + 1] - self.y[k])
        return np.asarray(self.value[k] + t * (self.difference[k] + 0.5 * slope * t))

    def ends(self, level: float) -> tuple[float, float]:
        """The places on both sides of the middle at which S reaches a `level` first."""
        return self._end(level, -1), self._end(level, 1)

    def _end(self, level: float, direction: int) -> float:
        values, y = (row[self.number :: direction] for row in (self.value, self.y))
        d = direction * self.difference[self.number :: direction]
        above = np.flatnonzero(values >= level)
        k = max(int(above[0]) - 1, 0) if len(above) else len(y) - 2
        size = abs(y[k + 1] - y[k])
        rise, slope = level - values[k], (d[k + 1] - d[k]) / size
        root = math.sqrt(max(d[k] ** 2 + 2.0 * slope * rise, 0.0))
        # Where S falls at first, the other root of the quadratic; each without cancellation.
        step = 2.0 * rise / (d[k] + root) if d[k] > 0.0 else (root - d[k]) / slope if slope > 0.0 else size
        return float(y[k] + direction * min(max(step, 0.0), size))

    def wavelength(self, amplitude: float, product: float) -> float:
        """λ (m) at an `amplitude` (m); `product` is e r₀ (m²). nan beyond the profiles, and where no motion has the amplitude:
        just above a hump it jumps."""
        if self.reach < amplitude * (1.0 - 1e-12):
            return math.nan

        def wider(level: float) -> float:
            left, right = self.ends(level)
            return right - left - 2.0 * amplitude

        low, high = 0.0, self.most
        for _ in range(200):
            level = 0.5 * (low + high)
            low, high = (low, level) if wider(level) > 0.0 else (level, high)
            if high - low <= 1e-15 * high:
                break
        left, right = self.ends(high)
        if right - left > 2.0 * amplitude + 2.0 * STEP:
            # Where Δr = 0 over more than the amplitude nothing brings the wheelset back: an endless wave.
            return math.inf if high <= 1e-12 * self.most else math.nan
        middle, half = 0.5 * (left + right), 0.5 * (right - left)
        angle = math.pi * ((np.arange(ANGLES) + 0.5) / ANGLES - 0.5)
        slope = np.sqrt(2.0 * np.maximum(high - self(middle + half * np.sin(angle)), 1e-300) / product)
        return float(2.0 * math.pi / ANGLES * (half * np.cos(angle) / slope).sum())


def _potential(shifts: Array, difference: Array) -> _Potential | None:
    """S(y) about its least value; None if that lies at an end."""
    crossing = np.flatnonzero((difference[:-1] < 0.0) & (difference[1:] >= 0.0))
    if not len(crossing):
        return None
    zeros = shifts[crossing] - difference[crossing] * np.diff(shifts)[crossing] / np.diff(difference)[crossing]
    y, r = np.concatenate((shifts, zeros)), np.concatenate((difference, 0.0 * zeros))
    order = np.argsort(y, kind="stable")
    y, r = y[order], r[order]
    kept = np.concatenate(([True], np.diff(y) > 1e-15))
    y, r = y[kept], r[kept]
    value = np.concatenate(([0.0], np.cumsum(0.5 * np.diff(y) * (r[:-1] + r[1:]))))
    least = np.flatnonzero(value <= value.min() + 1e-12 * np.ptp(value))
    number = int(least[np.argmin(np.abs(y[least]))])
    if number in (0, len(y) - 1):
        return None
    return _Potential(y, r, value - value[number], number)
