"""The case file as data: every table and key with its unit, meaning, range and words, in the units of the keys.

A new key is one line here, and one where `case_problem` puts it into the problem. Conflicts between keys: `case_conflicts`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import AllowInfNan, BeforeValidator, Field, WithJsonSchema, create_model
from pydantic_core import PydanticCustomError

from thermoroll_cli.files.case_bearing import BearingTable
from thermoroll_cli.files.case_history import HistoryTable
from thermoroll_cli.files.case_surface import SurfacesTable
from thermoroll_cli.files.case_table import (
    LARGEST_PROFILE,
    Allowed,
    LengthUnit,
    Pair,
    Table,
    pairs,
    quantity,
    signed_length,
    unit_key,
)
from thermoroll_cli.files.case_wheelset import TrackTable, WheelsetTable
from thermoroll_cli.problem.friction import FORMULAS, LAW_CONSTANTS, LawName
from thermoroll_cli.problem.kinds import Kind, kind_in
from thermoroll_cli.problem.names import GROUPS
from thermoroll_cli.problem.problem import BODIES

THERMAL_CONSTANTS = ("conductivity_W_mK", "expansion_um_mK", "diffusivity_mm2_s")
GRID_RANGE = (8, 2048)
RADIUS_RANGE = (1e-6, 1e9)
MOST_LAYERS = 5

_BULK = "far from the contact, above the temperature to which the coefficient of friction belongs"


def _grid(value: Any) -> int | tuple[int, int]:
    sides = value if isinstance(value, list | tuple) else (value, value)
    if len(sides) != 2 or not all(isinstance(side, int) and not isinstance(side, bool) for side in sides):
        raise PydanticCustomError("grid", "must be a whole number or a list of two")
    if not all(GRID_RANGE[0] <= side <= GRID_RANGE[1] for side in sides):
        raise PydanticCustomError("grid", "is outside the allowed range")
    return value if isinstance(value, int) else (sides[0], sides[1])


def _one_line(value: Any) -> Any:
    if isinstance(value, str) and not value.isprintable():
        raise PydanticCustomError("title", "must be one line without control characters")
    return value


_SIDE: dict[str, Any] = {"type": "integer", "minimum": GRID_RANGE[0], "maximum": GRID_RANGE[1]}
Radius = Annotated[
    float, AllowInfNan(True), signed_length(*RADIUS_RANGE, zero="must not be zero: a flat body has the radius inf"),
    # JSON has no infinity: editors that check TOML by this schema hand inf on as null.
    WithJsonSchema({"type": ["number", "null"], "minimum": -RADIUS_RANGE[1],
                    "not": {"type": "number", "exclusiveMinimum": -RADIUS_RANGE[0], "exclusiveMaximum": RADIUS_RANGE[0]}}),
    Allowed("a number of either sign (negative is concave), 1e-6 to 1e9 in magnitude, or inf (flat), in mm"),
]  # fmt: skip


class RelaxationFile(Table):
    """Measured moduli, to which a series is fitted."""

    file: Annotated[str, Allowed("the name of a file")] = Field(
        description="Columns frequency_Hz, storage_GPa, loss_GPa, named in the first row", max_length=1000)


class MaterialConstants(Table):
    """Constants of one material."""

    youngs_modulus_GPa: float = quantity("Young's modulus", ge=1e-9, le=1e6)
    poisson_ratio: float = quantity("Poisson's ratio", ge=0, le=0.5)
    conductivity_W_mK: float | None = quantity("Thermal conductivity", None, ge=1e-6, le=1e6)
    expansion_um_mK: float | None = quantity("Linear thermal expansion", None, ge=0, le=1e6)
    diffusivity_mm2_s: float | None = quantity("Thermal diffusivity", None, ge=1e-9, le=1e12)
    relaxation: list[Pair] | None = pairs(
        "[share, time in s]: shares above 0 with a sum below 1, times from 1e-12 to 1e12",
        "[share of the modulus that relaxes, time in s]; youngs_modulus_GPa is then the instantaneous one", most=40)
    relaxation_file: RelaxationFile | None = Field(default=None, description="The same from measured moduli")


class CoatingTable(MaterialConstants):
    """A bonded layer of the coating of a body."""

    thickness_um: float = quantity("Thickness of the layer", ge=1e-6, le=1e9)
    shear_yield_MPa: float | None = quantity("Shear yield stress; without it this layer does not yield", None, ge=1e-12, le=1e9)


class MaterialTable(MaterialConstants):
    """Constants of the material of a body, and its coating."""

    density_kg_m3: float | None = quantity("Density, of the balls of a bearing (7800 if left out) and for worn masses", None,
                                           ge=1, le=1e5)  # fmt: skip
    layers: Annotated[list[CoatingTable] | None, Allowed(f"1 to {MOST_LAYERS} tables, from the surface down")] = Field(
        default=None, description="Coating: bonded layers, from the surface down", min_length=1, max_length=MOST_LAYERS
    )


class TwoMaterials(Table):
    """A material for each body."""

    lower: MaterialTable = Field(description="Material of the lower body")
    upper: MaterialTable = Field(description="Material of the upper body")


class ProfileTable(Table):
    """Shape of a body across rolling, instead of a lateral radius: points, a file of them, or a crown."""

    points_mm: list[Pair] | None = pairs("[y, height] of numbers in mm, y increasing",
                                         "[y, height] in mm, y increasing, height positive out of the body", least=2)
    file: Annotated[str | None, Allowed("the name of a file with two columns")] = Field(
        default=None, description="Two columns y and height in mm, or .prr, .prw, .ban, .whl", max_length=1000
    )
    kind: Literal["logarithmic"] | None = Field(default=None, description="A crown: height = drop ln(1 - (2|y|/length)^2)")
    length_mm: float | None = quantity("Length of the crown, end to end", None, ge=1e-9, le=1e9)
    drop_um: float | None = quantity("Drop of the crown", None, ge=1e-9, le=1e9)
    flat_mm: float | None = quantity("Length of the crown's middle part without drop", None, ge=0, le=1e9)
    unit: LengthUnit | None = unit_key("the file; else as it says, or mm")
    height_unit: LengthUnit | None = unit_key("its heights, if that differs")
    interpolation: Literal["cubic", "linear"] = Field(
        default="cubic", description="Between points: a spline of continuous curvature, or straight lines"
    )
    offset_mm: float = quantity("Shift of the profile towards +y", 0.0, ge=-1e9, le=1e9)
    tilt_mrad: float = quantity("Rise of the profile towards +y", 0.0, ge=-500, le=500)
    mirror: bool = Field(default=False, description="Change the sign of y, of points or a file from the other side")
    flip: bool = Field(default=False, description="Change the sign of the height, of a profile that is upside down")
    smoothing_mm: float = quantity("Wavelength of which smoothing leaves half of the amplitude; 0: none", 0.0, ge=0, le=1e3)


Profile = Annotated[ProfileTable, Allowed("a table: points_mm, file or kind")]


class GeometryTable(Table):
    """Principal radii of both bodies. inf is flat, negative is concave. Across rolling a body may have a profile instead."""

    lower_radius_x_mm: Radius = quantity("Radius of the lower body along rolling")
    lower_radius_y_mm: Radius | None = quantity("Radius of the lower body across rolling, unless it has a profile", None)
    upper_radius_x_mm: Radius = quantity("Radius of the upper body along rolling")
    upper_radius_y_mm: Radius | None = quantity("Radius of the upper body across rolling, unless it has a profile", None)
    conformal: bool = Field(default=False, description="The contact follows the curved common surface of both bodies")
    lower_profile: Profile | None = Field(default=None, description="Profile of the lower body across rolling")
    upper_profile: Profile | None = Field(default=None, description="Profile of the upper body across rolling")


class LoadTable(Table):
    """Normal load, of a line contact per length, and the coefficient of friction."""

    normal_N: float | None = quantity("Normal load; a wheelset has its own", None, ge=1e-15, le=1e15)
    normal_N_mm: float | None = quantity("Normal load per length of bodies that are long across rolling: a line contact; "
                                         "instead of normal_N", None, ge=1e-15, le=1e15)  # fmt: skip
    hertz_pressure_MPa: float | None = quantity(
        "Hertz's peak pressure of the smooth, elastic bodies, which determines the load; of two that are flat across that per "
        "length; instead of normal_N", None, ge=1e-9, le=1e9)
    approach_um: float | None = quantity("Approach of the bodies, which determines the load; instead of normal_N", None,
                                         ge=1e-9, le=1e9)  # fmt: skip
    vertical_N: float | None = quantity("Vertical force of a conformal contact, traction included; instead of normal_N", None,
                                        ge=1e-15, le=1e15)  # fmt: skip
    friction_coefficient: float | None = quantity("Coulomb's coefficient of friction; or of each place in [friction]",
                                                  None, ge=0, le=10)  # fmt: skip


OVER_ANGLE = "[degrees, coefficient], degrees increasing from -180 to 180, coefficients from 0 to 10"


class RailFrictionTable(Table):
    """Friction on one rail, where it differs from the other."""

    over_angle: list[Pair] | None = pairs(OVER_ANGLE, "The same for this rail")


class PlacesOfFriction(Table):
    """The keys of [friction] up to the law."""

    over_angle: list[Pair] | None = pairs(
        OVER_ANGLE, "[inclination of the rail's surface in degrees, negative towards the gauge face, coefficient of friction], "
        "of a wheelset, instead of load.friction_coefficient")
    across: list[Pair] | None = pairs(
        "[y, coefficient], y increasing, coefficients from 0 to 10",
        "[y in mm, coefficient of friction] of bodies with profiles, instead of load.friction_coefficient")
    left: RailFrictionTable | None = Field(default=None, description="The left rail, where it differs")
    right: RailFrictionTable | None = Field(default=None, description="The right rail, where it differs")

    law: LawName | None = Field(default=None, description="How friction changes with the slip speed; constant if left out")


def _with_constants_of_laws(table: type[Table]) -> type[Table]:
    """`table` with a key for each constant of a law of friction."""
    keys: dict[str, Any] = {}
    for constant in LAW_CONSTANTS.values():
        laws = [name for name, formula in FORMULAS.items() if constant in formula.constants]
        which = "unless law is a table" if len(laws) == len(FORMULAS) else f"if law is {' or '.join(laws)}"
        keys[constant.key] = float | None, quantity(f"{constant.meaning}, {which}", None, ge=constant.least, le=constant.most)
    return create_model("ConstantsOfLaws", __base__=table, **keys)


if TYPE_CHECKING:
    ConstantsOfLaws = PlacesOfFriction
else:
    ConstantsOfLaws = _with_constants_of_laws(PlacesOfFriction)


class FrictionTable(ConstantsOfLaws):
    """Dependence of the coefficient of friction on place, slip and the temperature of the contact."""

    table: list[Pair] | None = pairs("[slip speed, coefficient] of numbers, slip speeds in m/s increasing from 0",
                                     "[slip speed in m/s, coefficient of friction] of a table", least=2)
    memory_um: float = quantity("Sliding distance over which friction follows its law; 0: at once", 0.0, ge=0, le=1e9)
    memory_slip_mm_s: float = quantity("Least slip speed with which memory fades", 1.0, ge=1e-9, le=1e9)
    temperature_slope_1_K: float = quantity(
        "Share of the coefficient of friction lost per kelvin of contact temperature (negative: gained)", 0.0, ge=-10, le=10)
    temperature_start_K: float = quantity("Contact temperature from which the coefficient of friction changes", 0.0,
                                          ge=-1e4, le=1e4)
    temperature_minimum_factor: float = quantity(
        "Share of the coefficient of friction that remains however hot the contact gets", 0.1, ge=0, le=1)
    temperature_maximum_factor: float = quantity(
        "Multiple of the coefficient of friction that it never exceeds, however hot the contact gets", 2.0, ge=1, le=100)

    @property
    def coefficients(self) -> list[float]:
        """The coefficients that the law names, in the order of slip."""
        limits = (getattr(self, key) for key, constant in LAW_CONSTANTS.items() if constant.of_friction)
        return [*(coefficient for _, coefficient in self.table or ()), *(limit for limit in limits if limit is not None)]


def coefficient_at_rest(load: LoadTable, friction: FrictionTable) -> float:
    """The coefficient of friction without slip, the largest of all places."""
    tables = (friction.over_angle, friction.across, *(side.over_angle for side in (friction.left, friction.right) if side))
    return max(load.friction_coefficient or 0.0, 0.0, *(mu for table in tables for _, mu in table or ()))


class InterlayerTable(Table):
    """A third body between the surfaces, which shears under the traction."""

    compliance_um_GPa: float | None = quantity("Thickness of the interlayer over its shear modulus; 0: none", None,
                                               ge=0, le=1e12)  # fmt: skip
    yield_MPa: float | None = quantity("Shear stress at which the interlayer deforms plastically", None, ge=1e-9, le=1e9)
    hardening_MPa_um: float = quantity("Growth of that stress with the plastic slip of the material; negative: it softens", 0.0,
                                       ge=-1e5, le=1e5)  # fmt: skip


class RollingTable(Table):
    """Rolling motion."""

    speed_m_s: float | None = quantity("Rolling speed, mean of both bodies; a bearing has its own; 0 with [history] alone",
                                       None, ge=0, le=1e9)  # fmt: skip
    differential_slip: bool = Field(default=True,
                                    description="Rolling radii vary across the contact as the surfaces curve (Heathcote slip)")


class CreepageTable(Table):
    """Relative motion of the bodies over the rolling speed; a creepage left out is 0 (or follows from a force)."""

    longitudinal: float | None = quantity("Longitudinal creepage", None, ge=-1e6, le=1e6)
    lateral: float | None = quantity("Lateral creepage", None, ge=-1e6, le=1e6)
    spin_rad_mm: float = quantity("Spin", 0.0, ge=-1e9, le=1e9)
    at: Literal["origin", "contact"] = Field(
        default="origin", description="Where they are those of the bodies: at y = 0, or at the centre of pressure"
    )


class ForceTable(Table):
    """Tangential forces; each replaces the creepage of its direction, which is then solved for."""

    longitudinal_N: float | None = quantity("Longitudinal force", None, ge=-1e15, le=1e15)
    lateral_N: float | None = quantity("Lateral force", None, ge=-1e15, le=1e15)
    longitudinal_N_mm: float | None = quantity("Longitudinal force per length of a line contact", None, ge=-1e15, le=1e15)
    lateral_N_mm: float | None = quantity("Lateral force per length of a line contact", None, ge=-1e15, le=1e15)


class RecirculationTable(Table):
    """A body that turns and whose heat recirculates, cooled on rim and ends or through a thermal resistance."""

    recirculate: bool = Field(default=False, description="The heated track of this body meets the contact again each turn")
    convection_W_m2K: float | None = quantity("Convection on rim and ends", None, ge=1e-9, le=1e12)
    thermal_resistance_K_W: float | None = quantity(
        "Mean temperature of the body's surface per heat of all its contacts", None, ge=1e-12, le=1e12)
    width_mm: float | None = quantity("Width of the body; twice its radius along rolling if left out", None, ge=1e-9, le=1e9)
    passes_per_revolution: int = quantity("Contacts that each turn meets, alike", 1, ge=1, le=1000)


class ThermalTable(Table):
    """Frictional heat. Leave the table and the thermal constants out for a mechanical case."""

    heat: bool = Field(default=True, description="Frictional heat and temperature; false is a purely mechanical case")
    deformation: Annotated[bool | Literal["always"], WithJsonSchema({"enum": [True, False, "always"]})] = Field(
        default=True,
        description='Thermal expansion acts back on the gap; "always": even where its effect is below the accuracy',
    )
    peclet: Literal["rolling", "sliding", "stationary"] = Field(
        default="rolling", description="Velocity of the heat sources: of the material, of the local slip, or none"
    )
    partition: Annotated[
        Annotated[float, Field(ge=0, le=1)] | Literal["matched"],
        WithJsonSchema({"type": ["number", "string"], "minimum": 0, "maximum": 1,
                        "if": {"type": "string"}, "then": {"enum": ["matched"]}}),
    ] = Field(
        default=0.5,
        description='Share of the heat that enters the lower body; "matched": surfaces equally warm inside the contact',
    )
    bulk_temperature_lower_K: float = quantity(f"Lower body {_BULK}", 0.0, ge=-1e4, le=1e4)
    bulk_temperature_upper_K: float = quantity(f"Upper body {_BULK}", 0.0, ge=-1e4, le=1e4)
    lower: RecirculationTable | None = Field(default=None, description="How the lower body turns and cools")
    upper: RecirculationTable | None = Field(default=None, description="How the upper body turns and cools")


class NumericsTable(Table):
    """Discretisation: a grid or an accuracy."""

    grid: Annotated[
        int | tuple[int, int], BeforeValidator(_grid),
        WithJsonSchema({**_SIDE, "type": ["integer", "array"], "items": _SIDE, "minItems": 2, "maxItems": 2}),
        Allowed(f"a whole number from {GRID_RANGE[0]} to {GRID_RANGE[1]}, or two of them: [nx, ny]"),
    ] | None = Field(default=None, description="Elements per side of the domain, or [nx, ny]")  # fmt: skip
    accuracy: float | None = quantity("Relative error wanted in the scalars", None, ge=1e-5, le=0.1)
    accuracy_of: Annotated[list[str] | None, Allowed(f"a list of scalars, or of {', '.join(GROUPS)}")] = Field(
        default=None, max_length=100, description="Scalars, or groups of them, that have to be as accurate; forces, "
        "heat, temperatures and the largest pressure if left out")
    extent: float = quantity("Side of the domain in Hertz semi-axes; grows if needed", 2.2, ge=1.2, le=6)


class SubsurfaceTable(Table):
    """Stresses and temperatures inside the bodies. Without the table nothing is computed."""

    bodies: Annotated[
        list[Literal["lower", "upper"]], Allowed('["lower"], ["upper"] or ["lower", "upper"]')
    ] = Field(default=["lower", "upper"], description="Bodies to look into", min_length=1, max_length=2)  # fmt: skip
    depth_mm: float | None = quantity("Largest depth; default 2.2 of the smaller semi-axis", None, ge=1e-9, le=1e9)
    layers: int | None = Field(
        default=None, ge=6, le=400,
        description="Number of depths, the surface included; by default each is 1.157 times as deep as the one before",
    )  # fmt: skip
    thermal: bool | None = Field(default=None, description="Thermal stresses; default: where there is heat")
    fields: Literal["plane", "von_mises", "full"] = Field(
        default="plane",
        description="Fields that are kept: on one plane, von Mises stresses and temperatures everywhere, or all stresses",
    )


class BodyStrengthTable(Table):
    """Strength of one body: its shakedown and fatigue are computed below the surface."""

    shear_yield_MPa: float | None = quantity("Shear yield stress k; without it the yield stress needed is reported",
                                             None, ge=1e-12, le=1e9)  # fmt: skip
    dang_van_coefficient: float = quantity("Weight of the hydrostatic stress in Dang Van's criterion", 0.3, ge=0, le=1)


class StrengthTable(Table):
    """Strength of the bodies, with [subsurface]."""

    lower: BodyStrengthTable | None = None
    upper: BodyStrengthTable | None = None


class WornBodyTable(Table):
    """How one body wears."""

    specific_wear_rate_mm3_Nm: Annotated[
        Annotated[float, Field(ge=1e-18, le=1e6)] | Annotated[list[Pair], Field(min_length=1, max_length=LARGEST_PROFILE)],
        Allowed("1e-18 to 1e+06, or pairs [T_gamma/A, rate] of numbers, T_gamma/A in N/mm2 increasing from above 0"),
    ] = quantity("Worn volume per load and sliding distance; a table of regimes gives it at some T_gamma/A")
    track_length_m: float | None = quantity(
        "Distance rolled between two passages of a point; default the circumference of the body", None, ge=1e-9, le=1e9)


class WearTable(Table):
    """Wear by Archard's law. `run` reports it per passage; `thermoroll wear` follows the profiles over the distance."""

    lower: WornBodyTable | None = None
    upper: WornBodyTable | None = None
    distance_km: float | None = quantity("Distance to be rolled", None, ge=1e-12, le=1e12)
    depth_um: float | None = quantity("Depth at which the evolution ends", None, ge=1e-9, le=1e9)
    positions: Annotated[
        list[Annotated[list[Annotated[float, Field(gt=0, le=1e9)] | dict[str, float | int | bool | str]],
                       Field(min_length=2, max_length=2)]] | None,
        Allowed("pairs [weight, {KEY = value, …}] of a weight above 0 and keys of the case"),
    ] = Field(default=None, description="Positions of a wheelset's service: shares of the distance, and keys that differ",
              min_length=1, max_length=1000)  # fmt: skip
    positions_file: Annotated[str | None, Allowed("the name of a CSV file with the columns weight and KEY")] = Field(
        default=None, description="CSV file of positions: columns weight and keys", max_length=1000)
    step_um: float = quantity("Largest worn depth of a step, of wheelsets", 20.0, ge=1e-6, le=1e6)
    smoothing_mm: float = quantity("Wavelength across of which smoothing leaves half of a step's wear, of wheelsets; "
                                   "0: none", 5.0, ge=0, le=1e3)  # fmt: skip
    density_kg_m3: float = quantity("Density, for worn masses, of bodies whose material has none", 7850.0, ge=1, le=1e5)
    step_fraction: float = quantity("Largest worn depth of a step over the approach", 0.1, ge=1e-4, le=1)
    snapshots: int = quantity("Profiles that are kept, evenly over the distance or the depth", 20, ge=1, le=1000)


