"""Thermal response of bodies that bring heat back: the half-space's response to the present pass, plus their tracks'."""

from __future__ import annotations

import numpy as np

from thermoroll_cli.kernels.arrays import Array, Mask
from thermoroll_cli.kernels.convolution import Convolution, Spectrum
from thermoroll_cli.solvers.recirculation.track import Track
from thermoroll_cli.solvers.thermal.heat_response import DividedHeat, ThermalResponse

RANK = 12
"""Most patterns across the track that the preconditioner of a matched partition knows; four to eight matter."""
NEGLIGIBLE = 1e-3
"""Patterns weaker than this, relative, it does not know."""


class RecirculatingResponse:
    """`passing` response of the present pass and the `tracks` of lower and upper body (None: does not return).

    With `bulging` false the tracks' thermal crown is left out of the displacement."""

    def __init__(self, passing: ThermalResponse, tracks: tuple[Track | None, Track | None], *, bulging: bool = True) -> None:
        self.passing, self.tracks, self.bulging = passing, tracks, bulging
        self._patterns: tuple[Array, Array] | None = None

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

    def gap_patterns(self, columns: Mask) -> tuple[Array, Array]:
        """Left and right patterns u, v, each (ny, n), with `temperature_gap` ≈ that of the present pass + u vᵀ (sum over
        rows), on the `columns` (ny,) that the contact has."""
        inside = np.flatnonzero(columns)
        left, strength, right = np.linalg.svd(self._returning[np.ix_(inside, inside)])
        n = min(RANK, int(np.count_nonzero(strength > NEGLIGIBLE * strength[0])))
        u, v = np.zeros((len(columns), n)), np.zeros((len(columns), n))
        u[inside], v[inside] = left[:, :n] * strength[:n], right[:n].T
        return u, v
