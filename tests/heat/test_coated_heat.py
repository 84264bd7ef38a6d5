"""Heat through bonded layers: symbols and tables against independent quadratures, limits, whole cases, files."""

from __future__ import annotations

import itertools
import json
from dataclasses import replace

import numpy as np
import pytest

from tests.support.cases import parse
from tests.support.command_line import THERMAL
from tests.support.sampling import sampled
from tests.support.scenes import reference
from thermoroll_cli.one_contact.steady_state.heated_bodies import heated_bodies
from thermoroll_cli.physics.halfspace.layered_thermal import LayeredHeat
from thermoroll_cli.physics.halfspace.thermal import displacement_table, temperature_at_depths, temperature_table
from thermoroll_cli.physics.heat.heat_response import DividedHeat, HeatResponse
from thermoroll_cli.physics.numerics.grid import Grid
from thermoroll_cli.problem.friction import Friction
from thermoroll_cli.problem.geometry import Geometry, Unsolvable
from thermoroll_cli.problem.problem import Heating, Layer, Material, Motion, Numerics, Problem, SubsurfaceRequest
from thermoroll_cli.python_api import solve

REFERENCE = reference("layered_thermal")
STEEL = Material(210e9, 0.3, 46.0, 11.8e-6, 12.5e-6)
CARBON = Layer(2e-6, 220e9, 0.2, 1.5, 2.3e-6, 0.7e-6)
POLYMER = Layer(1e-4, 3e9, 0.4, 0.25, 80e-6, 0.15e-6)


def body_of(row: dict) -> Material:
    layers = tuple(Layer(**{"expansion": None, **layer}) for layer in row["layers"])
    return Material(**row["substrate"], layers=layers)