class OutputTable(Table):
    """Output besides the result file."""

    plots: Annotated[
        bool | Literal["all", "summary", "none"], WithJsonSchema({"enum": [True, False, "all", "summary", "none"]}),
    ] = Field(
        default=True, description="Pictures: all, the sheet of a run alone (of a wheelset its section), or none")


class Head(Table):
    """Keys above all tables."""

    title: Annotated[str, BeforeValidator(_one_line), Allowed("up to 200 characters on one line")] = Field(
        default="", description="Title of the case, for pictures and tables", max_length=200
    )


class Settings(Head):
    """A whole case, in the units of its keys."""

    material: MaterialTable | TwoMaterials = Field(description="One material for both bodies, or one for each")
    geometry: GeometryTable | None = None
    track: TrackTable | None = None
    wheelset: WheelsetTable | None = None
    bearing: BearingTable | None = None
    load: LoadTable
    rolling: RollingTable = Field(default_factory=RollingTable.model_construct)
    friction: FrictionTable = Field(default_factory=FrictionTable.model_construct)
    layer: InterlayerTable | None = None
    creepage: CreepageTable = Field(default_factory=CreepageTable.model_construct)
    force: ForceTable = Field(default_factory=ForceTable.model_construct)
    thermal: ThermalTable = Field(default_factory=ThermalTable.model_construct)
    numerics: NumericsTable = Field(default_factory=NumericsTable.model_construct)
    subsurface: SubsurfaceTable | None = None
    strength: StrengthTable | None = None
    wear: WearTable | None = None
    history: HistoryTable | None = None
    surface: SurfacesTable | None = None
    output: OutputTable = Field(default_factory=OutputTable.model_construct)

    @property
    def kind(self) -> Kind:
        """The kind of problem that the case describes."""
        return kind_in(name for name, table in self if table is not None)

    @property
    def coefficient_at_rest(self) -> float:
        """The coefficient of friction without slip, the largest of all places."""
        return coefficient_at_rest(self.load, self.friction)

    @property
    def materials(self) -> dict[str, MaterialTable]:
        """The material of each body."""
        if isinstance(self.material, TwoMaterials):
            return {"lower": self.material.lower, "upper": self.material.upper}
        return {"lower": self.material, "upper": self.material}


