"""Stresses below the surface of a steady state, on the finest grids that were solved."""

from __future__ import annotations

import math
import time
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace

import numpy as np

from thermoroll_cli.one_contact.refinement.error_estimates import Resolution, stress_estimates
from thermoroll_cli.one_contact.refinement.level import Level
from thermoroll_cli.one_contact.refinement.outcome import refining_both, rounded, scalars_by_level
from thermoroll_cli.one_contact.refinement.plan import Plan
from thermoroll_cli.one_contact.refinement.subsurface_plan import depths_of, few_depths, hot_bodies
from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.one_contact.steady_state.discretisation import Discretisation
from thermoroll_cli.one_contact.steady_state.heated_bodies import heated_bodies
from thermoroll_cli.physics.halfspace.layered import LayeredBody
from thermoroll_cli.physics.stress.body_stresses import Collector
from thermoroll_cli.physics.stress.strength import StrengthCollector, strength_scalars
from thermoroll_cli.physics.stress.superposition import Beyond, ElasticStresses, StressTransforms, SurfaceLoad, ThermalStresses
from thermoroll_cli.problem.contact import Contact
from thermoroll_cli.problem.names import of_contacts
from thermoroll_cli.problem.problem import BODIES, Problem, SubsurfaceRequest
from thermoroll_cli.problem.result import Result, Subsurface
from thermoroll_cli.problem.scalar_errors import computed, error_scale, missed, not_reached
from thermoroll_cli.tools.arrays import Array

Collectors = dict[str, Collector]
"""By body."""

TRACTION_SIGNS = {"lower": -1.0, "upper": 1.0}
"""τ points along the slip of the lower body: it brakes the lower body and drives the upper one."""


def recirculating(derived: DerivedQuantities) -> tuple[str, ...]:
    """Bodies with recirculating heat; their surfaces are warmer than this pass makes them."""
    heating = derived.problem.heating
    tracks = {"lower": heating.lower_track, "upper": heating.upper_track}
    return tuple(body for body, track in tracks.items() if track is not None and heating.recirculates)


def surface_loads(
    discretisation: Discretisation, contact: Contact, bodies: tuple[str, ...], thermal: bool
) -> dict[str, SurfaceLoad]:
    """The loads of a steady state on each of the `bodies`, with heat if thermal stresses are wanted."""
    derived, tangential = discretisation.derived, contact.tangential
    heat = discretisation.heat(contact) if thermal else None
    rises: dict[str, Array] = {} if heat is None else dict(zip(BODIES, heat.temperatures(), strict=True))
    loads = {}
    for body in bodies:
        into = None if heat is None else getattr(heat.into, body)
        load = body_load(derived.problem, body, contact.normal.pressure, tangential.traction, into, tangential.creepage)
        known = load.heat is not None and body not in recirculating(derived)
        loads[body] = replace(load, surface_rise=rises[body]) if known else load
    return loads


def body_load(
    problem: Problem, body: str, pressure: Array, traction: Array, heat: Array | None, creepage: tuple[float, float]
) -> SurfaceLoad:
    """The load of pressure (Pa), traction (2, nx, ny) and heat into the `body` (W/m², None: none) at the creepages found."""
    material = getattr(problem, body)
    load = SurfaceLoad(pressure, traction if traction.any() else None, None, material.surface.poisson_ratio,
                       TRACTION_SIGNS[body], layered=LayeredBody.of(material) if material.layers else None)
    if heat is None or not heat.any():
        return load
    moving = heated_bodies(problem, *creepage)[BODIES.index(body)]
    modulus = material.youngs_modulus * material.expansion / (1.0 - material.poisson_ratio)
    return replace(load, heat=heat, thermal_modulus=modulus, conductivity=moving.conductivity, diffusivity=moving.diffusivity,
                   speed=(moving.speed_x, moving.speed_y))


