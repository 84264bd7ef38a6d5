"""Stresses in bodies with bonded layers, from whole runs: depths, interfaces, what delaminates and cracks, estimates."""

from __future__ import annotations

import csv
import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.support.command_line import call
from tests.support.errors import relative
from tests.support.scenes import MECHANICAL, elastic, ellipse, rolling
from thermoroll_cli.files.result.outcome import read_result
from thermoroll_cli.one_contact.refinement.plan import make_plan
from thermoroll_cli.one_contact.refinement.subsurface_plan import usual_depths, with_interfaces
from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.physics.stress.body_stresses import peak_of
from thermoroll_cli.physics.stress.strength import principal_and_shear
from thermoroll_cli.plots.pictures import figure
from thermoroll_cli.problem.geometry import Unsolvable
from thermoroll_cli.problem.names import BOND_SCALARS
from thermoroll_cli.problem.problem import Heating, Layer, Material, Numerics, Strength, SubsurfaceRequest
from thermoroll_cli.problem.result import Result, within_layers
from thermoroll_cli.python_api import solve

ROOT = Path(__file__).parents[2]
STEEL = elastic(0.3)
LAYERS = (Layer(4e-5, 350e9, 0.2), Layer(6e-5, 70e9, 0.4))
COATED = replace(STEEL, layers=LAYERS)
FULL = SubsurfaceRequest(fields="full")


def solved(lower: Material, upper: Material, request: SubsurfaceRequest = FULL, **given: object) -> Result:
    problem = rolling(**{"grid": 16, "creepage": (1.0, 0.0), "friction": 0.2, **given})  # type: ignore[arg-type]
    return solve(replace(problem, lower=lower, upper=upper, heating=MECHANICAL, subsurface=request))


@pytest.fixture(scope="module")
def coated() -> Result:
    return solved(STEEL, COATED, replace(FULL, layers=16), grid=12)


def stresses_of(result: Result, body: str) -> np.ndarray:
    fields = result.bodies[body].fields
    return np.stack([fields[f"stress_{name}"] for name in ("xx", "yy", "zz", "xy", "xz", "yz")]).astype(float)


def test_depths_have_both_sides_of_interfaces() -> None:
    plain = usual_depths(1e-3)
    assert with_interfaces(plain, ()) is plain
    depths = with_interfaces(plain, (2e-6, 5e-4, 1.0))
    assert (np.diff(depths) > 0.0).all() and depths[0] == 0.0 and depths[-1] == plain[-1]
    parts = within_layers(depths)
    assert [float(depths[part][-1]) for part in parts] == [2e-6, 5e-4, plain[-1]]
    assert all(len(depths[part]) >= 5 for part in parts)
    # As dense as without layers.
    steps = np.interp(depths, plain, np.arange(len(plain)))
    assert np.diff(steps).max() < 1.0 + 1e-9


def test_the_peak_of_a_bent_layer_lies_at_a_face() -> None:
    """|bending stress| in a thin stiff layer: a V whose polynomials must not exceed its ends, wherever the layer lies."""
    axis = np.arange(3.0)
    for top, bottom in ((2e-6, 1.2e-5), (2e-6, 8e-5), (1e-5, 1e-4), (6e-5, 1.2e-4)):
        depths = with_interfaces(usual_depths(1e-3), (top, bottom))
        for shift in (0.0, 0.1, 0.2):
            bending = np.abs((depths - top) / (bottom - top) - 0.5 - shift)
            values = np.where((depths > top) & (depths <= bottom), bending, 0.0)[:, None, None] * np.ones((1, 3, 3))
            assert peak_of(values, depths, axis, axis).value <= 1.03 * (0.5 + shift)


def test_peaks_are_not_searched_across_interfaces() -> None:
    """A field that jumps from 1 to 0: a polynomial through both sides would overshoot."""
    depths, axis = with_interfaces(np.linspace(0.0, 1.0, 11), (0.5,)), np.arange(3.0)
    values = np.where(depths <= 0.5, depths, 0.0)[:, None, None] * np.ones((1, 3, 3))
    for every in (1, 2):
        assert peak_of(values, depths, axis, axis, every=every).value <= 0.5


@pytest.mark.slow
def test_bodies_press_on_each_other_alike(coated: Result) -> None:
    lower, upper = stresses_of(coated, "lower")[:, 0], stresses_of(coated, "upper")[:, 0]
    scale = np.abs(lower[2]).max()
    assert np.abs(lower[2] - upper[2]).max() < 1e-5 * scale
    assert np.abs(lower[4:] + upper[4:]).max() < 1e-5 * scale > 1e-5 * np.abs(lower[4]).max() > 0.0