EXCLUSIVE = (
    ("numerics.grid", "numerics.accuracy", "a grid, or an accuracy for which a grid is picked"),
    ("numerics.grid", "numerics.accuracy_of", "a grid, or scalars whose accuracy picks one"),
    *((f"creepage.{way}", f"force.{way}_{unit}", "a force, or a creepage, in each direction")
      for way in ("longitudinal", "lateral") for unit in ("N", "N_mm")),
    *((f"{table}.points_mm", f"{table}.file", "points, or a file of them")
      for table in ("track.rail_profile", "wheelset.wheel_profile")),
    *((f"geometry.{body}_radius_y_mm", f"geometry.{body}_profile", "a lateral radius or a profile") for body in BODIES),
    *((f"geometry.{body}_profile.{first}", f"geometry.{body}_profile.{second}", "one of points_mm, file and kind")
      for body in BODIES for first, second in (("points_mm", "file"), ("points_mm", "kind"), ("file", "kind"))),
    *((f"thermal.{body}.convection_W_m2K", f"thermal.{body}.thermal_resistance_K_W",
       "convection, or a thermal resistance, of each body") for body in BODIES),
    ("wear.distance_km", "wear.depth_um", "a distance, or a depth"),
    ("history.distance_mm", "history.time_s", "distances, or times"),
    *((f"history.{key}", "history.file", "values and their places, or a file of them")
      for key in ("distance_mm", "time_s", "values")),
    ("wear.positions", "wear.positions_file", "positions, or a file of them"),
    ("load.normal_N", "load.approach_um", "a normal load, or an approach"),
    ("load.normal_N", "load.vertical_N", "a normal load, or a vertical force"),
    ("load.approach_um", "load.vertical_N", "an approach, or a vertical force"),
    ("load.normal_N", "load.normal_N_mm", "a normal load, or one per length"),
    *((f"load.{other}", "load.hertz_pressure_MPa", "a pressure, or a load")
      for other in ("normal_N", "normal_N_mm", "approach_um", "vertical_N")),
    ("load.normal_N_mm", "load.approach_um", "a load per length: a line contact has no approach"),
    ("load.normal_N_mm", "load.vertical_N", "a load per length, or a vertical force"),
    *(("load.friction_coefficient", f"friction.{key}", "one coefficient of friction, or one of each place")
      for key in ("over_angle", "across")),
    ("bearing.load.axial_N", "bearing.load.axial_displacement_um", "an axial load, or an axial displacement"),
    ("wheelset.vertical_N", "wheelset.height_mm", "a vertical load, or a height"),
    ("wheelset.angular_velocity_rad_s", "wheelset.traction_N", "an angular velocity, or a traction from which it is found"),
)  # fmt: skip
"""Two keys, or a key and a table, of which a case has one at most, and what is allowed. With --set the one that is set
replaces the other."""