def with_subsurface(result: Result, plan: Plan, levels: list[Level]) -> Result:
    """`result` with the stresses inside the bodies, if its problem asks for them and its fields are finite."""
    request = result.problem.subsurface
    if request is None or not all(np.isfinite(values).all() for values in result.coupled.fields.values()):
        return result
    start = time.perf_counter()
    summary, derived, levels = result.summary(), plan.derived, refining_both(levels)
    hot, finest_grid = hot_bodies(request, derived, heated=plan.runs("heat")), levels[-1].here.grid
    depths: dict[str, Array] = {body: depths_of(request, derived, body, heated=bool(hot)) for body in request.bodies}
    sides = (finest_grid.dx, finest_grid.dy)[: len(finest_grid.sides)]
    sizes = (min(sides), max(sides),
             min(derived.scales.semi_axis_x, derived.scales.semi_axis_y))
    # The last level is reported, the others are for its estimates.
    grids = [_collect(level.here, level.contact, request, depths, sizes, thermal=bool(hot), last=level is levels[-1])
             for level in levels]
    scalars, error = dict[str, float](), dict[str, float]()
    resolution = Resolution.of(levels[-1], scalars_by_level(levels), derived, plan)
    for body, collector in grids[-1].items():
        own = collector.scalars()
        uncertain = stress_estimates([grid[body] for grid in grids], summary, resolution)
        scalars, error = scalars | own, error | uncertain
        strength, layers = getattr(request, f"{body}_strength"), getattr(derived.problem, body).layers
        if strength is not None and strength.shear_yield is not None:
            of_surface = strength.shear_yield if not layers else layers[0].shear_yield or math.nan
            name = f"shakedown_k_{body}_MPa"
            found, of_found = strength_scalars(body, strength.shear_yield * 1e-6, derived.problem.normal_force, own[name],
                                               uncertain[name], summary, of_surface * 1e-6)
            scalars, error = scalars | found, error | of_found
    warmed = [body for body in recirculating(derived) if body in hot]
    below = Subsurface({body: collector.result() for body, collector in grids[-1].items()}, scalars,
                       tuple(_warnings(grids[-1], warmed)))
    seconds = {**result.work["seconds"], "below the surface": round(time.perf_counter() - start, 6)}
    numerics, reason = result.problem.numerics, result.reason
    # The grid was chosen for the surface.
    asked = of_contacts(numerics.accuracy_of).difference(*(collector.without_peak() for collector in grids[-1].values()))
    asked_errors = {name: each for name, each in error.items() if name in asked and computed(scalars[name])}
    if unsure := missed(asked_errors, numerics.accuracy):
        cut_off = any(collector.cut_off & unsure.keys() for collector in grids[-1].values())
        message = not_reached(numerics.accuracy, unsure, "below the surface on the grid that the surface needs",
                              "set a larger subsurface.depth_mm" if cut_off else "set numerics.grid")
        reason = "; ".join(filter(None, (reason, message)))
    numbers = {**result.numbers, **below.scalars}
    uncertainty = {name: (each + rounded(name, derived, scalars)) * error_scale(name, numbers) for name, each in error.items()}
    return replace(result, subsurface=below, uncertainty={**result.uncertainty, **uncertainty},
                   work={**result.work, "seconds": seconds}, converged=not reason, reason=reason,
                   warnings=(*result.warnings, *below.warnings))


def _warnings(finest: Collectors, warmed: Iterable[str]) -> Iterator[str]:
    """Doubts about stresses below the surface; the bodies `warmed` have heat of earlier passes."""
    largest = [name for collector in finest.values() for name in collector.scalars() if name in collector.cut_off
               and name.endswith("_MPa")
               and not {name.removeprefix("elastic_"), name.replace("_below_", "_")} & collector.cut_off - {name}]
    if largest:
        yield (f"may be larger below the last depth computed, and have no error estimate: {', '.join(largest)}; set a larger "
               "subsurface.depth_mm")
    for body, collector in finest.items():
        if few_depths(collector.depths, collector.width):
            yield (f"{len(collector.depths)} depths of the {body} body are far apart, which makes the error estimates of its "
                   "stresses wide: set more subsurface.layers")
    for body in warmed:
        yield (f"below the surface of the {body} body there is the heat of this pass alone: temperatures and thermal stresses "
               "lack what earlier passes have left")
    for body, collector in finest.items():
        if collector.interfaces_cut_off():
            yield (f"the largest shear stress of the interfaces of the {body} body lies at the border of the domain: set a "
                   "larger numerics.extent")


def stresses_by_depth(
    loads: Mapping[str, tuple[StressTransforms, SurfaceLoad]], depths: Mapping[str, Array]
) -> Iterator[tuple[str, int, Array, tuple[Array, Array] | None]]:
    """Body, number of the depth, elastic stresses, and thermal stresses with temperatures; bodies that are alike in turn."""
    heats = {body: ThermalStresses(transforms, load).at(depths[body]) for body, (transforms, load) in loads.items()
             if load.heat is not None}
    for alike in _alike({body: load for body, (_, load) in loads.items()}):
        transforms, first = loads[alike[0]]
        elastic = ElasticStresses(transforms, first.pressure, first.traction, first.poisson_ratio, first.layered)
        for index, depth in enumerate(depths[alike[0]]):
            parts = elastic.at(float(depth))
            for body in alike:
                yield body, index, loads[body][1].elastic(*parts), next(heats[body]) if body in heats else None


