"""Commented case files to start from."""

from __future__ import annotations

from dataclasses import dataclass
from string import Template


@dataclass(frozen=True)
class _Values:
    """What tells one template from another. `more` are tables and comments of its own, put before [numerics]; `profile` is a
    table in [geometry], of the body whose lateral radius is None."""

    about: str
    title: str
    radii: tuple[float, float | None, float, float | None]
    normal: float
    friction: float
    speed: float
    longitudinal: float
    spin: float
    peclet: str = "rolling"
    numerics: str = "accuracy = 1e-3"
    conductivity: float = 50.2
    diffusivity: float = 10.0
    more: str = ""
    profile: str = ""
    partition: str = "0.5"


_WORN_RAIL = """\
points_mm = [
    [-24, -0.5995], [-22, -0.4862], [-20, -0.3863], [-18, -0.2997], [-16, -0.2264], [-14, -0.1665], [-12, -0.1199],
    [-10, -0.0833], [-8, -0.0533], [-6, -0.03], [-4, -0.0133], [-2, -0.0033], [0, 0], [2, -0.0034], [4, -0.0134],
    [6, -0.0301], [8, -0.0534], [10, -0.1054], [12, -0.2074], [14, -0.3594], [16, -0.5614], [18, -0.8134],
    [20, -1.1155], [22, -1.4675], [24, -1.8695],
]"""

TEMPLATES = {
    "article": _Values(
        about="Two steel spheres, the case of Sec. 4.1 of Yu & Suh. The article's speed of 1 m/s gives far less heat\n"
        "# than it reports; at 200 m/s with stationary heat sources its pressure peak and its leading edge are met.",
        title="Sphere on sphere",
        radii=(30.0, 30.0, 30.0, 30.0),
        normal=65.0,
        friction=0.3,
        speed=200.0,
        longitudinal=0.003,
        spin=0.0,
        peclet="stationary",
        numerics="grid = 128",
    ),
    "wheel-rail": _Values(
        about="A railway wheel (upper) with a worn, concave tread on a rail head with a crown radius of 300 mm.",
        title="Wheel on rail",
        radii=(float("inf"), 300.0, 500.0, -400.0),
        normal=100e3,
        friction=0.3,
        speed=30.0,
        longitudinal=0.002,
        spin=0.0,
        conductivity=50.0,
        diffusivity=14.2,
    ),
    "ball-bearing": _Values(
        about="A ball of 12.7 mm diameter (upper) in the groove of an inner ring (lower): concave across rolling.",
        title="Ball in a grooved raceway",
        radii=(22.0, -6.6, 6.35, 6.35),
        normal=300.0,
        friction=0.1,
        speed=5.0,
        longitudinal=0.0005,
        spin=0.01,
        conductivity=46.6,
        diffusivity=12.5,
    ),
    "traction-drive": _Values(
        about="Two rollers of a traction drive, the upper one crowned, near their largest tangential force.",
        title="Traction drive",
        radii=(40.0, 40.0, 40.0, 200.0),
        normal=1500.0,
        friction=0.08,
        speed=10.0,
        longitudinal=0.004,
        spin=0.0,
        conductivity=46.6,
        diffusivity=12.5,
    ),
    "roller": _Values(
        about="A cylindrical roller of 20 mm diameter and 10 mm length (upper) on a flat raceway, its ends relieved by a\n"
        "# logarithmic crown.",
        title="Crowned roller on a flat raceway",
        radii=(float("inf"), float("inf"), 10.0, None),
        normal=2000.0,
        friction=0.1,
        speed=2.0,
        longitudinal=0.0007,
        spin=0.0,
        conductivity=46.6,
        diffusivity=12.5,
        profile="""\
# The height is drop ln(1 - (2|y|/length)^2); flat_mm leaves the middle straight.
[geometry.upper_profile]
kind = "logarithmic"
length_mm = 10.0
drop_um = 1.0
flat_mm = 0.0
offset_mm = 0.0
tilt_mrad = 0.0
""",
    ),
    "worn-rail": _Values(
        about="A railway wheel (upper, tread hollowed to 900 mm) on a worn rail: flattened on top, gauge corner at y > 8 mm.",
        title="Wheel on a worn rail",
        radii=(float("inf"), None, 460.0, -900.0),
        normal=80e3,
        friction=0.3,
        speed=30.0,
        longitudinal=0.0015,
        spin=5.4e-05,
        conductivity=50.0,
        diffusivity=14.2,
        profile=f"""\
# Pairs [y, height] in mm, height positive out of the body; or file = "rail.csv" with two columns, beside this file.
[geometry.lower_profile]
{_WORN_RAIL}
interpolation = "cubic"
offset_mm = 0.0
tilt_mrad = 0.0
""",
    ),
    "twin-disc": _Values(
        about="A twin-disc machine, one disc crowned: both bring their heat back every turn, and the bulk warms up.",
        title="Twin disc",
        radii=(23.5, float("inf"), 23.5, 200.0),
        normal=1500.0,
        friction=0.4,
        speed=3.0,
        longitudinal=0.02,
        spin=0.0,
        partition='"matched"',
        more="""\
# Each disc turns, meets the contact once per turn, and is cooled: by convection on rim and ends, or as a whole through a
# thermal resistance (mean temperature of its surface per watt), which shafts mostly decide.
[thermal.lower]
recirculate = true
thermal_resistance_K_W = 4.0
# instead of the resistance: convection_W_m2K = 50.0
width_mm = 10.0
passes_per_revolution = 1

[thermal.upper]
recirculate = true
thermal_resistance_K_W = 4.0
width_mm = 10.0
passes_per_revolution = 1

""",
    ),
}
"""Name of each template of `thermoroll init`. A new one is an entry here."""

