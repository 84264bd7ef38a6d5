"""Discretisation errors of all scalars, at the surface and below it, from the grids that were solved on the way.

With the values v of a scalar over its `error_scale` on the grids N/4, N/2 and N (N counts elements over 1.1 diameters of the
contact), the estimate is that of a grid convergence index with a part R that no grid of the sequence can see:

    E = S (D/(2^q − 1) + R) + floor + left out,      D = max(|v_N − v_N/2|, |v_N/2 − v_N/4| / 2^q).

D guards against two values that agree by accident. What is extrapolated at second order has its own last change in place of
S D/3. If the two changes differ in sign, or do not shrink, no order is seen and
the divisor is at most 1. The last term is the bound of the effect of stages that were left out (`Plan.left_out`). All numbers
of the scheme are the constants below. None is fitted to a scalar.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from thermoroll_cli.one_contact.refinement.level import Level
from thermoroll_cli.one_contact.refinement.plan import Plan
from thermoroll_cli.one_contact.refinement.sharp_places import (
    Between,
    between_columns,
    has_thin_patch,
    uneven_friction,
    unseen_stick,
)
from thermoroll_cli.one_contact.refinement.subsurface_plan import few_depths
from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.one_contact.steady_state.scalars import problem_scalars
from thermoroll_cli.physics.stress.body_stresses import LAYER_POINTS, Collector, scalars_of
from thermoroll_cli.physics.stress.strength import PARABOLA
from thermoroll_cli.problem.names import (
    SCALARS,
    STRENGTH_SCALARS,
    Condition,
    Kind,
    Scalar,
    holds,
    known_as,
    of_contacts,
    of_kind,
)
from thermoroll_cli.problem.problem import Problem
from thermoroll_cli.problem.result import Peak
from thermoroll_cli.problem.scalar_errors import TEMPERATURES, computed, error_scale, missed, worst

Levels = Sequence[Mapping[str, float]]

# Beside each number: covered and short by three times without it, on 241 random cases; with all of them 97.1 % and 0.3 %.
SAFETY, SAFETY_EXTRAPOLATED, SAFETY_TWO_GRIDS = 1.25, 1.0, 3.0
"""S: Roache's factors for the grid convergence index with three grids (1: 95.5 %), and with two, which show no order. What is
extrapolated at second order, and whose changes shrink, has its own last change as its error, and no less than a quarter of the
correction that was applied (48 fresh contacts: 98 % covered at N = 32, 99 % at N = 64; with all of the correction
98 and 100 %, but 1.6 times as wide at N = 64)."""
ORDER, ORDER_UNEVEN, ORDER_AT_SURFACE = 2.0, 1.0, 0.5
"""q: midpoint sums and parabolas through smooth peaks are of second order. Unlike bodies have tractions that begin like
√s ln s, and exchanged heat is singular at the border of its area, where it alone warms elements: first order (2: 94.7 % and
0.8 %). So are the end of stick and the largest flux where slip sets in at once, over an interlayer or with friction that rises
with slip. Stresses rise like √s from the border (2: 84 % of stresses covered), and so do tractions up to where an interlayer
yields: slip and heat are largest there (2: 56 % of the largest fluxes). The pressure at the end of a body rises without bound,
and half of what its last element misses is missing in every sum over the contact (2: 18 of 60 approaches and places of the
contact covered)."""


def _abrupt(problem: Problem) -> bool:
    """Whether slip sets in at once."""
    law = problem.friction.law
    return problem.interlayer.compliance > 0.0 or (law is not None and law.highest > law.at_rest)


def _relaxes(problem: Problem) -> bool:
    return problem.relaxes


UNEVEN: dict[Kind, Condition] = {
    "first order": True,
    "peak pressure": _relaxes,
    "relative peak pressure": _relaxes,
    "exchanged heat": lambda problem: problem.heating.partition == "matched",
    "diffused mean": lambda problem: problem.heating.conducts,
    "stick": _abrupt,
    "peak flux": _abrupt,
}
"""Kinds of scalars that are of first order also between bodies alike, and where."""
BORDER = 1.0 / 3.0
"""R of areas with a border that is found, and of the heat that is conducted, most of it there, times N^−1.5: about N border
elements, each off by a third of itself at random (0: 91 % of stick areas)."""
ORDER_BETWEEN, INSIDE = 4.0, 2
"""Below the surface of a line contact a maximum lies where a parabola through three elements has it: its value errs with the
fourth power of the element, its place with the third, by an amount and a sign that depend on where in one it lies. That is most
of the change of coarse grids (as other scalars: 99 % of 216 pairs covered, but 14 times as wide in the middle). At the surface
stresses rise like √s within so many elements of the border, which is one place; further inside they have a kink where stick
ends, at most."""
AT_ONE_PLACE = 0.1
"""Error of a border that is straight along an element's side, in elements, at most (measured on cylinders, N = 64 and 256)."""
SPREAD = 0.5
"""Part of the error of the largest flux that reaches temperatures, because heat spreads, and integrals."""
EDGE, EDGE_BELOW = 0.6, 0.8
"""R of the largest pressure and traction of bodies that relax: what a maximum at the leading edge exceeds `EDGE_BELOW` of the
largest pressure by, times `EDGE` over the square of its distance from the edge in elements, at most 1. (0: spheres, at 10 and
30 times the compliance, up to 40 % off at N = 16 to 128, and 88 % covered; 100 % with it.)"""
FLOOR = 1.5e-5
"""Tolerances and rounding (0: 95.3 %, 60 % of areas)."""

