"""The heat of one state: its distribution, its division between the bodies, and the temperatures and expansions it causes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from thermoroll_cli.arrays import Array
from thermoroll_cli.heat.heat_response import DividedHeat, ThermalResponse
from thermoroll_cli.heat.partition import Partition, match
from thermoroll_cli.heat.recirculation import Track
from thermoroll_cli.heat.sliding_heat import SlidingHeatResponse
from thermoroll_cli.problem.contact import Mask
from thermoroll_cli.problem.problem import Heating


@dataclass(frozen=True)
class Heat:
    """Frictional heat `flux` q (W/m², (nx, ny)), the part of it that enters each body, and the bodies' `response`. `conducts`
    says whether heat also flows between the bodies without friction."""

    flux: Array
    partition: Partition
    response: ThermalResponse
    conducts: bool = False

    @property
    def into(self) -> DividedHeat:
        """Heat flux into each body."""
        return self.partition.heat

    @property
    def is_zero(self) -> bool:
        return not (self.into.lower.any() or self.into.upper.any())

    @property
    def mean_share(self) -> float:
        """Share of the frictional heat that enters the lower body; nan if there is no heat, or if bodies of different bulk
        temperatures also exchange heat that is not from friction (`conducts`)."""
        total = float(self.flux.sum())
        if total == 0.0 or self.conducts:
            return np.nan
        return self.into.share if self.into.exchanged is None else float(self.into.lower.sum()) / total

    def expansion(self) -> Array:
        """u_z^t > 0 of both bodies towards each other in m, up to a constant where sources are at rest."""
        return np.zeros(self.flux.shape) if self.is_zero else self.response.displacement(self.into)

    @property
    def tracks(self) -> tuple[Track | None, Track | None]:
        """Track of the lower and of the upper body; None for one that brings no heat back."""
        tracks: tuple[Track | None, Track | None] = getattr(self.response, "tracks", (None, None))
        return tracks

    def entry_temperatures(self) -> tuple[Array, Array]:
        """Temperature in K, (ny,), with which each track enters the contact, above what surrounds the body."""
        lower, upper = (
            np.zeros(flux.shape[1]) if track is None else track.entry_temperature(flux)
            for track, flux in zip(self.tracks, (self.into.lower, self.into.upper), strict=True)
        )
        return lower, upper

    def temperatures(self) -> tuple[Array, Array]:
        """Surface temperature rise of the lower and the upper body above their bulk temperatures in K."""
        if self.is_zero:
            return np.zeros(self.flux.shape), np.zeros(self.flux.shape)
        return self.response.temperatures(self.into)


def divide(
    heating: Heating, response: ThermalResponse, flux: Array, contact: Mask, slope: Array | None = None,
    start: Array | None = None,
) -> Heat:
    """Divide the frictional heat `flux`, which changes by `slope` along x through each element, between the bodies, as
    `heating.partition` says; `start` as in `match`."""
    if heating.partition == "matched":
        return Heat(flux, match(response, flux, contact, heating.bulk_difference, slope, start), response,
                    heating.conducts)
    return Heat(flux, Partition(DividedHeat(flux, heating.partition, slope=slope), 0.0, 0), response)


def account(heat: Heat) -> dict[str, dict[str, float]]:
    """Cost of the response: terms and error of sliding Péclet numbers, applications and mismatch of a matched partition."""

    result: dict[str, dict[str, float]] = {}
    if isinstance(heat.response, SlidingHeatResponse):
        result["sliding"] = heat.response.report()
    if heat.into.exchanged is not None:
        result["partition"] = {"applications": heat.partition.applications, "mismatch": heat.partition.mismatch}
    return result
