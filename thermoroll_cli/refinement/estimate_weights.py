"""How much each sign of error counts in the estimate of each scalar.

An estimate is the sum of signs, each an error of the scalar over its `error_scale`, times these weights. They were fitted on
some 1,550 random cases (`scripts.stress`: random contacts and the stress generator, seeds 505 to 825 and 2000 to 2499), N = 32
and 64 against five times as fine grids, so that the median of estimate over true error is as small as it can be while 97 % are
covered; `make stress` measures them on others.
"""

from __future__ import annotations

from thermoroll_cli.frozen import frozen


@frozen
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
    creepage leaves it at most 1/c², differential slip 1/c."""
    profile: float = 0.0
    """1/N for bodies with profiles: each grid samples the curvature elsewhere."""
    narrow: float = 0.0
    """1/m² with m elements in a row that slip, at most 1: what happens in so narrow a zone is hardly resolved."""
    long: float = 0.0
    """(a/b − 1)/N for contacts elongated along rolling, whose elements are long, too."""
    departure: float = 0.0
    """|γ_p − 1|/N: where the border of the contact departs from Hertz's, it is found anew on each grid."""
    near_limit: float = 0.0
    """1/N² over 1 − F/μW where a force is prescribed: close to μW the creepage grows without bound."""


WORK = Weights(extrapolated=0.23, smooth=0.11, last=1.0, before=0.17, forces=0.01, dissimilar=0.11, narrow=0.01, long=0.0038,
               near_limit=0.09)
BODY_HEAT = Weights(extrapolated=1.0, smooth=0.4, last=1.7, dissimilar=0.66, narrow=0.0035)
"""With matched temperatures: bodies can exchange much more heat than is made."""
FORCE = Weights(extrapolated=0.28, smooth=0.21, last=0.95, before=0.038, forces=0.034, second=0.0002, dissimilar=0.019,
                narrow=0.00045, long=0.0009, departure=0.01)
CREEPAGE = Weights(extrapolated=1.15, smooth=0.2, last=1.3, before=0.2, dissimilar=0.11, long=0.009, departure=0.28,
                   near_limit=0.012)
AREA = Weights(last=0.3, before=0.2, dissimilar=0.024, departure=0.2, profile=0.08)
PRESSURE = Weights(last=1.15, before=0.03, forces=0.14, first=0.0003, second=0.012, dissimilar=0.003, pole=0.07)
STICK = Weights(last=0.3, forces=0.36, first=0.004, second=2.2, missed=0.25, dissimilar=0.076, narrow=0.006, long=0.017,
                departure=0.15, near_limit=0.001)
SHEAR = Weights(last=0.6, steady=0.15, before=0.03, first=0.035, dissimilar=0.35, narrow=1.3, near_limit=0.25)
FLUX = Weights(last=0.065, steady=0.43, before=0.037, forces=0.18, narrow=4.6, near_limit=0.038)
TEMPERATURE = Weights(last=0.75, before=0.05, forces=0.004, first=0.0003, narrow=0.4, long=0.0007, near_limit=0.02)
EXPANSION = Weights(last=1.0, steady=0.35, before=0.23, forces=1.1, first=0.01, second=7.0, dissimilar=0.25, narrow=0.16,
                    long=0.02, near_limit=0.025)
FLASH = Weights(steady=2.5, before=0.35, dissimilar=0.003)
SHARE = Weights(last=1.5, before=0.45, forces=0.002)
APPROACH = Weights(last=0.22, steady=0.78, before=0.1, first=0.0005, profile=0.012)
OTHERWISE = Weights(last=0.2, steady=0.75, before=0.45)

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