OF_HISTORIES = "dang_van", "alternating_k"
"""Beginnings of the names of scalars from histories along x."""
RESULTANTS = of_kind("resultant")
ERROR_SCALARS = tuple(name for name, scalar in SCALARS.items() if scalar.accurate)
"""Scalars whose error has to fall below `numerics.accuracy`, if no others are asked for (those that are given have none)."""
SMALLEST_ERROR_K = 1e-3
"""Temperatures need not be known more closely, in K, however small the rise is: no accuracy is missed for less."""

LOST_IN_LAYERS, TABULATED = ("hysteresis_W", "rolling_resistance_N", "rolling_resistance_moment_Nmm"), 5e-4
"""Losses of layers that relax, and the share of them by which the table of their memory errs, whatever the grid."""

EXTRAPOLATED = of_kind("integral", "exchanged heat", "resultant", "creepage")
"""Integrals over the contact converge smoothly, at second order: Richardson extrapolation is worth another digit. So do the
creepages that are found for forces."""


def estimate(
    values: Sequence[float], scale: float, *, order: float = ORDER, unresolved: float = 0.0, floor: float = FLOOR,
    safety: float = SAFETY, between: float = 0.0, alternates: bool = False,
) -> float:
    """E of the module's docstring over `scale`, from `values` on up to three grids (coarse to fine, the last is reported).

    `order` is q, `unresolved` R over `scale`. Where most of the change of coarse grids is of an order `between` elements above
    q, the guard counts it so; of what `alternates`, a change of sign shows nothing. nan for one grid alone, or where a value or
    the scale is not known."""
    values = values[-3:]
    if len(values) < 2 or math.isnan(values[-1]) or math.isnan(values[-2]) or math.isnan(scale):
        return math.nan
    if scale == 0.0:
        return 0.0
    last, divisor = (values[-1] - values[-2]) / scale, 2.0**order - 1.0
    if len(values) == 2 or math.isnan(values[0]):
        return SAFETY_TWO_GRIDS * (abs(last) / divisor + unresolved) + floor
    before = (values[-2] - values[-3]) / scale
    if safety == SAFETY_EXTRAPOLATED and order == ORDER and converges_one_way(before, last):
        # It errs by less than the extrapolated value has changed since the grid before, and by a quarter of its correction.
        changed = abs(last + (last - before) / divisor)
        return max(changed, 0.25 * abs(last) / divisor) + unresolved + floor
    shown = divisor if alternates or converges_one_way(before, last) else min(divisor, 1.0)
    guard = abs(before) / (2.0**between * divisor if between else 2.0**order * shown)
    return safety * (max(abs(last) / shown, guard) + unresolved) + floor


