"""Stresses and temperatures on whole layers: against the fields of Hertz loads, sums over elements, equilibrium."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

from tests.support.documents import at_most
from tests.support.interpolation import at_point
from thermoroll_cli.exact.hertz import HertzContact, element_averages, hertz_contact
from thermoroll_cli.one_contact.refinement.subsurface_stage import SurfaceLoad
from thermoroll_cli.physics.halfspace.subsurface_elastic import pressure_stress, traction_x_stress, traction_y_stress
from thermoroll_cli.physics.halfspace.subsurface_thermal import thermal_stress
from thermoroll_cli.physics.halfspace.thermal import temperature_at_depths
from thermoroll_cli.physics.numerics.convolution import counted
from thermoroll_cli.physics.numerics.grid import Grid
from thermoroll_cli.physics.stress.strength import principal_and_shear, von_mises
from thermoroll_cli.physics.stress.superposition import ElasticStresses, Sharpened, StressTransforms, ThermalStresses, averaging

FIELDS = json.loads((Path(__file__).parents[1] / "reference" / "subsurface_fields.json").read_text())
NU = 0.3


def hertz_load(n, side=2.2):
    """A hemispherical load of unit radius and height on n × n elements, averaged over each."""
    grid = Grid.over((n, n), side, side)
    edges = (np.arange(n + 1) - 0.5 * n) * grid.dx
    return grid, element_averages(HertzContact(1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0), edges, edges)[0]


def heated(heat, pe):
    return SurfaceLoad(heat, None, heat, NU, 1.0, 1.0, 1.0, 1.0, (pe, 0.0))


def largest_errors(n, pe):
    """Of elastic stresses in p₀, thermal ones in Eα q₀a/k(1−ν) and temperatures in q₀a/k, at the points inside the domain."""
    grid, load = hertz_load(n)
    axes = grid.x, grid.y
    transforms = StressTransforms(grid, mirrored=False)
    elastic = ElasticStresses(transforms, load, np.stack([load, np.zeros_like(load)]), NU)
    points = [r for r in FIELDS["elastic"] if abs(r["x"]) <= 1.0]
    hot = [r for r in FIELDS["thermal"] if abs(r["x"]) <= 1.0 and r["Pe"] == pe]
    depths = np.array(sorted({r["z"] for r in points}))
    worst = np.zeros(3)
    for z, (stress, rise) in zip(depths, ThermalStresses(transforms, heated(load, pe)).at(depths), strict=True):
        pressed, dragged = elastic.at(z)
        for r in points:
            if r["z"] == z:
                for field, name in ((pressed, "stress_p"), (dragged, "stress_tx")):
                    got = [at_point(c, axes, (r["x"], r["y"])) for c in field]
                    worst[0] = max(worst[0], np.abs(np.subtract(got, r[name])).max())
        for r in hot:
            if r["z"] == z:
                got = [at_point(c, axes, (r["x"], r["y"])) for c in stress]
                worst[1] = max(worst[1], np.abs(np.subtract(got, r["stress_thermal"])).max())
                worst[2] = max(worst[2], abs(at_point(rise, axes, (r["x"], r["y"])) - r["temperature"]))
    return worst


@pytest.mark.slow
@pytest.mark.parametrize("pe", [5.0, *(pytest.param(pe, marks=pytest.mark.slow) for pe in (0.0, 100.0))])
def test_fields_of_hertz_loads(pe):
    """Exact to 1e-12 at twelve points; ours to 1e-4 at N = 128, at more than second order."""
    coarse, fine = largest_errors(32, pe), largest_errors(64, pe)
    # What is left of temperatures and thermal stresses of fast sources is the quadratures'.
    assert ((np.log2(coarse / fine) > 2.0) | (fine < 2e-7)).all()
    assert np.log2(coarse[0] / fine[0]) > 3.5
    finest = largest_errors(128, pe)
    assert (finest < [4e-6, 4e-7, 4e-7]).all()
    for errors, which in ((coarse, 0), (fine, 1), (finest, 2)):
        assert errors[0] <= at_most("verification", "circular Hertz loads", which=which)
    assert fine[1] <= at_most("verification", "thermal stresses of the same", which=[0.0, 5.0, 100.0].index(pe))


@pytest.mark.parametrize("aspect", [0.4, 2.5])
def test_layers_are_sums_over_elements(aspect):
    """FFT against the plain sum of element tables, for loads without any symmetry and elements that are not square."""
    grid = Grid(9, 7, 2e-3, 2e-3 * aspect)
    random = np.random.default_rng(3)
    pressure, (tx, ty), heat = random.random(grid.shape), random.random((2, *grid.shape)), random.random(grid.shape)
    depth, speed = 3.1e-3, (2.0, 0.3)
    load = SurfaceLoad(pressure, None, heat, NU, 1.0, 5.0, 7.0, 1e-3, speed)
    transforms = StressTransforms(grid, mirrored=False)
    pressed, dragged = ElasticStresses(transforms, pressure, np.stack([tx, ty]), NU).at(depth)
    ((hot, rise),) = ThermalStresses(transforms, load).at(np.array([depth]))
    x, y, z = np.arange(-8.0, 9.0), aspect * np.arange(-6.0, 7.0), depth / grid.dx
    peclet = [s * grid.dx / 1e-3 for s in speed]
    tables = {
        "pressed": (pressure_stress(x, y, z, aspect, NU), pressure),
        "x": (traction_x_stress(x, y, z, aspect, NU), tx),
        "y": (traction_y_stress(x, y, z, aspect, NU), ty),
        "hot": (thermal_stress(x, y, np.array([z]), aspect, *peclet, NU)[0] * 5.0 * grid.dx / 7.0, heat),
        "rise": (temperature_at_depths(x, y, np.array([z]), aspect, *peclet) * grid.dx / 7.0, heat),
    }
    sums = {name: plain_sum(table, sharpened(source, grid, depth)) for name, (table, source) in tables.items()}
    pairs = (pressed, sums["pressed"]), (dragged, sums["x"] + sums["y"]), (hot, sums["hot"]), ([rise], sums["rise"])
    for got, wanted in pairs:
        np.testing.assert_allclose(got, wanted, rtol=0.0, atol=1e-12 * np.abs(wanted).max())


def sharpened(source, grid, depth):
    """The load less its second differences, with a rim of one element around the grid, where they reach."""
    p = np.pad(source, 2)
    weight = [averaging(depth / size) for size in (grid.dx, grid.dy)]
    along = p[2:, 1:-1] - 2.0 * p[1:-1, 1:-1] + p[:-2, 1:-1]
    across = p[1:-1, 2:] - 2.0 * p[1:-1, 1:-1] + p[1:-1, :-2]
    return p[1:-1, 1:-1] - weight[0] * along - weight[1] * across


def plain_sum(table, source):
    """Σ table(observer − source), sources on a rim around the observers dropped: tables end where the grid does."""
    nx, ny = source.shape[0] - 2, source.shape[1] - 2
    total = np.zeros((len(table), nx, ny))
    wide = np.pad(table, ((0, 0), (1, 1), (1, 1)))
    for i in range(nx + 2):
        for j in range(ny + 2):
            total += source[i, j] * wide[:, nx + 1 - i : 2 * nx + 1 - i, ny + 1 - j : 2 * ny + 1 - j]
    return total


def test_half_is_enough_where_the_state_is_its_mirror_image():
    grid, load = hertz_load(12)
    traction = np.stack([load * (1.0 + grid.x[:, None]), 0.3 * load * grid.y * grid.x[:, None]])
    whole, half = (StressTransforms(grid, mirrored) for mirrored in (False, True))
    for depth in (0.0, 0.4):
        for a, b in zip(*(ElasticStresses(t, load, traction, NU).at(depth) for t in (whole, half)), strict=True):
            np.testing.assert_allclose(b, a[:, :, 6:], rtol=0.0, atol=1e-13)
    found, transforms = [], []
    for one in (whole, half):
        before = counted.transforms
        found.append(list(ThermalStresses(one, heated(load, 5.0)).at(np.array([0.0, 0.3]))))
        transforms.append(counted.transforms - before)
    for (a, hot), (b, warm) in zip(*found, strict=True):
        np.testing.assert_allclose(b, a[:, :, 6:], rtol=0.0, atol=1e-13)
        np.testing.assert_allclose(warm, hot[:, 6:], rtol=0.0, atol=1e-13)
    # A forward one; then per layer 7 back, of which 5 are even and 2 odd.
    assert transforms == [1 + 2 * 7, 1 + 2 * 5]


def test_a_cut_carries_the_load():
    """σ_zz over a plane is −W and σ_xz is −F_x, but for what passes outside the domain: by reciprocity the share of a point
    load inside is the stress under the middle of an element as wide as the domain."""
    side = 14.0
    grid, load = hertz_load(96, side)
    elastic = ElasticStresses(StressTransforms(grid, mirrored=False), load, np.stack([load, np.zeros_like(load)]), NU)
    force, middle = load.sum(), np.zeros(1)
    for depth in (0.5, 1.0):
        pressed, dragged = elastic.at(depth)
        carried = pressure_stress(middle, middle, depth / side, 1.0, NU)[2, 0, 0]
        assert -1.0 <= carried < -0.995
        assert pressed[2].sum() / force == pytest.approx(carried, abs=5e-4)
        carried = traction_x_stress(middle, middle, depth / side, 1.0, NU)[4, 0, 0]
        assert -1.0 <= carried < -0.80
        assert dragged[4].sum() / force == pytest.approx(carried, abs=2e-3)
        assert abs(pressed[4].sum()) < 1e-10 * force


def test_surface_carries_what_is_put_on_it():
    grid, load = hertz_load(24)
    traction = np.stack([0.3 * load, 0.1 * load * grid.x[:, None]])
    transforms = StressTransforms(grid, mirrored=False)
    pressed, dragged = ElasticStresses(transforms, load, traction, NU).at(0.0)
    on_it = [transforms.plane.inverse(Sharpened(transforms, t).below(0.0)) for t in (load, *traction)]
    np.testing.assert_allclose(pressed[2], -on_it[0], rtol=0.0, atol=1e-13)
    np.testing.assert_allclose(dragged[[4, 5]], -np.stack(on_it[1:]), rtol=0.0, atol=1e-13)
    ((hot, _),) = ThermalStresses(transforms, heated(load, 20.0)).at(np.zeros(1))
    assert np.abs(hot[[2, 4, 5]]).max() < 1e-13 * np.abs(hot).max()


def test_invariants():
    random = np.random.default_rng(5)
    stress = random.normal(size=(6, 40))
    xx, yy, zz, xy, xz, yz = stress
    tensors = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]).transpose(2, 0, 1)
    principal = np.linalg.eigvalsh(tensors)
    np.testing.assert_allclose(principal_and_shear(stress)[0], principal[:, 2], rtol=0.0, atol=1e-13)
    np.testing.assert_allclose(principal_and_shear(stress)[1], 0.5 * (principal[:, 2] - principal[:, 0]), rtol=1e-12)
    one, two, three = principal.T
    np.testing.assert_allclose(von_mises(stress), np.sqrt(0.5 * ((one - two) ** 2 + (two - three) ** 2 + (three - one) ** 2)))
    hydrostatic = np.array([2.0, 2.0, 2.0, 0.0, 0.0, 0.0])
    assert von_mises(hydrostatic) == 0.0
    assert principal_and_shear(hydrostatic)[0] == 2.0
    assert von_mises(np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0])) == pytest.approx(math.sqrt(3.0))


def test_stresses_change_smoothly_with_depth_beneath_slender_elements():
    """Also where elements are six times as wide across as along: no jump half an element deep, and 2e-4 of p0 at any depth."""
    hertz = hertz_contact(50.0, 3.0, 115e9, 2000.0)

    def stress(elements, depths):
        grid = Grid.over((elements, elements), 2.2 * hertz.semi_axis_x, 2.2 * hertz.semi_axis_y)
        edges = [np.append(c - 0.5 * d, c[-1] + 0.5 * d) for c, d in ((grid.x, grid.dx), (grid.y, grid.dy))]
        layers = ElasticStresses(StressTransforms(grid, mirrored=False), element_averages(hertz, *edges)[0], None, NU)
        middle = elements // 2
        return np.array([von_mises(layers.at(depth)[0])[middle, middle] for depth in depths]) / hertz.peak_pressure

    width = 2.2 * hertz.semi_axis_y / 33
    around = stress(33, width * np.array([0.5 - 1e-6, 0.5 + 1e-6]))
    assert around[0] == pytest.approx(around[1], abs=1e-6)
    depths = width * np.linspace(0.0, 1.2, 9)
    np.testing.assert_allclose(stress(33, depths), stress(99, depths), atol=2e-4)


def test_the_weight_of_averages_goes_from_the_surface_to_the_depth():
    weights = [averaging(depth) for depth in np.linspace(0.0, 4.0, 41)]
    assert weights[0] == pytest.approx(1.0 / 24.0, rel=1e-3) and weights[-1] == 1.0 / 12.0
    assert (np.diff(weights) >= 0.0).all()