@pytest.mark.slow
def test_scalars_are_those_of_the_fields(coated: Result) -> None:
    scalars, stresses, depths = coated.subsurface.scalars, stresses_of(coated, "upper"), coated.bodies["upper"].depths
    at = [part.stop - 1 for part in within_layers(depths)[:-1]]
    shear, tension = np.hypot(*stresses[4:, at]).max() * 1e-6, stresses[2, at].max() * 1e-6
    cracking = principal_and_shear(stresses[:, : at[-1] + 1])[0].max() * 1e-6
    for name, largest in (("interface_shear", shear), ("interface_tension", max(tension, 0.0)), ("layer_tension", cracking)):
        found = scalars[f"{name}_max_upper_MPa"]
        assert largest * (1.0 - 1e-6) <= found <= 1.05 * largest + 0.01
        assert 0.0 < relative(coated)[f"{name}_max_upper_MPa"] < 1.0
    assert scalars["interface_shear_max_upper_MPa"] > 10.0
    assert not [name for name in scalars if name in BOND_SCALARS and "lower" in name]


def test_bodies_coated_alike_share_tables() -> None:
    problem = replace(rolling(grid=16), lower=COATED, upper=COATED, heating=MECHANICAL, subsurface=SubsurfaceRequest())
    assert "same coatings" in make_plan(problem).skipped["below the surface, tables of the second body"]
    other = make_plan(replace(problem, upper=STEEL)).skipped
    assert "below the surface, tables of the second body" not in other


def test_an_interface_deeper_than_the_stresses_is_named() -> None:
    """What the layers carry is reported all the same."""
    thick = replace(STEEL, layers=(Layer(5e-3, 70e9, 0.3),))
    problem = replace(rolling(grid=16, creepage=(0.5, 0.0)), upper=thick, heating=MECHANICAL,
                      subsurface=SubsurfaceRequest(("upper",), layers=8))
    assert "depth_mm" in make_plan(problem).skipped["below the surface, interface of the upper body"]
    scalars = solve(problem).subsurface.scalars
    assert math.isnan(scalars["interface_shear_max_upper_MPa"])
    assert scalars["layer_tension_max_upper_MPa"] == scalars["tensile_stress_max_upper_MPa"]


@pytest.mark.slow
def test_layers_shake_down_by_their_own_yield() -> None:
    """Those without one do not yield; the smallest factor of all depths counts, Dang Van's stress below the layers."""
    def strong(first: float | None, own: float | None = 3e8) -> Result:
        upper = replace(STEEL, layers=(replace(LAYERS[0], shear_yield=first), LAYERS[1]))
        return solved(STEEL, upper, SubsurfaceRequest(("upper",), upper_strength=Strength(own, 0.3)), grid=12)

    plain, given = strong(None), strong(1e8)
    kept, depths = plain.bodies["upper"].strength, plain.bodies["upper"].depths
    first, *_, last = within_layers(depths)
    scalars = plain.subsurface.scalars
    for name, field in (("shakedown_k", "shakedown_k"), ("alternating_k", "alternating_k"), ("dang_van_max", "dang_van")):
        largest = kept[field][last].max() * 1e-6
        assert largest * (1.0 - 1e-9) <= scalars[f"{name}_upper_MPa"] <= 1.02 * largest
        assert math.isnan(scalars[f"{name}_surface_upper_MPa"])
    assert scalars["shakedown_factor_upper"] == pytest.approx(300.0 / scalars["shakedown_k_upper_MPa"])
    assert math.isnan(scalars["fatigue_index_surface_upper"])
    assert not math.isnan(relative(plain)["shakedown_factor_upper"])
    assert strong(None, None).subsurface.scalars["shakedown_k_upper_MPa"] == scalars["shakedown_k_upper_MPa"]
    weak, needed = given.subsurface.scalars, kept["shakedown_k"][first].max()
    assert weak["shakedown_factor_upper"] == pytest.approx(1e8 / needed, rel=0.02)
    assert weak["shakedown_depth_upper_mm"] <= depths[first][-1] * 1e3
    assert weak["dang_van_max_upper_MPa"] == scalars["dang_van_max_upper_MPa"]
    index = math.hypot(given.coupled.scalars["force_x_N"]) / given.problem.normal_force
    assert weak["fatigue_index_surface_upper"] == pytest.approx(index - 100.0 / given.coupled.scalars["pressure_max_MPa"])
    assert figure(given, "strength_upper") is not None and figure(given, "shakedown_map") is None