def missed_accuracy(errors: Mapping[str, float], summary: Mapping[str, float], problem: Problem) -> dict[str, float]:
    """The scalars of one state that have to be accurate, with estimated errors that the accuracy that is asked for does not
    bound: those of `numerics.accuracy_of`, unless they are given, or the `ERROR_SCALARS` that have an error (of others warnings
    tell); `summary` has their values.

    A share that sticks of exactly 0 asks for no finer grid, and neither does the strip along the leading edge that sticks over
    an interlayer (0.3 % of the contact where a locomotive slips by 10 %), if it is no wider than its own error: the forces
    have the effect of the stick that may be unseen."""
    asked = problem.numerics.accuracy_of
    names = of_contacts(asked) if asked else ERROR_SCALARS
    interlayer = problem.interlayer.compliance > 0.0
    known = ("gamma_st", "stick_area_mm2") if summary["gamma_st"] <= (errors["gamma_st"] if interlayer else 0.0) else ()
    wanted = {name: error for name, error in errors.items() if name in names and name not in known and (
        computed(summary.get(known_as(name, summary))) and not holds(SCALARS[name].given, problem) if asked
        else not math.isnan(error))}
    return {name: error for name, error in missed(wanted, problem.numerics.accuracy).items()
            if name not in TEMPERATURES or not error * error_scale(name, summary) <= SMALLEST_ERROR_K}


def converges_one_way(before: float, last: float) -> bool:
    """Whether of two changes in a row the second goes on in the direction of the first, and less far."""
    return last * before > 0.0 and abs(last) < abs(before)


def estimates(grid: Resolution, without: Collection[str] = ()) -> dict[str, float]:
    """Estimated error of each reported scalar on the `grid`, over its `error_scale`.

    nan for what is given or `without` an estimate and for one grid alone, 0 for what symmetry makes zero."""
    problem, errors = grid.derived.problem, {}
    for name, scalar in SCALARS.items():
        if holds(scalar.given, problem) or name in without or math.isnan(grid.levels[-1].get(name, math.nan)):
            errors[name] = math.nan
        else:
            errors[name] = 0.0 if grid.knows(scalar) else grid.error_of(scalar)
    summary = grid.summary
    if (mean := summary["friction_mean"]) > 0.0:  # nan without friction
        # Elements that wrongly stick or slip have the coefficient at rest, of any place, in place of the mean, or the reverse.
        mistaken = errors["gamma_st"] / max(1.0 - summary["gamma_st"], 1.0 / grid.elements)
        lost = max(abs(problem.friction.at_rest * share - mean) for _, share in problem.friction.across or ((0.0, 1.0),))
        errors["friction_mean"] += mistaken * lost / error_scale("friction_mean", summary)
    moment = "spin_moment_at_contact_Nmm"
    if "contact_y_mm" in summary and (scale := error_scale(moment, summary)) > 0.0:
        # It is the moment about another place on each grid.
        errors[moment] += abs(summary["force_x_N"]) * errors["contact_y_mm"] * error_scale("contact_y_mm", summary) / scale
    if grid.derived.bodies.relaxes and grid.derived.bodies.dispersive:
        for name in LOST_IN_LAYERS:
            errors[name] += TABULATED
    return errors


