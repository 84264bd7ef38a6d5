"""Thermal response of bodies that bring heat back: the half-space's response to the present pass, plus their tracks'."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from thermoroll_cli.arrays import Array, Mask
from thermoroll_cli.heat.heat_response import DividedHeat, ThermalResponse
from thermoroll_cli.heat.track import Track
from thermoroll_cli.numerics.convolution import Convolution, Spectrum

RANK = 12
"""Most patterns across the track that the preconditioner of a matched partition knows; four to eight matter."""
NEGLIGIBLE = 0.03
"""Patterns weaker than this, relative, it does not know: each costs as much as half an application."""
CHANGED = 0.1
"""Share of a contact's elements that may come and go before the patterns are inverted for it anew."""


class RecirculatingResponse:
    """`passing` response of the present pass and the `tracks` of lower and upper body (None: does not return).

    With `bulging` false the tracks' thermal crown is left out of the displacement."""

    def __init__(self, passing: ThermalResponse, tracks: tuple[Track | None, Track | None], *, bulging: bool = True) -> None:
        self.passing, self.tracks, self.bulging = passing, tracks, bulging
        self._patterns: tuple[Mask, Array, Array] | None = None

    def is_like(self, other: RecirculatingResponse) -> bool:
        """Whether both are made of the same responses."""
        same = all(one is another for one, another in zip(self.tracks, other.tracks, strict=True))
        return same and self.passing is other.passing and self.bulging == other.bulging

    @property
    def matched_share(self) -> float | None:
        """As `ThermalResponse`: bodies alike must also return and be cooled alike."""
        lower, upper = self.tracks
        alike = lower is upper if lower is None or upper is None else lower.roller == upper.roller
        return self.passing.matched_share if alike else None

    @property
    def likely_share(self) -> float:
        """As `ThermalResponse`, with as much resistance added as both tracks have in the middle."""
        return self.passing.likely_share

    def displacement(self, heat: DividedHeat) -> Array:
        """As `ThermalResponse`."""
        expansion = self.passing.displacement(heat)
        if self.bulging:
            for track, flux in zip(self.tracks, (heat.lower, heat.upper), strict=True):
                if track is not None:
                    expansion += track.entry_bulge(flux)
        return expansion

    def temperatures(self, heat: DividedHeat) -> tuple[Array, Array]:
        """As `ThermalResponse`, above what surrounds each body: what the track brings back is a function of y alone."""
        lower, upper = self.passing.temperatures(heat)
        before, above = self.entry_temperatures(heat)
        return lower + before, upper + above

    def entry_temperatures(self, heat: DividedHeat) -> tuple[Array, Array]:
        """Temperatures (K, (ny,)) with which the tracks meet the contact; 0 for a body that does not return."""
        lower, upper = (
            np.zeros(flux.shape[1]) if track is None else track.entry_temperature(flux)
            for track, flux in zip(self.tracks, (heat.lower, heat.upper), strict=True)
        )
        return lower, upper

    def temperature_gap(self, exchange: Array) -> Array:
        """As `ThermalResponse`."""
        return self.passing.temperature_gap(exchange) + self._returning @ exchange.sum(axis=0)

    def gap_symbol(self) -> tuple[Convolution, Spectrum]:
        """As `ThermalResponse`, of the present pass."""
        return self.passing.gap_symbol()

    @property
    def _returning(self) -> Array:
        """Sum of both tracks' temperatures, (ny, ny)."""
        total = sum(track.temperature for track in self.tracks if track is not None)
        return np.asarray(total)

    def gap_patterns(self, contact: Mask, inverted: Callable[[Array], Array]) -> tuple[Array, Array]:
        """As `ThermalResponse`, with u and v from the singular vectors on the columns that the contact has."""
        known = self._patterns
        if known is None or np.count_nonzero(known[0] ^ contact) > CHANGED * np.count_nonzero(contact):
            inside = np.flatnonzero(contact.any(axis=0))
            left, strength, right = np.linalg.svd(self._returning[np.ix_(inside, inside)])
            n = min(RANK, int(np.count_nonzero(strength > NEGLIGIBLE * strength[0])))
            u, v = np.zeros((contact.shape[1], n)), np.zeros((contact.shape[1], n))
            u[inside], v[inside] = left[:, :n] * strength[:n], right[:n].T
            known = self._patterns = contact.copy(), np.stack([inverted(contact * one) for one in u.T]), v
        return known[1], known[2]