@pytest.mark.slow
def test_deep_interfaces_are_searched_beyond_the_domain() -> None:
    """Shear stress 2 semi-axes below a long contact is largest beside it: as on a domain of twice the side."""
    problem = rolling(grid=16, friction=0.0, geometry=ellipse(0.3))
    a = DerivedQuantities(problem).hertz.semi_axis_x
    upper = replace(STEEL, layers=(Layer(2.0 * a, 100e9, 0.3),))
    problem = replace(problem, upper=upper, heating=MECHANICAL, subsurface=SubsurfaceRequest(("upper",)))
    found, wide = (solve(replace(problem, numerics=Numerics(grid=(grid, grid), extent=extent)))
                   for grid, extent in ((16, 2.2), (32, 4.4)))
    assert not [warning for warning in found.warnings if "border of the domain" in warning]
    for name in ("interface_shear_max_upper_MPa", "interface_tension_max_upper_MPa"):
        value, pressure = wide.subsurface.scalars[name], wide.coupled.scalars["pressure_max_MPa"]
        assert found.subsurface.scalars[name] == pytest.approx(value, rel=0.005, abs=1e-3 * pressure)
    assert found.subsurface.scalars["interface_shear_max_upper_MPa"] > 10.0
    fields = solve(replace(problem, subsurface=replace(FULL, bodies=("upper",)))).bodies["upper"]
    at = within_layers(fields.depths)[0].stop - 1
    inside = np.hypot(fields.fields["stress_xz"][at], fields.fields["stress_yz"][at]).max() * 1e-6
    assert inside < 0.998 * found.subsurface.scalars["interface_shear_max_upper_MPa"]


def test_stresses_are_refused_in_a_coating_that_rounding_rules() -> None:
    with pytest.raises(Unsolvable, match="stresses are not computed in a coating of 1e-06 µm"):
        solved(replace(STEEL, layers=(Layer(1e-12, 350e9, 0.2),)), STEEL)


def test_thermal_stresses_are_refused_where_a_body_has_layers() -> None:
    def warm(material: Material | Layer) -> Material | Layer:
        return replace(material, conductivity=50.0, expansion=1e-5, diffusivity=1e-5)

    coated = replace(warm(STEEL), layers=tuple(warm(layer) for layer in LAYERS))
    problem = replace(rolling(grid=16, creepage=(0.5, 0.0)), lower=warm(STEEL), upper=coated, heating=Heating())
    for request in (SubsurfaceRequest(thermal=False), SubsurfaceRequest(("lower",))):
        make_plan(replace(problem, subsurface=request))
    with pytest.raises(Unsolvable, match="thermal stresses are not computed"):
        make_plan(replace(problem, subsurface=SubsurfaceRequest()))


@pytest.mark.slow
def test_a_coated_ball_through_files(tmp_path: Path) -> None:
    """From the command line: scalars in JSON, HDF5 and CSV, the picture, a history on both sides of an interface, the plan."""
    case = ROOT / "cases" / "coated_ball.toml"
    few = "--set", "subsurface.layers=10"
    done = call("run", case, "--set", "numerics.grid=12", *few, "-o", tmp_path, "--json", "--no-plots")
    assert done.returncode == 0
    record = json.loads(done.stdout)
    assert any("elements thick" in warning and "stresses" in warning for warning in record["warnings"])
    stored = read_result(tmp_path / "coated_ball.h5")
    for name in ("interface_shear_max_upper_MPa", "interface_tension_max_upper_MPa", "layer_tension_max_upper_MPa"):
        assert record[name] == stored.summary()[name] > 0.0
        assert 0.0 < record["uncertainty"][name] == stored.uncertainty[name]
    axes = figure(stored, "subsurface_upper").axes
    assert [line.get_ydata()[0] for line in axes[3].get_lines()[-2:]] == pytest.approx([2.0, 2.5])  # µm
    y, below = stored.bodies["upper"].plane_y * 1e3, {}
    for z in (1.999, 2.0, 2.001):
        at = "--stress-path", f"{y!r},{z * 1e-3!r}", "-o", tmp_path / str(z)
        assert call("export", tmp_path / "coated_ball.h5", "--format", "csv", *at).returncode == 0
        with open(tmp_path / str(z) / "coated_ball_stress_path.csv") as stream:
            below[z] = np.array([float(row["upper_stress_xx_MPa"]) for row in csv.DictReader(stream)])
    change, jump = (np.abs(below[z] - below[2.0]).max() for z in (1.999, 2.001))
    assert jump > 20.0 * change > 0.0
    over = "--set", "numerics.grid=8", "--set", "subsurface.layers=6", "--over", "load.normal_N=50,60", "--no-plots"
    assert call("sweep", case, *over, "-o", tmp_path / "s").returncode == 0
    with open(tmp_path / "s" / "sweep.csv") as stream:
        shear = [float(row["interface_shear_max_upper_MPa"]) for row in csv.DictReader(stream)]
    assert shear[1] > shear[0] > 0.0
    shown = json.loads(call("show", case, *few, "--json").stdout)
    assert "below the surface" in shown["run"] and shown["subsurface_layers"] == len(stored.bodies["upper"].depths)