@dataclass(frozen=True)
class Resolution:
    """What a grid with so many `elements` over 1.1 diameters of the contact does not see, from the scalars on it and on coarser
    ones (`levels`, coarse to fine, each side doubled); and what it misses where friction changes within elements (`uneven`,
    from `uneven_friction`); `unseen` is the share that may stick though no element does (`unseen_stick`); `inside` are the
    places in m of a line contact between which stresses at the surface do not know its border; a `thin_patch` of few elements
    decides (`has_thin_patch`), and `between` is what columns do not see of rough surfaces (`between_columns`)."""

    levels: Levels
    derived: DerivedQuantities
    elements: float
    plan: Plan
    uneven: tuple[float, float] = (0.0, 0.0)
    unseen: float = 0.0
    inside: tuple[float, float] = (math.inf, -math.inf)
    thin_patch: bool = False
    between: Between = field(default_factory=Between)

    @classmethod
    def of(cls, last: Level, levels: Levels, derived: DerivedQuantities, plan: Plan) -> Resolution:
        """That of the `last` level, with the scalars of `levels`."""
        rows, grid = np.flatnonzero(last.contact.normal.contact.any(axis=1)), last.here.grid
        inside = cls.inside
        if derived.problem.line and rows.size:
            inside = float(grid.x[rows[0]] + INSIDE * grid.dx), float(grid.x[rows[-1]] - INSIDE * grid.dx)
        return cls(levels, derived, last.elements_across, plan, uneven_friction(last.here, last.contact),
                   unseen_stick(last.here, last.contact, levels[-1]["gamma_st"]), inside,
                   has_thin_patch(last.here, last.contact.normal.pressure), between_columns(last.here, last.contact))

    def error_of(self, scalar: Scalar) -> float:
        """Estimated error of a scalar over its `error_scale`."""
        rubbed = self.rubbed if scalar.scale == "temperature" else 1.0
        carried = self.carried if scalar.kind == "resultant" else 1.0
        # Heat that is conducted flows through the border most.
        conducted = self.border if (scalar.kind in ("exchanged heat", "diffused mean")
                                    and self.derived.problem.heating.conducts) else 0.0
        centre = self.between.centre if scalar.name == "pressure_centre_MPa" else 0.0
        error = estimate([level.get(scalar.name, math.nan) for level in self.levels], error_scale(scalar.name, self.summary),
                         order=self.order(scalar.kind),
                         unresolved=(carried * self.unresolved(scalar.kind) * rubbed + self.of_steps(scalar.kind)
                                     + conducted + centre),
                         floor=carried * (FLOOR + sum(self.plan.left_out.values())),
                         safety=SAFETY_EXTRAPOLATED if scalar.name in EXTRAPOLATED else SAFETY)
        # Heat of zones narrower than an element is spread over elements.
        return worst([error, self.summary["power_balance_error"] * rubbed]) if scalar.kind == "diffused" else error

    def knows(self, scalar: Scalar) -> bool:
        """Whether a scalar vanishes because everything is its own mirror image across y = 0; without traction stick, too."""
        kinematics = self.derived.kinematics
        if not kinematics.has_traction:
            return scalar.kind in ("resultant", "stick")
        return bool(kinematics.vanishing) and scalar.vanishes == kinematics.vanishing

    def order(self, kind: Kind) -> float:
        """q of a kind of scalars."""
        if kind == "peak flux" and self.rim:
            return ORDER_AT_SURFACE
        uneven = (self.derived.dissimilar or self.derived.scales.reaches_an_end or self.thin_patch
                  or holds(UNEVEN.get(kind, False), self.derived.problem))
        return ORDER_UNEVEN if uneven else ORDER

    def unresolved(self, kind: Kind) -> float:
        """R of a kind of scalars."""
        found = 0.0 if self.plan.hertzian else max(self.border, self.one_place)
        match kind:
            case "stick":
                return max(self.border + self.thin if self.sticking else 0.0, self.unseen)
            case "area":
                return found + self.whole_row + self.between.area
            case "relative area":
                return found
            case "peak pressure":
                return self.edge + self.between.peak
            case "relative peak pressure":
                # Where nothing acts back it is that of the same grid without: 1.
                acts_back = self.derived.kinematics.feeds_back or any(map(self.plan.runs, ("deformation", "thermal crown")))
                # Both pressures miss what lies between columns, and their relation that part of its change.
                hidden = self.between.peak * abs(self.summary["gamma_p"] - 1.0)
                return self.edge + hidden if acts_back else 0.0
            case "peak":
                return self.narrow + self.edge + self.between.peak
            case "peak flux":
                # The heat of a zone narrower than an element is spread over all of it.
                return self.narrow / min(1.0, max(self.slipping, 1.0 / self.elements)) + self.edge + self.between.peak
            case "diffused":
                return SPREAD * self.narrow
            case "pressure":
                # A border that is off by a share of its element moves load as low as the pressure there.
                return found * 2.2 / self.elements
            case "diffused mean":
                return SPREAD * self.narrow + found
            case "resultant" if self.derived.kinematics.slip_varies:
                # Slip turns around the place without rigid slip: what sticks there changes its direction, and has a border.
                border = min(self.border, self.sticking)
                return SPREAD * ((1.0 - self.sticking) * (self.narrow + border) + self.unseen + self.rim)
            case "resultant" | "integral" | "exchanged heat" | "creepage" | "worn":
                # Pressure and slip grow from the borders of a place that sticks: it carries less than its share.
                slid = max(1.0 - self.sticking, self.hidden)
                return SPREAD * (slid * self.narrow + self.unseen**1.5 + self.rim) + (
                    self.sticking * self.one_place + self.strip * (2.0 * self.sticking + self.strip))  # Carter: F = μW (1 − γ²)
            case "expansion":
                # Measured from the border of the contact, which is known to an element.
                return 1.0 / self.elements
        return 0.0

    def of_steps(self, kind: Kind) -> float:
        """R by friction that changes within elements. A creepage that is found is in error by that of the force over the slope
        of Johnson's creep curve of a circle, dF/d ln ξ = 3 μW (1 − √γ_st) γ_st; so is its heat."""
        of_force, of_area = self.uneven
        if kind == "stick":
            return of_area
        if kind == "resultant" or not of_force:
            return of_force
        if kind not in ("integral", "exchanged heat", "creepage", "worn"):
            return 0.0
        slope = 3.0 * (1.0 - math.sqrt(self.sticking)) * self.sticking
        return of_force / max(slope if self.derived.problem.prescribed_force else self.carried, 1.0 / self.elements)

    def at_surface(self, of_traction: bool, x: float = math.nan) -> tuple[float, float]:
        """q and R of a stress that is largest at the surface, R over the largest pressure; of one that is the traction there,
        which is in error as the largest traction is, and not as what tractions beside it cause. One at a place `x` (m) within a
        line contact is as well, but of first order: tractions turn where stick ends."""
        if of_traction or self.inside[0] < x < self.inside[1]:
            over_pressure = self.summary["shear_max_MPa"] / self.summary["pressure_max_MPa"]
            own = self.unresolved("peak") * over_pressure
            # The end of stick is known to that part of an element, over which tractions change by μp.
            return (self.order("peak"), own) if of_traction else (
                ORDER_UNEVEN, own + AT_ONE_PLACE * self.derived.problem.friction.coefficient / self.elements)
        # At the border of the contact tractions change by μp over an element.
        kinematics, friction = self.derived.kinematics, self.derived.problem.friction
        return ORDER_AT_SURFACE, friction.coefficient / self.elements if kinematics.has_traction else 0.0

    @cached_property
    def summary(self) -> dict[str, float]:
        """Scalars of the finest grid and of the problem."""
        return {**self.levels[-1], **problem_scalars(self.derived)}

    @cached_property
    def sticking(self) -> float:
        """Share that sticks (0 without friction)."""
        return self.summary["gamma_st"] if self.derived.kinematics.has_traction else 0.0

    @property
    def border(self) -> float:
        """Error of an area whose border is found element by element."""
        return BORDER * self.elements**-1.5

    @property
    def one_place(self) -> float:
        """Error of the width of a line contact whose pressure is found, over it: its borders lie at one place of their elements
        and err alike; 0 of others."""
        return AT_ONE_PLACE * 2.2 / self.elements if self.derived.problem.line and not self.plan.hertzian else 0.0

    @property
    def hidden(self) -> float:
        """Share that may slip behind what sticks in a zone narrower than an element: no more than the contact carries, twice
        that of Carter's line contact and 1.5 times that of a circle (Vermeulen and Johnson). Of wider zones it is that in
        which borders lie at one place of their elements: those of a line contact alone."""
        counts = self.derived.problem.line or self.slipping < 1.0
        return min(1.0 / self.elements, self.carried) if counts else 0.0

    @property
    def strip(self) -> float:
        """The part of that by a strip of a few elements that sticks along the leading edge of a line contact; 0 of others."""
        if not (self.derived.problem.line and self.sticking):
            return 0.0
        return 1.0 / (self.elements * max(1.0, self.sticking * self.elements) ** 2)

    @property
    def thin(self) -> float:
        """Error of the share that sticks of a line contact by a zone of a few elements that sticks, or that slips: its border
        lies at one place of an element; 0 of others."""
        return self.strip + self.hidden / max(1.0, self.slipping) ** 2

    @property
    def rim(self) -> float:
        """Error of the area in which an interlayer yields, which has a border as the contact has; 0 without."""
        return self.border if self.derived.problem.interlayer.yield_stress is not None else 0.0

    @property
    def slipping(self) -> float:
        """m, the elements in a row that slip beside what sticks."""
        return (1.0 - self.sticking) * self.elements

    @property
    def narrow(self) -> float:
        """z = γ_st/max(1, m)²: how much is not seen in a zone of m elements that slips beside what sticks."""
        return self.sticking / max(1.0, self.slipping) ** 2

    @cached_property
    def rubbed(self) -> float:
        """Share of the heat by friction: what bodies of different temperature exchange does not come from the slip zone."""
        conducted = abs(self.summary["heat_conducted_W"]) if self.derived.problem.heating.conducts else 0.0
        return self.summary["Q_F_W"] / (self.summary["Q_F_W"] + conducted) if conducted else 1.0

    @cached_property
    def carried(self) -> float:
        """The share of μW that forces and moment carry: where all is proportional to creepage, so are errors."""
        scales = {force: error_scale(force, self.summary) for force in RESULTANTS}
        return min(1.0, math.hypot(*(self.summary[force] / scale for force, scale in scales.items() if scale > 0.0)))

    @cached_property
    def edge(self) -> float:
        """Error of the largest pressure, over it, by a maximum at the leading edge of bodies that relax that is narrower than a
        few elements, or not seen at all; 0 where another one is the largest."""
        bodies, half = self.derived.bodies, self.derived.scales.semi_axis_x
        if not bodies.relaxes:
            return 0.0
        middle = self.summary["pressure_centre_MPa"] / self.summary["pressure_max_MPa"]
        place, height = bodies.leading_edge(half)
        # Two patches have no middle.
        above = height * (1.0 if math.isnan(middle) else middle) - EDGE_BELOW
        return max(0.0, above) * min(1.0, EDGE * (2.2 * half / (self.elements * place)) ** 2)

    @cached_property
    def whole_row(self) -> float:
        """Error of the area of a contact that relaxes: where its border is not fitted inside elements, all of its leading or of
        its trailing edge is off by up to half of them, on the same side, b dx of π a b."""
        derived, bodies, elements = self.derived, self.derived.bodies, self.elements
        if not bodies.relaxes:
            return 0.0
        side, across = (2.2 * axis / elements for axis in (derived.scales.semi_axis_x, derived.scales.semi_axis_y))
        # What is lost in an element counts, too, which a border that is fitted does not know.
        unknown = max(1.0 - bodies.near_border(side, across).shear.trust, 2.0 * bodies.loss(side))
        return 2.2 / (math.pi * elements) * min(1.0, unknown)


