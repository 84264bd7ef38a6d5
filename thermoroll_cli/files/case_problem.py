"""From the tables of a case to the problem in SI units. A key that is called like its attribute, but for the unit at its end,
needs no line here; for a key left out the attribute has its default."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from thermoroll_cli.files import case_model as model
from thermoroll_cli.many_contacts.wheelset.curves import Points, smooth
from thermoroll_cli.many_contacts.wheelset.wheelset_problem import SideName
from thermoroll_cli.one_contact.steady_state.derived import pressed_to, pressed_with, rubbed
from thermoroll_cli.problem import problem as si
from thermoroll_cli.problem.curved_patch import CurvedPatch, conformal_patch
from thermoroll_cli.problem.friction import FORMULAS, Friction, FrictionLaw, Interlayer
from thermoroll_cli.problem.geometry import Geometry, Profile
from thermoroll_cli.problem.relaxation import Series
from thermoroll_cli.problem.rounding import steps_of


def problem_of(settings: model.Settings) -> si.Problem:
    """The problem that a case describes; of an assembly that of any contact, without its geometry, load and creepages."""
    load, friction, layer = settings.load, settings.friction, settings.layer
    geometry = settings.geometry or settings.kind.geometry(settings)
    creepage, force, thermal, numerics = settings.creepage, settings.force, settings.thermal, settings.numerics
    lower, upper = (material_of(material) for material in settings.materials.values())
    problem = si.Problem(
        lower=lower,
        upper=upper,
        geometry=_geometry(geometry, lower, upper),
        normal_force=load.normal_N or load.si("normal_N_mm") or load.vertical_N or 1.0,
        friction=_friction(friction, settings.coefficient_at_rest),
        motion=si.Motion(
            **{"speed": 1.0, **settings.rolling.in_si()},
            creepage_x=creepage.longitudinal,
            creepage_y=creepage.lateral,
            spin=creepage.si("spin_rad_mm"),
            at=creepage.at,
            force_x=force.longitudinal_N if force.longitudinal_N_mm is None else force.si("longitudinal_N_mm"),
            force_y=force.lateral_N if force.lateral_N_mm is None else force.si("lateral_N_mm"),
        ),
        heating=si.Heating(
            heat=thermal.heat,
            deformation=thermal.deformation,
            peclet=thermal.peclet,
            partition=thermal.partition,
            bulk_lower=thermal.bulk_temperature_lower_K,
            bulk_upper=thermal.bulk_temperature_upper_K,
            lower_track=_recirculation(thermal.lower, geometry.si("lower_radius_x_mm")),
            upper_track=_recirculation(thermal.upper, geometry.si("upper_radius_x_mm")),
        ),
        numerics=si.Numerics(
            grid=(numerics.grid, numerics.grid) if isinstance(numerics.grid, int) else numerics.grid,
            accuracy=numerics.accuracy,
            extent=numerics.extent,
            accuracy_of=tuple(numerics.accuracy_of or ()),
        ),
        title=settings.title,
        wear=_wear(settings.wear, geometry),
        interlayer=Interlayer() if layer is None else Interlayer(
            layer.si("compliance_um_GPa") or 0.0, layer.si("yield_MPa"), layer.si("hardening_MPa_um")),
        subsurface=_subsurface(settings.subsurface, settings.strength),
    )
    if isinstance(problem.geometry, CurvedPatch):
        problem = replace(problem, vertical=load.vertical_N)
    if load.hertz_pressure_MPa is not None:
        problem = pressed_with(problem, load.si("hertz_pressure_MPa"))
    if load.approach_um is not None:
        problem = pressed_to(problem, load.si("approach_um"))
    if friction.across is None:
        return problem
    return rubbed(problem, [(y / 1e3, _share(mu, settings)) for y, mu in friction.across])


def _share(coefficient: float, settings: model.Settings) -> float:
    """A coefficient of friction over the largest."""
    return coefficient / (settings.coefficient_at_rest or 1.0)


def rail_friction(settings: model.Settings) -> dict[SideName, Points]:
    """The share of friction over the inclination (rad) of each rail; nothing where it is the same everywhere."""
    friction, found = settings.friction, {}
    sides: tuple[tuple[SideName, model.RailFrictionTable | None], ...] = (("left", friction.left), ("right", friction.right))
    if not any((friction.over_angle, friction.left, friction.right)):
        return {}
    for side, own in sides:
        points = (own and own.over_angle) or friction.over_angle or [[0.0, settings.load.friction_coefficient or 0.0]]
        found[side] = tuple((math.radians(angle), _share(mu, settings)) for angle, mu in points)
    return found


def material_of(table: model.MaterialTable) -> si.Material:
    """The material; layers of one material that lie next to each other are one layer."""
    layers: list[si.Layer] = []
    for given in table.layers or ():
        layer = si.Layer(**given.in_si(), relaxation=_relaxation(given))
        if layers and replace(layer, thickness=layers[-1].thickness) == layers[-1]:
            layer = replace(layer, thickness=layer.thickness + layers.pop().thickness)
        layers.append(layer)
    return si.Material(**table.in_si(), layers=tuple(layers), relaxation=_relaxation(table))


def _relaxation(table: model.MaterialConstants) -> Series:
    return tuple((share, time) for share, time in table.relaxation or ())


def _geometry(table: model.GeometryTable, lower: si.Material, upper: si.Material) -> Geometry | CurvedPatch:
    radii = {"lower_radius_y": math.inf, "upper_radius_y": math.inf, **table.in_si()}
    radii.pop("conformal", None)
    for body in si.BODIES:
        if (profile := getattr(table, f"{body}_profile")) is not None:
            radii[f"{body}_profile"] = profile_of(profile)
    geometry = Geometry(**radii)
    if not table.conformal:
        return geometry
    patch = conformal_patch(geometry, si.compliance_shares(lower, upper))
    return patch if any(patch.angle) else geometry


def profile_of(table: model.ProfileTable) -> Profile:
    """The profile, with points mirrored, turned over and smoothed as the table says."""
    points = [(y / 1e3, z / 1e3) for y, z in table.points_mm or ()]
    if table.mirror:
        points = [(-y, z) for y, z in reversed(points)]
    if table.flip:
        points = [(y, -z) for y, z in points]
    measured = tuple(points) if table.smoothing_mm else ()
    if measured:
        y, z = np.array(points).T
        points = list(zip(y.tolist(), smooth(y, z, table.si("smoothing_mm")).tolist(), strict=True))
    others = {name: value for name, value in table.in_si().items()
              if name not in ("file", "kind", "unit", "height_unit", "mirror", "flip", "smoothing")}
    across, up = steps_of(table.points_mm or [])
    return Profile(tuple(points), measured=measured, steps=(across / 1e3, up / 1e3), smoothing=table.si("smoothing_mm"),
                   **others)


def _friction(table: model.FrictionTable, at_rest: float) -> Friction:
    largest = max([at_rest, *table.coefficients])
    return Friction(largest, _friction_law(table, at_rest, largest), table.temperature_slope_1_K, table.temperature_start_K,
                    table.temperature_minimum_factor, table.temperature_maximum_factor)


def _friction_law(table: model.FrictionTable, at_rest: float, largest: float) -> FrictionLaw | None:
    """The law of slip, relative to the largest coefficient; None for constant friction. Memory without a law becomes a law that
    does not fall, and there is a warning."""
    if largest == 0.0 or not (table.law or table.memory_um):
        return None
    law = FrictionLaw(table.law or "exponential", memory=table.si("memory_um"), memory_slip=table.si("memory_slip_mm_s"))
    if table.law == "table":
        return replace(law, table=tuple((speed, coefficient / largest) for speed, coefficient in table.table or ()))
    if table.law is None:
        return law
    constants = {constant.name: table.si(constant.key) / (largest if constant.of_friction else 1.0)
                 for constant in FORMULAS[table.law].constants}
    return replace(law, rest=at_rest / largest, **constants)


def _recirculation(table: model.RecirculationTable | None, radius: float) -> si.ReturningTrack | None:
    if table is None or not table.recirculate:
        return None
    width = 2.0 * abs(radius) if table.width_mm is None else table.si("width_mm")
    return si.ReturningTrack(width, table.passes_per_revolution, table.convection_W_m2K, table.thermal_resistance_K_W)


def _subsurface(table: model.SubsurfaceTable | None, strength: model.StrengthTable | None) -> si.SubsurfaceRequest | None:
    if table is None:
        return None
    limits = {body: si.Strength(**given.in_si()) for body, given in strength or () if given is not None}
    return si.SubsurfaceRequest(tuple(body for body in si.BODIES if body in table.bodies), **table.in_si(),
                                lower_strength=limits.get("lower"), upper_strength=limits.get("upper"))


def _wear(table: model.WearTable | None, geometry: model.GeometryTable) -> si.Wear | None:
    if table is None:
        return None
    worn = []
    for body in si.BODIES:
        own: model.WornBodyTable | None = getattr(table, body)
        if own is None:
            worn.append(si.WornBody())
            continue
        key = "specific_wear_rate_mm3_Nm"
        given, factor = own.specific_wear_rate_mm3_Nm, own.si_unit(key)[1]
        rate = tuple((work * 1e6, each * factor) for work, each in given) if isinstance(given, list) else own.si(key)
        worn.append(si.WornBody(rate, own.track_length_m or 2.0 * math.pi * abs(geometry.si(f"{body}_radius_x_mm"))))
    return si.Wear(worn[0], worn[1], **table.in_si())
