"""How much each sign of error counts in the estimate of each scalar.

An estimate is the sum of signs, each an error of the scalar over its `error_scale`, times these weights. They were fitted on
some 890 random cases (`scripts.stress`: random contacts, and the stress generator) at N = 32 and 64 against N = 160,
temperatures on 230 of them, so that 96 % of the true errors there were covered; `make stress` measures them on others.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Weights:
    """Weights of the signs of error; N counts elements over 1.1 diameters of the contact."""

    extrapolated: float = 0.0
    """Change of the extrapolated value from the last grid but one to the last."""
    smooth: float = 0.0
    """Change over the last doubling of a value that converges one way and is extrapolated."""
    last: float = 0.0
    """The same of a value that is not: it scatters, or its order is not known."""
    before: float = 0.0
    """Change over the doubling before: two values may agree by accident."""
    forces: float = 0.0
    """Largest change of forces and spin moment over the last doubling, over μW: all do not agree by accident."""
    first: float = 0.0
    """1/N: borders are located to hundredths of an element."""
    second: float = 0.0
    """1/N²: a zone of slip or stick smaller than an element."""
    dissimilar: float = 0.0
    """1/N for bodies of unlike elasticity, whose tractions begin like √s ln s."""
    narrow: float = 0.0
    """1/m² with m elements in a row that slip, at most 1: what happens in so narrow a zone is hardly resolved."""
    long: float = 0.0
    """(a/b − 1)/N for contacts elongated along rolling, whose elements are long, too."""
    near_limit: float = 0.0
    """1/N² over 1 − F/μW where a force is prescribed: close to μW the creepage grows without bound."""


WORK = Weights(extrapolated=0.33, smooth=0.08, last=0.85, before=0.22, forces=0.005, second=0.15, dissimilar=0.1,
               narrow=0.01, long=0.004, near_limit=0.04)
FORCE = Weights(extrapolated=0.42, smooth=0.13, last=0.95, before=0.15, forces=0.03, second=0.0014, dissimilar=0.025,
                narrow=0.0002, long=0.0006)
CREEPAGE = Weights(extrapolated=0.4, smooth=0.05, last=0.75, before=0.17, forces=0.003, second=0.6, dissimilar=0.1,
                   narrow=0.01, long=0.0115, near_limit=0.04)
AREA = Weights(last=0.65, before=0.23, second=0.0002, dissimilar=0.04)
PRESSURE = Weights(last=0.6, before=0.02, forces=0.014, first=0.002, second=0.0018, dissimilar=0.0016)
STICK = Weights(last=0.7, before=0.05, forces=0.08, first=0.055, second=1.1, dissimilar=0.12, narrow=0.005)
SHEAR = Weights(last=1.0, before=0.2, forces=0.1, second=0.0015, dissimilar=0.001, narrow=0.25)
FLUX = Weights(last=0.5, before=0.06, forces=0.015, first=0.0005, second=0.01, dissimilar=0.004, narrow=2.5, near_limit=0.04)
TEMPERATURE = Weights(last=0.75, before=0.12, forces=0.004, first=0.0003, second=0.01, dissimilar=0.0005, narrow=0.25,
                      near_limit=0.04)
EXPANSION = Weights(last=0.9, before=0.23, forces=0.01, second=3.0, narrow=0.03)
SHARE = Weights(last=1.4, before=0.4, forces=0.002, second=0.005, narrow=0.001)
OTHERWISE = Weights(last=0.9, before=0.12)

WEIGHTS = {
    "Q_F_W": WORK,
    "T_gamma_N": WORK,
    "heat_into_lower_W": WORK,
    "heat_into_upper_W": WORK,
    "force_x_N": FORCE,
    "force_y_N": FORCE,
    "spin_moment_Nmm": FORCE,
    "creepage_longitudinal": CREEPAGE,
    "creepage_lateral": CREEPAGE,
    "gamma_c": AREA,
    "contact_area_mm2": AREA,
    "gamma_p": PRESSURE,
    "pressure_max_MPa": PRESSURE,
    "gamma_st": STICK,
    "stick_area_mm2": STICK,
    "shear_max_MPa": SHEAR,
    "heat_flux_max_W_mm2": FLUX,
    "temperature_rise_max_lower_K": TEMPERATURE,
    "temperature_rise_max_upper_K": TEMPERATURE,
    "surface_temperature_max_lower_K": TEMPERATURE,
    "surface_temperature_max_upper_K": TEMPERATURE,
    "flash_temperature_max_lower_K": TEMPERATURE,
    "flash_temperature_max_upper_K": TEMPERATURE,
    "thermal_displacement_max_um": EXPANSION,
    "partition_mean": SHARE,
}
"""Anything not named here takes `OTHERWISE`."""