def reported(levels: Levels, derived: DerivedQuantities) -> dict[str, float]:
    """Scalars of the last of `levels`, those in `EXTRAPOLATED` by Richardson where the last three grids converge one way."""
    values = dict(levels[-1])
    if len(levels) < 3:
        return values
    for name in EXTRAPOLATED:
        before, middle, last = (level.get(name, math.nan) for level in levels[-3:])
        if not holds(SCALARS[name].given, derived.problem) and converges_one_way(middle - before, last - middle):
            values[name] = last + (last - middle) / 3.0
    return values


# --- below the surface -----------------------------------------------------------------------------------------------


def stress_estimates(grids: Sequence[Collector], reference: Mapping[str, Any], grid: Resolution) -> dict[str, float]:
    """Estimated error of each scalar of a body below its surface on the last of the `grids`, over its `error_scale`; nan for
    those that may be larger below the last depth, or have no maximum below the surface.

    `reference` are the scalars of the state and of the problem, from which the scales follow; `grid` is that of the surface."""
    finest, floor = grids[-1], FLOOR + sum(grid.plan.left_out.values())
    values, half_the_depths, at_surface = [each.scalars() for each in grids], finest.scalars(every=2), finest.at_surface()
    of_traction, few, errors = finest.of_traction(), few_depths(finest.depths, finest.width), dict[str, float]()
    places = {name: peak.x for stress, peak in finest.peaks.items() for name in scalars_of(stress, finest.body, peak)}
    line = grid.derived.problem.line
    for name, value in values[-1].items():
        scale, is_stress = error_scale(name, reference), name.endswith("_MPa")
        # The ball of a history touches states of single elements: what they miss of its ends follows no order.
        order, border = ORDER_UNEVEN if name.startswith(OF_HISTORIES) else ORDER, 0.0
        # A stress between depths is of the order of its polynomial's points, its place of one less.
        points = PARABOLA if name in STRENGTH_SCALARS else LAYER_POINTS
        between = 1.0 if few else 2.0 ** (points - (not is_stress)) - 1.0
        if name in at_surface:
            (order, border), between = grid.at_surface(name in of_traction, places.get(name, math.nan)), 1.0
        smooth = line and name not in at_surface and order == ORDER
        unresolved = abs(half_the_depths[name] - value) / scale / between + (border if is_stress else 0.0)
        errors[name] = estimate([each[name] for each in values], scale, order=order, unresolved=unresolved, floor=floor,
                                between=smooth * (ORDER_BETWEEN - (not is_stress)), alternates=smooth and is_stress)
    for name in at_surface.intersection(errors):
        if "_depth_" in name:
            errors[name] += 2.2 / grid.elements  # The surface counts as one element deep.
        elif not name.endswith("_MPa"):
            # Along the ridge at the border the stress falls like the square of the distance.
            quantity, _, body, _ = name.rsplit("_", 3)
            errors[name] += math.sqrt(errors[f"{quantity}_max_{body}_MPa"])
    errors |= dict.fromkeys(finest.cut_off | finest.without_peak(), math.nan)
    parts = finest.parts()
    on_each = [each.rivals(parts) for each in grids]
    for quantity in on_each[-1] if len(grids) > 1 else ():
        _count_rivals(errors, quantity, finest.body, [rivals[quantity] for rivals in on_each], reference, grid)
    return errors


