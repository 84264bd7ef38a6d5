"""Friction as a function of slip and temperature, and the third body between the surfaces, in SI units."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from thermoroll_cli.tools.arrays import Array

FormulaName = Literal["exponential", "rational", "linear"]
LawName = Literal[FormulaName, "table"]
IntArray = NDArray[np.intp]


class LawConstant(NamedTuple):
    """A constant of a law of friction: its `name` in `FrictionLaw`, and its `key` in a case, from which options take their
    names, with its meaning and its range, all in SI units. A law has a coefficient of friction (`of_friction`) relative to the
    largest one."""

    name: str
    key: str
    meaning: str
    least: float
    most: float
    of_friction: bool = False


class Formula(NamedTuple):
    """A law of slip: the `share` of the change from the value at rest to the limit that is still to come at the slip speed s
    (over the half slip), and its derivative `slope`. The share is 1 at s = 0 and ½ at s = 1; in between and beyond it may rise
    and fall. Both take s, and the values of the `further` constants of the law."""

    share: Callable[..., Array]
    slope: Callable[..., Array]
    further: tuple[LawConstant, ...] = ()

    @property
    def constants(self) -> tuple[LawConstant, ...]:
        return LIMIT, HALF_SLIP, *self.further


LIMIT = LawConstant("limit", "limit_coefficient", "Coefficient of friction at large slip", 0, 10, of_friction=True)
HALF_SLIP = LawConstant("half_slip", "half_slip_m_s", "Slip speed at which half of the change has happened", 1e-12, 1e9)

FORMULAS: dict[FormulaName, Formula] = {
    "exponential": Formula(lambda s: np.exp2(-s), lambda s: -math.log(2.0) * np.exp2(-s)),
    "rational": Formula(lambda s: 1.0 / (1.0 + s), lambda s: -1.0 / (1.0 + s) ** 2),
    "linear": Formula(lambda s: np.maximum(1.0 - 0.5 * s, 0.0), lambda s: np.where(s < 2.0, -0.5, 0.0)),
}
LAW_CONSTANTS: dict[str, LawConstant] = {each.key: each for formula in FORMULAS.values() for each in formula.constants}
"""The constants of all laws, by key: those of a case, of the options of tables, and of what they check."""
SAMPLES = np.concatenate([[0.0], np.geomspace(1e-4, 1e4, 801), [np.inf]])
"""Slip speeds over the half slip at which the range and the steepest fall of a law are looked up."""


@dataclass(frozen=True)
class FrictionLaw:
    """Coefficient of friction over a constant, as a function f of the slip speed s in m/s.

    | `kind` | f(s) |
    | --- | --- |
    | exponential | l + (r − l) 2^(−s/h) (Polach 2005) |
    | rational | l + (r − l)/(1 + s/h) (CONTACT, Vollebregt & Schuttelaars 2012) |
    | linear | l + (r − l) max(0, 1 − s/2h) |
    | table | linear between the points of `table`, constant beyond the last; it may rise and fall |

    with the value at `rest` r, the `limit` l and the slip speed `half_slip` h at which half of the change has happened. With
    `memory` (m), friction
    follows its law only while the surfaces slide: df/dt = −max(s, s₀)/d_c (f − f(s)) with d_c = `memory` and
    s₀ = `memory_slip` (m/s), from f(0) at the leading edge.
    """

    kind: LawName
    limit: float = 1.0
    half_slip: float = 1.0
    table: tuple[tuple[float, float], ...] = ()
    memory: float = 0.0
    memory_slip: float = 1e-3
    rest: float = 1.0

    def factor(self, speed: Array) -> tuple[Array, Array]:
        """f and df/ds (s/m) at slip speeds in m/s."""
        if self.kind != "table":
            formula, change, scaled = FORMULAS[self.kind], self.rest - self.limit, speed / self.half_slip
            further = [getattr(self, constant.name) for constant in formula.further]
            return (self.limit + change * formula.share(scaled, *further),
                    change / self.half_slip * formula.slope(scaled, *further))
        speeds, factors = np.array(self.table).T
        slopes = np.append(np.diff(factors) / np.diff(speeds), 0.0)
        interval = np.clip(np.searchsorted(speeds, speed, side="right") - 1, 0, None)
        return np.interp(speed, speeds, factors), slopes[interval]

    def about_neutral(self, speed: Array) -> Array:
        """The factor of μp that the traction of an element has where its mean slip is the `speed` v (m/s) by which slip varies
        across it, if traction is linear below: the largest F = f(t) v/t of any t ≥ v, which is f(v) unless f rises more than in
        proportion. A law that rises from a small f(0) is no jump to be smoothed: F times F/f(0), if that is above 1."""
        rises = (np.where(at > speed, factor * speed / max(at, 1e-300), 0.0) for at, factor in self.table)
        factor = np.maximum.reduce([self.factor(speed)[0], *rises])
        return np.asarray(factor * np.maximum(1.0, factor / max(self.at_rest, 1e-200)))

    @property
    def at_rest(self) -> float:
        """The factor without slip."""
        return float(self.factor(np.zeros(1))[0][0])

    @property
    def _samples(self) -> Array:
        return np.array([speed for speed, _ in self.table]) if self.table else SAMPLES * self.half_slip

    @property
    def highest(self) -> float:
        """The largest factor at any slip speed."""
        return float(self.factor(self._samples)[0].max())

    def slip_of(self, factor: float) -> float:
        """The lowest slip speed in m/s at which the law rises to `factor`; 0 if it does not."""
        speeds = self._samples[np.isfinite(self._samples)]
        factors = self.factor(speeds)[0]
        if (reached := int(np.argmax(factors >= factor))) == 0:
            return 0.0
        around = slice(reached - 1, reached + 1)
        return float(np.interp(factor, factors[around], speeds[around]))

    @property
    def steepest(self) -> float:
        """The steepest fall, the largest −df/ds at any slip speed, in s/m; 0 if the law falls nowhere."""
        return max(0.0, -float(self.factor(self._samples)[1].min()))

    @property
    def rises_again(self) -> bool:
        """Whether friction rises at a higher slip than one at which it falls."""
        slopes = self.factor(self._samples)[1]
        return bool((np.maximum.accumulate(slopes < 0.0) & (slopes > 0.0)).any())

    def fall(self, speed: float = math.inf) -> float:
        """The largest fall of the factor from one slip speed to a higher one up to `speed` (m/s); 0 if it falls nowhere."""
        factors = self.factor(np.append(self._samples[self._samples < speed], speed))[0]
        return float((np.maximum.accumulate(factors) - factors).max())


@dataclass(frozen=True)
class Friction:
    """Coulomb friction: the `coefficient` μ₀, times a factor of the slip (`law`; None: 1), one of the temperature, and a
    share of the place `across` rolling. μ₀ is the scale of friction, so the largest factor of a law and the mean share over the
    pressure should be about 1.

    `across` has points (y in m, share), y increasing: the share is linear between them and constant outside; without points it
    is 1.

    Above the contact temperature `start` (K) friction falls by the share `slope` per K, down to the share `minimum`, or for a
    negative slope rises, up to the share `maximum`.
    """

    coefficient: float
    law: FrictionLaw | None = None
    slope: float = 0.0
    start: float = 0.0
    minimum: float = 0.1
    maximum: float = 2.0
    across: tuple[tuple[float, float], ...] = ()

    def spread(self, y: Array, shares: Array, mean: float) -> Friction:
        """This friction times `shares` at the places `y` (m), on the scale of their `mean`, or of a millionth of the largest;
        constant ones leave nothing across."""
        if np.ptp(shares) == 0.0:
            return replace(self, coefficient=self.coefficient * float(shares[0]), across=())
        mean = max(mean, 1e-6 * float(shares.max()))
        relative = (shares / mean).tolist()
        return replace(self, coefficient=self.coefficient * mean, across=tuple(zip(y.tolist(), relative, strict=True)))

    def share(self, y: Array) -> Array | float:
        """The share of the coefficient at the places `y` (m) across rolling."""
        return np.interp(y, *np.array(self.across).T) if self.across else 1.0

    def mean_of(self, integrand: Callable[[Array, IntArray, Array], Array], y: Array, width: float) -> Array:
        """Means (n,) over strips of the `width` (m) about the places `y` (n,), next to each other, of `integrand`(share, number
        of the strip, distance from its middle over the width): a grid counts also what lies between its points."""
        places, shares = np.array(self.across or ((0.0, 1.0),)).T
        ends = y[:, None] + 0.5 * width * np.array([-1.0, 1.0])
        nodes = np.union1d(places, ends)
        # Shares are linear between the nodes: two places of Gauss's rule are exact for them and their moments.
        half = 0.5 * np.diff(nodes)
        at = nodes[:-1] + half + half * np.array([[-1.0], [1.0]]) / math.sqrt(3.0)
        strip = np.clip(np.rint((at - y[0]) / width), 0, len(y) - 1).astype(np.intp)
        values = integrand(np.interp(at, places, shares), strip, (at - y[strip]) / width)
        integral = np.append(0.0, np.cumsum((half * values).sum(axis=0)))
        return np.asarray(np.diff(np.interp(ends, nodes, integral))[:, 0] / width)

    def mean_share(self, y: Array, width: float) -> Array:
        """The mean share over strips of the `width` (m) about the places `y` (m)."""
        return np.ones(len(y)) if not self.across else self.mean_of(lambda share, strip, offset: share, y, width)

    @property
    def symmetric(self) -> bool:
        """Whether the coefficient is its own mirror image across y = 0."""
        y = np.array([place for place, _ in self.across])
        return bool(np.all(self.share(y) == self.share(-y)))

    @property
    def largest_share(self) -> float:
        return max((share for _, share in self.across), default=1.0)

    def at(self, temperature: Array | float) -> Array:
        """μ(T) = μ₀ [1 − s (T − T₀)] above T₀, between `minimum` and `maximum` times μ₀, without law and place; T in K
        above the temperature of μ₀."""
        factor = 1.0 - self.slope * np.maximum(np.asarray(temperature) - self.start, 0.0)
        return np.asarray(self.coefficient * np.clip(factor, self.minimum, self.maximum))

    @property
    def at_rest(self) -> float:
        """The coefficient without slip."""
        return self.coefficient * (1.0 if self.law is None else self.law.at_rest)

    @property
    def limits(self) -> tuple[float, float]:
        """Least and largest coefficient where the law's factor is 1, at any temperature."""
        low, high = (self.minimum, 1.0) if self.slope > 0.0 else (1.0, self.maximum if self.slope < 0.0 else 1.0)
        return self.coefficient * low, self.coefficient * high

    @property
    def highest(self) -> float:
        """The largest coefficient at any temperature, slip and place."""
        return self.limits[1] * (1.0 if self.law is None else self.law.highest) * self.largest_share


@dataclass(frozen=True)
class Interlayer:
    """A third body between the surfaces, which shears under the traction: its tangential `compliance` h/G in m/Pa, and the
    `yield_stress` (Pa) in shear at which it deforms plastically (None: it does not). That stress grows by `hardening` (Pa/m)
    times the plastic slip of the material since it entered the contact, or falls where this is negative."""

    compliance: float = 0.0
    yield_stress: float | None = None
    hardening: float = 0.0

    @property
    def most(self) -> float | None:
        """The largest yield stress in Pa; None without limit."""
        return None if self.hardening > 0.0 else self.yield_stress

    @property
    def hardens(self) -> bool:
        """Whether its yield stress changes, up or down."""
        return self.yield_stress is not None and self.hardening != 0.0
