"""The case file as data: every table, key, unit and allowed range, in the units of the keys."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import AllowInfNan, BaseModel, BeforeValidator, ConfigDict, Field
from pydantic_core import PydanticCustomError

THERMAL_CONSTANTS = ("conductivity_W_mK", "expansion_um_mK", "diffusivity_mm2_s")
GRID_RANGE = (8, 2048)
LARGEST_PROFILE = 2000
"""Points of a profile."""
LAYERS_RANGE = (2, 400)

RADIUS_RANGE = (1e-9, 1e9)
_BULK = "far from the contact, above the temperature to which the coefficient of friction belongs"


def _radius(value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise PydanticCustomError("radius", "must be a number")
    if value == float("inf"):
        return float("inf")
    if value == 0:
        raise PydanticCustomError("radius", "must not be zero: a flat body has the radius inf")
    if not RADIUS_RANGE[0] <= abs(value) <= RADIUS_RANGE[1]:  # nan and -inf, too
        raise PydanticCustomError("radius", "is outside the allowed range")
    return float(value)


def _grid(value: Any) -> int | tuple[int, int]:
    sides = value if isinstance(value, list | tuple) else (value, value)
    if len(sides) != 2 or not all(isinstance(side, int) and not isinstance(side, bool) for side in sides):
        raise PydanticCustomError("grid", "must be a whole number or a list of two")
    if not all(GRID_RANGE[0] <= side <= GRID_RANGE[1] for side in sides):
        raise PydanticCustomError("grid", "is outside the allowed range")
    return value if isinstance(value, int) else (sides[0], sides[1])


def _partition(value: Any) -> float | str:
    if value == "matched":
        return "matched"
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise PydanticCustomError("partition", "must be a number or a known word")
    if not 0.0 <= value <= 1.0:
        raise PydanticCustomError("partition", "is outside the allowed range")
    return float(value)


def _deformation(value: Any) -> bool | str:
    if not isinstance(value, bool) and value != "always":
        raise PydanticCustomError("deformation", "must be true, false or a known word")
    return "always" if value == "always" else bool(value)


def _one_line(value: Any) -> Any:
    if isinstance(value, str) and not value.isprintable():
        raise PydanticCustomError("title", "must be one line without control characters")
    return value


def _quantity(unit: str, description: str, default: Any = ..., *, ge: float | None = None, le: float | None = None) -> Any:
    """A number with its unit, allowed from `ge` to `le`."""
    # Even where any positive number makes sense there are ends, far outside any use: 1e-300 survives no arithmetic.
    return Field(default=default, description=description, json_schema_extra={"unit": unit}, ge=ge, le=le)


Radius = Annotated[float, AllowInfNan(True), BeforeValidator(_radius)]


class Table(BaseModel):
    """A table of the case file: unknown keys, wrong types, nan and inf are errors."""

    # A table's validator is built when a case first has that table.
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True, allow_inf_nan=False, defer_build=True)


class MaterialTable(Table):
    """Constants of one material."""

    youngs_modulus_GPa: float = _quantity("GPa", "Young's modulus", ge=1e-9, le=1e6)
    poisson_ratio: float = _quantity("1", "Poisson's ratio", ge=0, le=0.5)
    conductivity_W_mK: float | None = _quantity("W/(m K)", "Thermal conductivity", None, ge=1e-6, le=1e6)
    expansion_um_mK: float | None = _quantity("1e-6/K", "Linear thermal expansion", None, ge=1e-6, le=1e6)
    diffusivity_mm2_s: float | None = _quantity("mm2/s", "Thermal diffusivity", None, ge=1e-9, le=1e12)


class TwoMaterials(Table):
    """A material for each body."""

    lower: MaterialTable = Field(description="Material of the lower body")
    upper: MaterialTable = Field(description="Material of the upper body")


class ProfileTable(Table):
    """Shape of a body across rolling, instead of a lateral radius: points, a file of them, or a crown."""

    points_mm: list[Annotated[list[float], Field(min_length=2, max_length=2)]] | None = Field(
        default=None, description="[y, height] in mm, y increasing, height positive out of the body",
        min_length=2, max_length=LARGEST_PROFILE, json_schema_extra={"unit": "mm"},
    )
    file: str | None = Field(default=None, description="Two columns y and height in mm, beside the case file", max_length=1000)
    kind: Literal["logarithmic"] | None = Field(default=None, description="A crown: height = drop ln(1 - (2|y|/length)^2)")
    length_mm: float | None = _quantity("mm", "Length of the crown, end to end", None, ge=1e-9, le=1e9)
    drop_um: float | None = _quantity("um", "Drop of the crown", None, ge=1e-9, le=1e9)
    flat_mm: float | None = _quantity("mm", "Length of the crown's middle part without drop", None, ge=0, le=1e9)
    interpolation: Literal["cubic", "linear"] = Field(
        default="cubic", description="Between points: a spline of continuous curvature, or straight lines"
    )
    offset_mm: float = _quantity("mm", "Shift of the profile towards +y", 0.0, ge=-1e9, le=1e9)
    tilt_mrad: float = _quantity("mrad", "Rise of the profile towards +y", 0.0, ge=-500, le=500)


class GeometryTable(Table):
    """Principal radii of both bodies. inf is flat, negative is concave. Across rolling a body may have a profile instead."""

    lower_radius_x_mm: Radius = _quantity("mm", "Radius of the lower body along rolling")
    lower_radius_y_mm: Radius | None = _quantity("mm", "Radius of the lower body across rolling, unless it has a profile", None)
    upper_radius_x_mm: Radius = _quantity("mm", "Radius of the upper body along rolling")
    upper_radius_y_mm: Radius | None = _quantity("mm", "Radius of the upper body across rolling, unless it has a profile", None)
    lower_profile: ProfileTable | None = Field(default=None, description="Profile of the lower body across rolling")
    upper_profile: ProfileTable | None = Field(default=None, description="Profile of the upper body across rolling")


class LoadTable(Table):
    """Normal load and friction."""

    normal_N: float = _quantity("N", "Normal load", ge=1e-15, le=1e15)
    friction_coefficient: float = _quantity("1", "Coulomb's coefficient of friction", ge=0, le=2)
    friction_temperature_slope_1_K: float = _quantity(
        "1/K", "Share of the coefficient of friction lost per kelvin of contact temperature (negative: gained)", 0.0,
        ge=-10, le=10
    )
    friction_temperature_start_K: float = _quantity(
        "K", "Contact temperature from which the coefficient of friction changes", 0.0, ge=-1e4, le=1e4
    )
    friction_minimum_factor: float = _quantity(
        "1", "Share of the coefficient of friction that remains however hot the contact gets", 0.1, ge=0, le=1
    )
    friction_maximum_factor: float = _quantity(
        "1", "Multiple of the coefficient of friction that it never exceeds, however hot the contact gets", 2.0, ge=1, le=100
    )


class RollingTable(Table):
    """Rolling motion."""

    speed_m_s: float = _quantity("m/s", "Rolling speed, mean of both bodies", ge=1e-12, le=1e9)
    differential_slip: bool = Field(
        default=True, description="Rolling radii vary across the contact as the surfaces curve (Heathcote slip)"
    )


class CreepageTable(Table):
    """Relative motion of the bodies over the rolling speed; what is left out is 0 (or follows from a force)."""

    longitudinal: float | None = _quantity("1", "Longitudinal creepage", None, ge=-1e6, le=1e6)
    lateral: float | None = _quantity("1", "Lateral creepage", None, ge=-1e6, le=1e6)
    spin_rad_mm: float = _quantity("rad/mm", "Spin", 0.0, ge=-1e9, le=1e9)


class ForceTable(Table):
    """Tangential forces; each replaces the creepage of its direction, which is then solved for."""

    longitudinal_N: float | None = _quantity("N", "Longitudinal force", None, ge=-1e15, le=1e15)
    lateral_N: float | None = _quantity("N", "Lateral force", None, ge=-1e15, le=1e15)


class RecirculationTable(Table):
    """A body that turns and brings its track back to the contact, cooled on rim and ends or through a thermal resistance."""

    recirculate: bool = Field(default=False, description="The heated track of this body meets the contact again each turn")
    convection_W_m2K: float | None = _quantity("W/(m2 K)", "Convection on rim and ends", None, ge=1e-9, le=1e12)
    thermal_resistance_K_W: float | None = _quantity(
        "K/W", "Mean temperature of the body's surface per heat of all its contacts", None, ge=1e-12, le=1e12
    )
    width_mm: float | None = _quantity("mm", "Width of the body; twice its radius along rolling if left out", None,
                                       ge=1e-9, le=1e9)
    passes_per_revolution: int = _quantity("1", "Contacts that each turn meets, alike", 1, ge=1, le=1000)


class ThermalTable(Table):
    """Frictional heat. Leave the table and the thermal constants out for a mechanical case."""

    heat: bool = Field(default=True, description="Frictional heat and temperature; false is a purely mechanical case")
    deformation: Annotated[bool | Literal["always"], BeforeValidator(_deformation)] = Field(
        default=True,
        description='Thermal expansion acts back on the gap; "always": even where its effect is below the accuracy',
    )
    peclet: Literal["rolling", "sliding", "stationary"] = Field(
        default="rolling", description="Velocity of the heat sources: of the material, of the local slip, or none"
    )
    partition: Annotated[float | Literal["matched"], BeforeValidator(_partition)] = Field(
        default=0.5,
        description='Share of the heat that enters the lower body; "matched": surfaces equally warm inside the contact',
    )
    bulk_temperature_lower_K: float = _quantity("K", f"Lower body {_BULK}", 0.0, ge=-1e4, le=1e4)
    bulk_temperature_upper_K: float = _quantity("K", f"Upper body {_BULK}", 0.0, ge=-1e4, le=1e4)
    lower: RecirculationTable | None = Field(default=None, description="How the lower body turns and cools")
    upper: RecirculationTable | None = Field(default=None, description="How the upper body turns and cools")


class NumericsTable(Table):
    """Discretisation: a grid or an accuracy."""

    grid: Annotated[int | tuple[int, int], BeforeValidator(_grid)] | None = Field(
        default=None, description="Elements per side of the domain, or [nx, ny]"
    )
    accuracy: float | None = _quantity("1", "Relative error wanted in the scalars", None, ge=1e-5, le=0.1)
    extent: float = _quantity("1", "Side of the domain in Hertz semi-axes; grows if needed", 2.2, ge=1.2, le=6)


class SubsurfaceTable(Table):
    """Stresses and temperatures inside the bodies. Without the table nothing is computed."""

    bodies: list[Literal["lower", "upper"]] = Field(
        default=["lower", "upper"], description="Bodies to look into", min_length=1, max_length=2
    )
    depth_mm: float | None = _quantity(
        "mm", "Depth of the last layer; default 2.2 of the smaller semi-axis", None, ge=1e-9, le=1e9
    )
    layers: int | None = Field(
        default=None, ge=LAYERS_RANGE[0], le=LAYERS_RANGE[1],
        description="Layers from the surface down; default as many as a ratio of 1.157 from one to the next takes",
    )
    thermal: bool | None = Field(default=None, description="Thermal stresses; default: where there is heat")
    fields: Literal["plane", "von_mises", "full"] = Field(
        default="plane",
        description="Fields that are kept: on one plane, von Mises stresses and temperatures everywhere, or all stresses",
    )


class OutputTable(Table):
    """What is written besides the result file."""

    plots: bool = Field(default=True, description="Draw pictures")


class Head(Table):
    """What stands above all tables."""

    title: Annotated[str, BeforeValidator(_one_line)] = Field(
        default="", description="What the case is, for pictures and tables", max_length=200
    )


class Settings(Head):
    """A whole case, in the units of its keys."""

    material: MaterialTable | TwoMaterials = Field(description="One material for both bodies, or one for each")
    geometry: GeometryTable
    load: LoadTable
    rolling: RollingTable
    creepage: CreepageTable = CreepageTable.model_construct()
    force: ForceTable = ForceTable.model_construct()
    thermal: ThermalTable = ThermalTable.model_construct()
    numerics: NumericsTable = NumericsTable.model_construct()
    subsurface: SubsurfaceTable | None = None
    output: OutputTable = OutputTable.model_construct()

    @property
    def materials(self) -> dict[str, MaterialTable]:
        """The material of each body."""
        if isinstance(self.material, TwoMaterials):
            return {"lower": self.material.lower, "upper": self.material.upper}
        return {"lower": self.material, "upper": self.material}


SECTIONS: dict[str, type[Table]] = {
    "geometry": GeometryTable,
    "load": LoadTable,
    "rolling": RollingTable,
    "creepage": CreepageTable,
    "force": ForceTable,
    "thermal": ThermalTable,
    "numerics": NumericsTable,
    "subsurface": SubsurfaceTable,
    "output": OutputTable,
}
"""Tables of a case other than the material, whose shape depends on its content."""

PROFILES = ("lower_profile", "upper_profile")
"""Tables inside [geometry]."""

REQUIRED_SECTIONS = ("geometry", "load", "rolling")