_COMES_BACK = """\
# A body that turns brings its heat back, and warms up until it loses as much to its surroundings. For both bodies see
# thermoroll init --template twin-disc.
# [thermal.upper]
# recirculate = true
# convection_W_m2K = 50.0

"""
"""Offered where material rolls through the contact and `more` says nothing of it."""

_TEXT = Template("""\
# $about
#
# Units are part of the keys. `thermoroll validate` checks this file, `thermoroll show` explains it,
# `thermoroll run` solves it.

title = "$title"

# Of both bodies. Without the last three constants and [thermal] the case is purely mechanical. For two materials call this
# table [material.lower], and add another:
[material]
youngs_modulus_GPa = 210.0
poisson_ratio = 0.28
conductivity_W_mK = $conductivity
expansion_um_mK = 11.7      # 1e-6 per K
diffusivity_mm2_s = $diffusivity

# [material.upper]            # silicon nitride
# youngs_modulus_GPa = 310.0
# poisson_ratio = 0.27
# conductivity_W_mK = 25.0
# expansion_um_mK = 3.0
# diffusivity_mm2_s = 11.0

# Radii along rolling (x) and across (y); inf is flat, negative is concave. Instead of a radius across rolling a body may have a
# profile: see thermoroll init --template roller, and worn-rail.
[geometry]
$geometry
[load]
normal_N = $normal
friction_coefficient = $friction
# friction_temperature_slope_1_K = 0.001    # share of the friction lost per kelvin of the contact's temperature,
# friction_temperature_start_K = 0.0        # above this one,
# friction_minimum_factor = 0.3             # and the share that remains however hot it gets

# Mean speed of both surfaces.
[rolling]
speed_m_s = $speed

# Slip of the lower body against the upper one, over the rolling speed.
[creepage]
longitudinal = $longitudinal
lateral = 0.0
spin_rad_mm = $spin

# A force in place of the creepage of its direction, which is then solved for: take that creepage out above.
# [force]
# longitudinal_N = $force
# lateral_N = 0.0

# heat: false is a purely mechanical case; deformation: with false there are temperatures, but the bodies keep their shape;
# with true deformation is left out where its effect is below the accuracy, with "always" never.
# peclet: with "rolling" the material carries the heat through the contact; "stationary" is as if nothing moved.
# partition: share of the heat that enters the lower body.
[thermal]
heat = true
deformation = true
peclet = "$peclet"
partition = $partition
# partition = "matched"             # instead: divided so that the surfaces are equally warm wherever they touch,
# bulk_temperature_lower_K = 0.0    # also where one body is hotter far from the contact
# bulk_temperature_upper_K = 20.0

$more# An accuracy wanted in the scalars, or a grid: elements per side, or [nx, ny].
# extent: side of the domain in Hertz semi-axes; the contact itself takes 2.
[numerics]
$numerics
extent = 2.2

# Stresses and temperatures inside the bodies, with their largest values; fields = "full" keeps them everywhere, not only on
# the plane of rolling.
# [subsurface]
# bodies = ["lower", "upper"]
# fields = "plane"

[output]
plots = true
""")


def template_text(name: str) -> str:
    """The template `name` as the text of a case file. Raises KeyError for a name there is none of."""
    values = TEMPLATES[name]
    fields = dict(vars(values))
    keys = ("lower_radius_x_mm", "lower_radius_y_mm", "upper_radius_x_mm", "upper_radius_y_mm")
    geometry = "".join(f"{key} = {value}\n" for key, value in zip(keys, fields.pop("radii"), strict=True) if value is not None)
    fields["more"] = values.more or (_COMES_BACK if values.peclet == "rolling" else "")
    profile = fields.pop("profile")
    geometry += f"\n{profile}" if profile else ""
    force = float(f"{0.5 * values.friction * values.normal:.4g}")
    return _TEXT.substitute(fields | {"geometry": geometry, "force": force})
