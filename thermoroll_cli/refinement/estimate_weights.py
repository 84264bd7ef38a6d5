"""How much each sign of error counts in the estimate of each scalar.

An estimate is the sum of signs, each an error of the scalar over its `error_scale`, times these weights. They were fitted on
some 3,300 random cases (`scripts.stress`: random contacts and the stress generator, seeds 505 to 825, 2000 to 2499, 4000 to
4499, 5000 to 5199, 6000 to 6094 and 6250 to 6379), and on 86 as they are met (`cases/`, those of the article at other speeds,
tests/reference/estimate_references.json), N = 32 and 64 against five times as fine grids. The median of estimate over true
error is as small as it can be while 97 % are covered and few fall short by six times; `make stress` measures them on others.
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
    steady: float = 0.0
    """`last` times its ratio to `before`, at most 1: what is left of a value that goes on converging as it did."""
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
    pole: float = 0.0
    """μ|β| over the elements that stick side by side, at most that: where unlike bodies spin, the tractions turn about a point,
    and there the pressure grows like ln N."""
    missed: float = 0.0
    """1/N where no element sticks though some may: finer grids can find a patch of stick. Spin of c times the saturation
    creepage leaves it at most some 1/c², differential slip 1/c."""
    profile: float = 0.0
    """1/N for bodies with profiles: each grid samples the curvature elsewhere."""
    narrow: float = 0.0
    """1/m² with m elements in a row that slip, at most 1: what happens in so narrow a zone is hardly resolved."""
    long: float = 0.0
    """(a/b − 1)/N for contacts elongated along rolling, whose elements are long, too."""
    departure: float = 0.0
    """|γ_p − 1|/max(γ_p, 1)/N: where the border of the contact departs from Hertz's, it is found anew on each grid."""
    uneven: float = 0.0
    """|γ_p − 1|/N, at most |β|/N, for bodies of unlike elasticity: tractions that shift the pressure do so unevenly."""
    near_limit: float = 0.0
    """1/N² over 1 − F/μW where a force is prescribed: close to μW the creepage grows without bound."""


WORK = Weights(extrapolated=0.23, smooth=0.11, last=0.7, before=0.23, forces=0.021, second=0.014, dissimilar=0.072,
               profile=0.034, narrow=0.0125, long=0.004, departure=0.025, uneven=0.8, near_limit=0.08)
BODY_HEAT = Weights(extrapolated=0.45, smooth=0.18, before=0.5, first=0.03, dissimilar=0.5, narrow=0.018)
"""With matched temperatures, where bodies can exchange much more heat than is made: part of the errors of both comes on top."""
FORCE = Weights(extrapolated=0.44, smooth=0.2, last=0.65, before=0.25, forces=0.042, second=0.002, dissimilar=0.037,
                narrow=0.0003, long=0.0015, departure=0.001)
CREEPAGE = Weights(extrapolated=1.25, smooth=0.07, last=1.45, before=0.32, forces=0.042, dissimilar=0.135, narrow=0.0068,
                   long=0.0064, near_limit=0.0105)
AREA = Weights(last=0.17, before=0.28, dissimilar=0.02, profile=0.08, departure=0.25)
PRESSURE = Weights(last=0.25, before=0.03, first=0.0018, second=0.05, pole=0.4, departure=0.1, uneven=3)
STICK = Weights(last=0.3, steady=0.25, before=0.005, forces=0.24, first=0.0035, second=1.6, dissimilar=0.098, missed=0.5,
                profile=0.12, narrow=0.0055, long=0.017, departure=0.05, uneven=0.8, near_limit=0.003)
SHEAR = Weights(last=0.54, steady=0.09, before=0.085, first=0.053, pole=0.8, narrow=1.3, uneven=6)
FLUX = Weights(last=0.065, steady=0.43, before=0.06, forces=0.15, narrow=4.3, near_limit=0.03)
TEMPERATURE = Weights(last=0.58, before=0.05, dissimilar=0.015, narrow=0.48, near_limit=0.021)
EXPANSION = Weights(last=0.84, before=0.32, first=0.073, second=7.8, dissimilar=0.2, narrow=0.026, long=0.023,
                    departure=0.5, near_limit=0.008)
FLASH = Weights(steady=3.6, before=0.17, second=0.0075, dissimilar=0.4, departure=0.04)
SHARE = Weights(last=0.9, before=0.27, second=0.2, dissimilar=0.014, pole=0.4, narrow=0.06)
APPROACH = Weights(steady=0.58, before=0.065, first=0.0005, second=0.4, profile=0.012, departure=0.5, uneven=1)
OTHERWISE = Weights(last=0.05, steady=0.88, before=0.27, forces=0.0085, dissimilar=0.008, pole=0.28, missed=0.008,
                    profile=0.01, narrow=0.0095)

WEIGHTS = {
    "Q_F_W": WORK,
    "T_gamma_N": WORK,
    "heat_into_lower_W": BODY_HEAT,
    "heat_into_upper_W": BODY_HEAT,
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
    "flash_temperature_max_lower_K": FLASH,
    "flash_temperature_max_upper_K": FLASH,
    "thermal_displacement_max_um": EXPANSION,
    "partition_mean": SHARE,
    "recirculation_bulge_um": EXPANSION,
    "approach_um": APPROACH,
}
"""Anything not named here takes `OTHERWISE`."""
