"""The heat of one state: its distribution, its division between the bodies, and the temperatures and expansions it causes.

**Matched partition** (`match`): the local division of heat for which both surfaces are equally warm wherever they touch. With
the responses K_1, K_2 of the two bodies, frictional heat q and bulk temperatures B_1, B_2, the flux q_1 into the lower body
solves, on the contact,

    (K_1 + K_2) q_1 = K_2 q + B_2 − B_1,     q_2 = q − q_1.

K_i includes the recirculating heat of a body that turns. The local share η = q_1/q is a result. It is outside [0, 1] if one
surface warms the other: near the border, and in the stick area, where heat crosses without friction.

Of an element the contact may cover a part c alone. Its flux then goes through this part, and is 1/c times the mean flux of the
element; with κ, what an element's own flux adds to the difference of temperatures, its equation is

    c [(K_1 + K_2) q_1 − K_2 q − B_2 + B_1] + (1 − c) κ (q_1 − η q) = 0,

so that elements which the border hardly reaches hardly exchange heat beside an even division η.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from thermoroll_cli.physics.heat.heat_response import DividedHeat, ThermalResponse
from thermoroll_cli.physics.heat.recirculation import RecirculatingResponse, Tracks, entry_temperatures
from thermoroll_cli.physics.heat.sliding_heat import SlidingHeatResponse
from thermoroll_cli.physics.numerics.krylov import Vector, gmres
from thermoroll_cli.problem.contact import Mask
from thermoroll_cli.problem.problem import Heating
from thermoroll_cli.tools.arrays import Array

MISMATCH_TOLERANCE = 1e-6
"""Difference of both surface temperatures inside the contact over their peak at which the division is solved."""
MOST_APPLICATIONS, RESTART_AFTER = 600, 300
"""Most applications of `ThermalResponse.temperature_difference`, and the number after which GMRES restarts. Elongated contacts
need up to ten times the usual number; conduction in partial slip at Péclet numbers of thousands needs several hundred."""


class Before(NamedTuple):
    """What heat before a step over time does at its end: temperature `rises` of the lower and the upper surface in K, and the
    `expansion` of both bodies towards each other in m, all (nx, ny)."""

    rises: tuple[Array, Array]
    expansion: Array


@dataclass(frozen=True)
class Heat:
    """Frictional heat as it goes `into` each body, and the bodies' `response` to it, beside what heat `before` does (None:
    nothing). `conducts` says whether heat also flows between the bodies without friction. Of a matched partition, `mismatch` is
    the largest difference of both surface temperatures (bulk included) inside the contact, relative to the largest rise or
    difference of bulk temperatures; `applications` are those of `temperature_difference`."""

    into: DividedHeat
    response: ThermalResponse
    conducts: bool = False
    mismatch: float = 0.0
    applications: int = 0
    before: Before | None = None

    @property
    def flux(self) -> Array:
        """q in W/m², (nx, ny)."""
        return self.into.total

    @property
    def is_zero(self) -> bool:
        return not (self.into.lower.any() or self.into.upper.any())

    @property
    def mean_share(self) -> float:
        """Share of the frictional heat that enters the lower body; nan if there is no heat, or if bodies also exchange other
        heat: of different bulk temperatures (`conducts`), or over time."""
        total = float(self.flux.sum())
        if total == 0.0 or self.conducts or (self.before is not None and self.into.exchanged is not None):
            return np.nan
        return self.into.share if self.into.exchanged is None else float(self.into.lower.sum()) / total

    def expansion(self) -> Array:
        """u_z^t > 0 of both bodies towards each other in m, up to a constant where sources are at rest."""
        expansion = np.zeros(self.flux.shape) if self.is_zero else self.response.displacement(self.into)
        return expansion if self.before is None else expansion + self.before.expansion

    @property
    def tracks(self) -> Tracks:
        """Track of the lower and of the upper body; None for a body without recirculating heat."""
        return self.response.tracks if isinstance(self.response, RecirculatingResponse) else (None, None)

    def entry_temperatures(self) -> tuple[Array, Array]:
        """Temperature in K, (ny,), with which each track enters the contact, above the surroundings of the body."""
        return entry_temperatures(self.tracks, self.into)

    def temperatures(self) -> tuple[Array, Array]:
        """Surface temperature rise of the lower and the upper body above their bulk temperatures in K."""
        nothing = np.zeros(self.flux.shape)
        rises = (nothing, nothing) if self.is_zero else self.response.temperatures(self.into)
        return rises if self.before is None else (rises[0] + self.before.rises[0], rises[1] + self.before.rises[1])

    def interface_temperatures(self) -> tuple[Array | None, Array | None]:
        """Temperature rise below the outermost coating of the lower and of the upper body in K, None without one."""
        interface_temperatures = getattr(self.response, "interface_temperatures", None)
        return (None, None) if interface_temperatures is None else interface_temperatures(self.into)


def match(
    response: ThermalResponse, flux: Array, covered: Array | Mask, bulk_difference: float = 0.0,
    slope: Array | None = None, start: Array | None = None, tolerance: float = MISMATCH_TOLERANCE, before: Before | None = None,
) -> Heat:
    """Divide the frictional heat `flux` (W/m², (nx, ny), `slope` as in `DividedHeat`) so that both surfaces are equally warm on
    the contact, which has the part `covered` of each element.

    `bulk_difference` is the bulk temperature of the upper body less that of the lower one in K, `start` the exchanged flux of a
    similar state (W/m², (nx, ny)), if known, `tolerance` that of the mismatch, `before` what heat before does. The equation
    is solved for the correction of an even division by GMRES, preconditioned with the inverse of the padded, periodic operator,
    and with 1/κ for parts that are not covered: 4 to 7 applications for 1e-4 at any grid and any Péclet numbers, fewer from a
    start. If both bodies respond alike nothing is solved.
    """
    share, contact = response.matched_share, covered > 0.0
    difference = np.full(np.count_nonzero(contact), bulk_difference)
    if before is not None:
        difference += (before.rises[1] - before.rises[0])[contact]
    if share is not None and bulk_difference == 0.0 and not difference.any():
        return Heat(DividedHeat(flux, share, slope=slope), response, before=before)
    share = response.likely_share
    even = DividedHeat(flux, share, slope=slope)
    if not contact.any() or not (flux.any() or difference.any()):
        return Heat(even, response, bulk_difference != 0.0, before=before)
    known = np.zeros(contact.shape) if start is None else np.where(contact, start, 0.0)
    lower, upper = response.temperatures(even if start is None else replace(even, exchanged=known))
    peak = max(float(np.abs(lower).max()), float(np.abs(upper).max()), float(np.abs(difference).max()))
    convolution, symbol = response.difference_symbol()
    part, own = covered[contact].astype(float), convolution.own(symbol)

    def gap(exchange: Vector) -> Vector:
        return part * response.temperature_difference(_on_grid(exchange, contact))[contact] + (1.0 - part) * own * exchange

    inverse, root = 1.0 / symbol, np.sqrt(part)

    def precondition(residual: Vector) -> Vector:
        hat = convolution.forward(_on_grid(root * residual, contact))
        hat *= inverse
        return root * convolution.inverse(hat)[contact] + (1.0 - part) / own * residual

    exchange = known[contact]
    mismatch = part * ((upper - lower)[contact] + difference) - (1.0 - part) * own * exchange
    applications = 0
    while applications < MOST_APPLICATIONS and np.abs(mismatch).max() > tolerance * peak:
        # GMRES reduces the root mean square; the mismatch is a maximum, a few times larger, and may need a second pass.
        wanted = 0.2 * tolerance * peak * np.sqrt(mismatch.size) / float(np.linalg.norm(mismatch))
        solution = gmres(gap, lambda _, image: image.copy(), precondition, mismatch, min(wanted, 0.1),
                         min(RESTART_AFTER, MOST_APPLICATIONS - applications))
        applications += solution.iterations
        exchange += solution.step
        mismatch = mismatch - solution.image
    return Heat(replace(even, exchanged=_on_grid(exchange, contact)), response, bulk_difference != 0.0,
                float(np.abs(mismatch).max()) / peak, applications, before)


def _on_grid(values: Vector, contact: Mask) -> Array:
    field = np.zeros(contact.shape)
    field[contact] = values
    return field


def divide(
    heating: Heating, response: ThermalResponse, flux: Array, covered: Array | Mask, slope: Array | None = None,
    start: Array | None = None, tolerance: float = MISMATCH_TOLERANCE, before: Before | None = None,
) -> Heat:
    """Divide the frictional heat `flux`, which changes by `slope` along x through each element, between the bodies, as
    `heating.partition` says; `covered`, `start`, `tolerance` and `before` as in `match`."""
    if heating.partition == "matched":
        return match(response, flux, covered, heating.bulk_difference, slope, start, tolerance, before)
    return Heat(DividedHeat(flux, heating.partition, slope=slope), response, before=before)


def account(heat: Heat) -> dict[str, dict[str, float]]:
    """Cost of the response: terms and error of sliding Péclet numbers, applications and mismatch of a matched partition."""
    result: dict[str, dict[str, float]] = {}
    if isinstance(heat.response, SlidingHeatResponse):
        result["sliding"] = heat.response.report()
    if heat.into.exchanged is not None:
        result["partition"] = {"applications": heat.applications, "mismatch": heat.mismatch}
    return result