def scalars_below(discretisation: Discretisation, contact: Contact, scales: DerivedQuantities) -> dict[str, float]:
    """The largest elastic stresses inside the bodies that the problem of `scales` asks for, and their places, of a state over
    time: in depths of the contact of that problem."""
    request, grid = scales.problem.subsurface, discretisation.grid
    if request is None:
        return {}
    depths: dict[str, Array] = {body: depths_of(request, scales, body, heated=False) for body in request.bodies}
    sides = (grid.dx, grid.dy)[: len(grid.sides)]
    sizes = min(sides), max(sides), min(scales.scales.semi_axis_x, scales.scales.semi_axis_y)
    found = _collect(discretisation, contact, request, depths, sizes, thermal=False, last=False)
    scalars = {name: value for collector in found.values() for name, value in collector.scalars().items()}
    return {name: value for name, value in scalars.items() if not name.startswith("elastic_")}


def _collect(
    discretisation: Discretisation, contact: Contact, request: SubsurfaceRequest, depths: dict[str, Array],
    sizes: tuple[float, float, float], *, thermal: bool, last: bool,
) -> Collectors:
    """All depths of the bodies asked for on one grid; fields are kept of the `last` one. `sizes` are those of `Collector`."""
    mirrored = discretisation.derived.kinematics.mirror_on(discretisation.grid.ny, heated=thermal) == (1, -1)
    transforms = StressTransforms(discretisation.grid, mirrored)
    loads = surface_loads(discretisation, contact, request.bodies, thermal)
    y = discretisation.grid.y[-transforms.columns :]
    pressure = contact.normal.pressure[:, -transforms.columns :]
    plane = int(np.argmax(pressure.max(axis=0)))
    collectors = {
        body: Collector(body, depths[body], discretisation.grid.x, y, mirrored, load.heat is not None,
                        request.fields if last else None, plane, *sizes, load.layered.interfaces if load.layered else ())
        for body, load in loads.items()
    }
    for body, collector in collectors.items():
        if (strength := getattr(request, f"{body}_strength")) is not None:
            material = getattr(discretisation.derived.problem, body)
            collector.strength = StrengthCollector(strength, material, depths[body], len(y), mirrored, collector.thermal)
    further = {body: Beyond.of(discretisation.grid, load) for body, load in loads.items()
               if collectors[body].strength is not None}
    here = {body: (transforms, load) for body, load in loads.items()}
    there = {body: (StressTransforms(part.grid, mirrored), part.load) for body, part in further.items()}
    outside = stresses_by_depth(there, depths)
    for body, index, elastic_stress, thermal_stress in stresses_by_depth(here, depths):
        beyond = further[body].history(*next(outside)[2:]) if body in further else None
        collectors[body].take(index, elastic_stress, thermal_stress, beyond)
    for body, collector in collectors.items():
        for index in collector.interfaces_cut_off():
            # On twice the domain.
            grid, load = transforms.grid, loads[body]
            margin = (grid.nx // 2,) * 2, (grid.ny // 2,) * 2
            wide = StressTransforms(replace(grid, nx=grid.nx + sum(margin[0]), ny=grid.ny + sum(margin[1])), mirrored)
            traction = None if load.traction is None else np.pad(load.traction, ((0, 0), *margin))
            elastic = ElasticStresses(wide, np.pad(load.pressure, margin), traction, load.poisson_ratio, load.layered)
            stress = load.elastic(*elastic.at(float(collector.depths[index])))
            collector.take_interface(index, stress, wide.grid.x, wide.grid.y[-wide.columns :])
    return collectors


def _alike(loads: dict[str, SurfaceLoad]) -> Iterable[list[str]]:
    """Bodies whose elastic stresses differ by the sign of τ alone: of the same Poisson ratio, or the same coating."""
    groups: dict[tuple[float, LayeredBody | None], list[str]] = {}
    for body, load in loads.items():
        groups.setdefault((load.poisson_ratio, load.layered), []).append(body)
    return groups.values()