def surface_tables(body: Material, n: int, dx: float, dy: float, speed: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
    """Temperature and expansion per flux."""
    layers, top = LayeredHeat(body), body.layers[0]
    place = n, n, dy / dx, speed[0] * dx / top.diffusivity, speed[1] * dx / top.diffusivity
    temperature = dx / top.conductivity * temperature_table(*place)
    expansion = (1.0 + top.poisson_ratio) * top.expansion * dx**2 / top.conductivity * displacement_table(*place)
    return tuple(plain + layers.table(quantity, (n, n), (dx, dy), speed)
                 for plain, quantity in ((temperature, "temperature"), (expansion, "expansion")))


@pytest.mark.parametrize("row", REFERENCE["symbols"], ids=lambda row: f"{len(row['layers'])}-{row['kx']}-{row['V']}")
def test_symbols_agree_with_collocation(row: dict) -> None:
    body, wave, speed = body_of(row), (np.array([row["kx"]]), np.array([row["ky"]])), (row["V"], 0.0)
    top, k = body.layers[0], np.hypot(*wave)
    s = np.sqrt(k**2 + 1j * wave[0] * row["V"] / top.diffusivity)
    temperature = LayeredHeat(body).temperature_symbol(*wave, speed) + 1.0 / (top.conductivity * s)
    expansion = LayeredHeat(body).expansion_symbol(*wave, speed) + (
        2.0 * (1.0 + top.poisson_ratio) * top.expansion / (top.conductivity * s * (k + s)))
    assert temperature[0] == pytest.approx(complex(*row["T"]), rel=1e-10)
    assert expansion[0] == pytest.approx(complex(*row["u_z"]), rel=1e-9)


CASES = [list(rows) for _, rows in itertools.groupby(REFERENCE["tables"], lambda row: json.dumps(
    [row[name] for name in ("layers", "substrate", "dx", "dy", "V")]))]


@pytest.mark.parametrize("rows", sampled(CASES, 4), ids=lambda rows: f"{rows[0]['layers'][0]['thickness']}-{rows[0]['V']}")
def test_tables_agree_with_quadrature(rows: list[dict]) -> None:
    row, n = rows[0], 24
    temperature, expansion = surface_tables(body_of(row), n, row["dx"], row["dy"], (row["V"], 0.0))
    if row["V"] == 0.0:
        expansion = expansion - expansion[n - 1, n - 1]
    for table, name in ((temperature, "T"), (expansion, "u_z")):
        largest = max(abs(row[name]) for row in rows)
        for row in rows:
            assert abs(table[n - 1 + row["i"], n - 1 + row["j"]] - row[name]) < 1e-7 * largest


@pytest.mark.parametrize("speed", [(0.0, 0.0), (5.0, 0.0), (5.0, 0.02)])
def test_temperature_of_an_interface_is_that_of_its_depth(speed: tuple[float, float]) -> None:
    own = tuple(vars(STEEL)[name] for name in ("youngs_modulus", "poisson_ratio", "conductivity", "expansion", "diffusivity"))
    dx, dy = 1e-5, 1.3e-5
    found = LayeredHeat(replace(STEEL, layers=(Layer(8e-6, *own),))).table("interface", (16, 16), (dx, dy), speed)
    offsets = np.arange(-15.0, 16.0), 1.3 * np.arange(-15.0, 16.0)
    peclets = (speed[0] * dx / STEEL.diffusivity, speed[1] * dx / STEEL.diffusivity)
    expected = dx / STEEL.conductivity * temperature_at_depths(*offsets, np.array([0.8]), 1.3, *peclets)[0]
    assert np.abs(found - expected).max() < 1e-7 * expected.max()


def test_slopes_are_those_of_finer_elements() -> None:
    """Heat that changes linearly through an element: from 15 elements of a finer grid."""
    body, parts, dx = LayeredHeat(replace(STEEL, layers=(CARBON,))), 15, 6e-6
    found = body.table("temperature", (4, 1), (dx, dx), (3.0, 0.0), slope=True)[:, 0]
    fine = body.table("temperature", (4 * parts, 1), (dx / parts, dx), (3.0, 0.0))[:, 0]
    flux = (np.arange(parts) - 0.5 * (parts - 1)) / parts
    centre = 4 * parts - 1
    expected = [flux @ fine[centre + offset * parts - np.arange(parts) + parts // 2] for offset in (-2, -1, 0, 1, 2)]
    assert found[1:6] == pytest.approx(expected, abs=6e-3 * max(map(abs, expected)))


def coated(lower: Material, upper: Material, creepage: float = 0.05, speed: float = 8.0, **changed: object) -> Problem:
    problem = Problem(lower, upper, Geometry(0.03, -0.006, 0.005, 0.005), 50.0, Friction(0.1), Motion(speed, creepage, 0.0),
                      Heating(partition="matched"), Numerics(grid=(16, 16)))
    return replace(problem, **changed)


@pytest.mark.slow
def test_surfaces_that_touch_are_equally_warm() -> None:
    result = solve(coated(STEEL, replace(STEEL, layers=(CARBON,))))
    fields, scalars = result.coupled.fields, result.coupled.scalars
    inside = fields["covered"] == 1.0
    rises = fields["temperature_rise_lower"][inside], fields["temperature_rise_upper"][inside]
    assert np.abs(rises[0] - rises[1]).max() < 1e-5 * rises[0].max()
    # Carbon keeps the heat out of the ball, and its interface cool.
    assert scalars["partition_mean"] > 0.7
    assert 0.0 < scalars["temperature_interface_max_upper_K"] < 0.5 * scalars["temperature_rise_max_upper_K"]
    assert np.isnan(scalars["temperature_interface_max_lower_K"])


@pytest.mark.slow
def test_bodies_coated_alike_share_the_heat() -> None:
    body = replace(STEEL, layers=(CARBON,))
    result = solve(coated(body, body, creepage=0.0, motion=Motion(8.0, 0.0, 0.02), numerics=Numerics(grid=(8, 8))))
    assert result.coupled.scalars["partition_mean"] == pytest.approx(0.5, abs=1e-3)
    bodies = heated_bodies(coated(body, body, creepage=0.0), 0.0, 0.0)
    assert HeatResponse(Grid.over((8, 8), 1e-4, 1e-4), *bodies).matched_share == 0.5


def test_response_is_the_sum_of_its_tables() -> None:
    """All of a heat flux in one element: temperatures and expansions are the tables of the element."""
    problem = coated(replace(STEEL, layers=(POLYMER, CARBON)), replace(STEEL, layers=(CARBON,)))
    grid, n = Grid.over((9, 9), 1.8e-4, 1.8e-4), 9
    lower, upper = heated_bodies(problem, 0.05, 0.0)
    flux = np.zeros((n, n))
    flux[4, 4] = 2e6
    heat = DividedHeat(flux, 0.25, slope=np.zeros((n, n)))
    response = HeatResponse(grid, lower, upper)
    tables = [surface_tables(body, n, grid.dx, grid.dy, (heated.speed_x, 0.0))
              for body, heated in ((problem.lower, lower), (problem.upper, upper))]
    expected = [2e6 * share * both[0][4:13, 4:13] for share, both in zip((0.25, 0.75), tables, strict=True)]
    for one, other in zip(response.temperatures(heat), expected, strict=True):
        assert np.abs(one - other).max() < 1e-9 * other.max()
    sum_of_both = 2e6 * (0.25 * tables[0][1] + 0.75 * tables[1][1])[4:13, 4:13]
    assert np.abs(response.displacement(heat) - sum_of_both).max() < 1e-8 * np.abs(sum_of_both).max()


def test_points_of_a_sweep_share_the_tables() -> None:
    body = replace(STEEL, layers=(CARBON,))
    solve(coated(STEEL, body))
    built = LayeredHeat.table.cache_info().misses
    solve(coated(STEEL, body, friction=Friction(0.05)))
    assert LayeredHeat.table.cache_info().misses == built


@pytest.mark.parametrize("changed", [{"heating": Heating(peclet="sliding")}, {"subsurface": SubsurfaceRequest()}], ids=str)
def test_problems_of_scripts_are_refused_likewise(changed: dict) -> None:
    with pytest.raises(Unsolvable, match="coated bodies"):
        solve(coated(STEEL, replace(STEEL, layers=(CARBON,)), **changed))


CASE = THERMAL.replace("[geometry]", """\
[[material.layers]]
thickness_um = 2.0
youngs_modulus_GPa = 220.0
poisson_ratio = 0.2
conductivity_W_mK = 1.5
expansion_um_mK = 2.3
diffusivity_mm2_s = 0.7
[geometry]""")


def test_constants_of_a_case() -> None:
    assert parse(CASE).problem.lower.layers == (CARBON,)


def test_layers_far_from_solids_are_named() -> None:
    result = solve(parse(CASE.replace("diffusivity_mm2_s = 0.7", "diffusivity_mm2_s = 700.0"), "numerics.grid=8").problem)
    assert any("layer 1 of the coating of both bodies" in warning for warning in result.warnings)
