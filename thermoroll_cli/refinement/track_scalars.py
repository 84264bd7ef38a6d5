"""Temperatures of each body as its users count them, and what tracks bring back: scalars and fields of one state with heat."""

from __future__ import annotations

import math

import numpy as np

from thermoroll_cli.arrays import Array, Mask
from thermoroll_cli.heat.frictional_heat import Heat
from thermoroll_cli.numerics.peak import peak_value
from thermoroll_cli.steady_state.derived import DerivedQuantities

NAMES = (
    *(f"{name}_{body}_{unit}" for name, unit in (("bulk_temperature", "K"), ("entry_temperature_max", "K"),
      ("flash_temperature_max", "K"), ("heat_into", "W"), ("warm_up_time", "s")) for body in ("lower", "upper")),
    "recirculation_bulge_um", "thermal_crown_ratio",
)
"""What `track_scalars` makes."""


ROUNDING = 1e-12
"""Smaller differences of a sum of that size are none."""


def track_scalars(
    derived: DerivedQuantities, heat: Heat, rises: tuple[Array, Array], contact: Mask, element_area: float
) -> dict[str, float]:
    """Heat into each body in W, its bulk (mean surface), entry and flash temperatures in K; of bodies that turn also bulge,
    thermal crown Λ and time constants.

    `rises` are the temperatures of both surfaces above what surrounds them in K, (nx, ny). Bulk and entry temperatures include
    what the case says of the surroundings; the flash is the rise of this pass alone. A body that does not return is everywhere,
    and when it enters, as warm as far away.
    """
    heating = derived.problem.heating
    scalars: dict[str, float] = {}
    tracks, entries = heat.tracks, heat.entry_temperatures()
    into = heat.into.lower, heat.into.upper
    columns = contact.any(axis=0)
    for i, (body, around) in enumerate((("lower", heating.bulk_lower), ("upper", heating.bulk_upper))):
        track = tracks[i]
        scalars[f"heat_into_{body}_W"] = float(into[i].sum()) * element_area
        scalars[f"bulk_temperature_{body}_K"] = around + (0.0 if track is None else track.bulk_temperature(into[i]))
        scalars[f"entry_temperature_max_{body}_K"] = around + (0.0 if track is None else float(entries[i][columns].max()))
        flash = rises[i] - entries[i]
        scalars[f"flash_temperature_max_{body}_K"] = peak_value(flash, averages=False) if flash.max() > 0.0 else 0.0
        scalars[f"warm_up_time_{body}_s"] = math.nan if track is None else track.roller.warm_up_time
    bulge = sum(track.entry_bulge(flux) for track, flux in zip(tracks, into, strict=True) if track is not None)
    crown = np.asarray(bulge)[columns]
    # A track that is expanded evenly has rounding for a crown.
    height = float(np.ptp(crown))
    scalars["recirculation_bulge_um"] = 1e6 * height if height > ROUNDING * np.abs(crown).max() else 0.0
    scalars["thermal_crown_ratio"] = sum(
        track.crown(flux, derived.lateral_curvature)
        for track, flux in zip(tracks, into, strict=True) if track is not None
    )
    return scalars


def entry_fields(heat: Heat) -> dict[str, Array]:
    """Temperature in K with which each track enters the contact, above what surrounds the body, (nx, ny): the same along x."""
    return {
        f"entry_temperature_{body}": np.broadcast_to(entry, heat.flux.shape).copy()
        for body, entry, track in zip(("lower", "upper"), heat.entry_temperatures(), heat.tracks, strict=True)
        if track is not None
    }
