"""A ball bearing as tables of a case, conflicts between their keys, and the problem that they describe."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Annotated, Any, Literal

from pydantic import Field

from thermoroll_cli.files.case_errors import Fault
from thermoroll_cli.files.case_table import Allowed, Pair, Table, quantity
from thermoroll_cli.many_contacts.bearing.bearing_problem import BearingProblem
from thermoroll_cli.problem.problem import Problem

RADIANS_PER_RPM = 2.0 * math.pi / 60.0
SAME_ANGLE = 1e-3
"""Difference in degrees of a contact angle from that of a clearance which is rounding."""


class BearingLoadTable(Table):
    """Load on the inner ring, or its axial displacement."""

    axial_N: float | None = quantity("Axial load on the inner ring; 0 if left out", None, ge=-1e9, le=1e9)
    axial_displacement_um: float | None = quantity(
        "Axial displacement of the inner ring from the middle, a rigid preload; instead of axial_N", None, ge=-1e7, le=1e7)
    radial_N: float = quantity("Radial load on the inner ring, towards ball 1", 0.0, ge=0, le=1e9)
    moment_Nm: Annotated[
        Annotated[float, Field(ge=-1e9, le=1e9)] | Pair | None,
        Allowed("a number, or two: about the axis across the radial load, and about the radial load"),
    ] = Field(default=None, description="Moment on the inner ring, which tilts, also with 0; left out: held straight. Positive "
              "presses ball 1 axially; a second number is about the radial load")  # fmt: skip
    inner_over_outer_K: float = quantity("Temperature of the inner ring above the outer one, which widens it", 0.0,
                                         ge=-1e4, le=1e4)


class BearingTable(Table):
    """A ball bearing: its balls are the upper bodies of its contacts, the rings the lower ones."""

    ball_diameter_mm: float = quantity("Diameter of a ball", ge=1e-3, le=1e4)
    pitch_diameter_mm: float = quantity("Diameter of the circle of the balls' centres", ge=1e-3, le=1e5)
    balls: int = Field(description="Number of balls", ge=1, le=400)
    contact_angle_deg: float = quantity("Contact angle without load; 0 with clearance_um: a deep groove", 0.0, ge=0, le=80)
    clearance_um: float | None = quantity("Diametral clearance, which gives the contact angle: cos = 1 - clearance/2A", None,
                                          ge=0, le=1e7)  # fmt: skip
    conformity_inner: float = quantity("Radius of the inner groove over the diameter of a ball", ge=0.5001, le=10)
    conformity_outer: float = quantity("Radius of the outer groove over the diameter of a ball", ge=0.5001, le=10)
    inner_rpm: float = quantity("Speed of the inner ring", 0.0, ge=-1e7, le=1e7)
    outer_rpm: float = quantity("Speed of the outer ring", 0.0, ge=-1e7, le=1e7)
    control: Literal["tractions", "outer", "inner"] = Field(
        default="tractions", description="What determines the balls' axes: the balance of tractions, or no spin at a ring")
    cage: Literal["free", "common"] = Field(
        default="free", description="Each ball goes round at its own speed, or all at that of the cage")
    patches: Literal["curved", "plane"] = Field(
        default="curved", description="Contacts follow the curved grooves, or lie in planes")
    capacity_N: float | None = quantity("Basic dynamic load rating, for the life", None, ge=1e-6, le=1e12)
    load: BearingLoadTable = Field(description="Load on the inner ring, or its axial displacement")


def bearing_faults(sections: Mapping[str, Any], bearing: BearingTable) -> Iterator[Fault]:
    """Conflicts between the keys of a bearing."""
    ball, pitch, count, load = bearing.ball_diameter_mm, bearing.pitch_diameter_mm, bearing.balls, bearing.load
    if pitch <= ball:
        yield (("bearing", "pitch_diameter_mm"), f"{pitch:g} mm is not larger than a ball of {ball:g} mm",
               f"more than {ball:g}")  # fmt: skip
    elif count > 1 and ball > pitch * math.sin(math.pi / count):
        most = int(math.pi / math.asin(ball / pitch))
        yield (("bearing", "balls"), f"{count} balls of {ball:g} mm do not fit on a pitch diameter of {pitch:g} mm",
               f"1 to {most} of these balls")  # fmt: skip
    distance = 1e3 * (bearing.conformity_inner + bearing.conformity_outer - 1.0) * ball
    if bearing.clearance_um is not None and bearing.clearance_um >= distance:
        yield (("bearing", "clearance_um"), f"{bearing.clearance_um:g} µm leave no contact: the centres of the grooves are "
               f"{distance:.4g} µm apart", f"0 to {2.0 * distance * (1.0 - math.cos(math.radians(80.0))):.4g}")  # fmt: skip
    elif bearing.clearance_um is not None and bearing.contact_angle_deg:
        angle = math.degrees(math.acos(1.0 - 0.5 * bearing.clearance_um / distance))
        if abs(angle - bearing.contact_angle_deg) > SAME_ANGLE:
            yield (("bearing", "contact_angle_deg"), f"a clearance of {bearing.clearance_um:g} µm means a contact angle of "
                   f"{angle:.5g} degrees, not {bearing.contact_angle_deg:g}", "one of contact_angle_deg and clearance_um")
    moments = load.moment_Nm if isinstance(load.moment_Nm, list) else [load.moment_Nm or 0.0]
    if load.axial_displacement_um is None and not any((load.axial_N, load.radial_N, *moments)):
        yield ("bearing", "load"), "loads nothing", "axial_N, radial_N, moment_Nm or axial_displacement_um"
    if bearing.cage == "common" and bearing.control != "tractions":
        yield (("bearing", "cage"), '= "common" shares the forces of tractions out, which do not move balls with control = '
               f'"{bearing.control}"', '"free", or control = "tractions"')  # fmt: skip
    material = sections.get("material")
    rings = getattr(material, "lower", material)
    if load.inner_over_outer_K and rings is not None and rings.expansion_um_mK is None:
        yield (("bearing", "load", "inner_over_outer_K"), "widens the inner ring, but its thermal expansion is not given",
               "0, or thermal constants in [material]")  # fmt: skip
    at_rest, law = sections.get("load"), sections.get("friction")
    rises = law is not None and any(law.coefficients)
    if bearing.control == "tractions" and bearing.inner_rpm != bearing.outer_rpm and at_rest is not None and (
            at_rest.friction_coefficient == 0.0 and not rises):
        yield (("load", "friction_coefficient"), "without friction no traction determines the axes of the balls",
               'above 0, or control = "outer" or "inner" in [bearing]')


def bearing_of(table: BearingTable, contact: Problem) -> BearingProblem:
    """The bearing that a table describes; `contact` has everything else."""
    load, distance = table.load, (table.conformity_inner + table.conformity_outer - 1.0) * table.si("ball_diameter_mm")
    angle = math.radians(table.contact_angle_deg) if table.clearance_um is None else (
        math.acos(1.0 - 0.5 * table.si("clearance_um") / distance))
    moments = load.moment_Nm if isinstance(load.moment_Nm, list) else [load.moment_Nm or 0.0, 0.0]
    return BearingProblem(
        contact=contact,
        ball_diameter=table.si("ball_diameter_mm"),
        pitch_diameter=table.si("pitch_diameter_mm"),
        balls=table.balls,
        contact_angle=angle,
        conformity=(table.conformity_inner, table.conformity_outer),
        speeds=(RADIANS_PER_RPM * table.inner_rpm, RADIANS_PER_RPM * table.outer_rpm),
        axial=load.axial_N or 0.0,
        axial_displacement=load.si("axial_displacement_um"),
        radial=load.radial_N,
        moments=None if load.moment_Nm is None else (moments[0], moments[1]),
        widening=(contact.lower.expansion or 0.0) * load.inner_over_outer_K,
        control=table.control,
        common_cage=table.cage == "common",
        curved=table.patches == "curved",
        capacity=table.capacity_N,
    )