def _count_rivals(
    errors: dict[str, float], quantity: str, body: str, rivals: Sequence[Mapping[str, Peak]], reference: Mapping[str, Any],
    grid: Resolution,
) -> None:
    """Widen the `errors` of the largest value of a `quantity` and of its places, where it may lie elsewhere on a finer grid.

    `rivals` are the largest stresses of the parts of the depths, grid by grid. Those above "below" may still grow, as
    `Resolution.at_surface` has it. A stress that is nan does not count."""
    name, last = f"{quantity}_{body}_MPa", {part: peak for part, peak in rivals[-1].items() if not math.isnan(peak.value)}
    if math.isnan(errors[name]):
        return
    scale, own = error_scale(name, reference) * 1e6, errors[name]
    growth = {part: 0.0 for part in last}
    for part in growth.keys() - {"below"}:
        order, border = grid.at_surface(part == "traction", last[part].x)
        growth[part] = estimate([each[part].value / scale for each in rivals], 1.0, order=order, unresolved=border)
    strongest = max(last, key=lambda part: last[part].value)
    highest = last.pop(strongest)
    excess = {part: (peak.value - highest.value) / scale + growth[part] for part, peak in last.items()}
    errors[name] = worst([growth[strongest] or own, *excess.values()])
    near = [last[part] for part in last if excess[part] >= -own]
    for axis, word in (("z", "depth"), ("x", "x"), ("y", "y")):
        if (place := f"{quantity.rsplit('_', 1)[0]}_{word}_{body}_mm") in errors:
            distance = max((abs(getattr(highest, axis) - getattr(peak, axis)) for peak in near), default=0.0)
            errors[place] += 1e3 * distance / error_scale(place, reference)
