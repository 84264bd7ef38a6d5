"""Stresses inside layered half-spaces: against independent Hankel quadratures, closed forms, continuity at interfaces."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy.special import j0, j1, jn

from tests.support.interpolation import at_point
from tests.support.sampling import sampled
from thermoroll_cli.exact.hertz import HertzContact, element_averages
from thermoroll_cli.physics.halfspace import subsurface_elastic
from thermoroll_cli.physics.halfspace.layered import LayeredBody
from thermoroll_cli.physics.halfspace.layered_stress import element_stresses, waves_along
from thermoroll_cli.physics.numerics.grid import Grid
from thermoroll_cli.physics.stress.superposition import ElasticStresses, StressTransforms
from thermoroll_cli.problem.problem import Layer
from thermoroll_cli.tools.arrays import Array

REFERENCE = json.loads((Path(__file__).parents[1] / "reference" / "layered_stress.json").read_text())
STEEL = (210e9, 0.3)


def body_of(row: dict) -> LayeredBody:
    substrate = row["substrate"]
    return LayeredBody(tuple(Layer(**layer) for layer in row["layers"]),
                       (substrate["youngs_modulus"], substrate["poisson_ratio"]))


def depth_of(row: dict) -> float:
    """The next larger number below an interface."""
    return float(np.nextafter(row["z"], np.inf)) if row["side"] == "below" and row["z"] in body_of(row).interfaces else row["z"]


def all_tables(body: LayeredBody, shape: tuple[int, int], dx: float, dy: float, depth: float) -> Array:
    """Under pressure, traction along x, traction along y: (3, 6, nx, ny)."""
    return np.stack(element_stresses(body, shape, dx, dy, depth))


def closed_forms(ratio: float, shape: tuple[int, int], dx: float, dy: float, depth: float) -> Array:
    at = np.arange(float(shape[0])), np.arange(float(shape[1])) * (dy / dx), depth / dx, dy / dx, ratio
    return np.stack([table(*at) for table in (subsurface_elastic.pressure_stress, subsurface_elastic.traction_x_stress,
                                              subsurface_elastic.traction_y_stress)])


@cache
def nodes() -> tuple[Array, Array]:
    """Wave numbers and weights of quadratures."""
    x, w = np.polynomial.legendre.leggauss(40)
    edges = np.concatenate([[1e-9, 0.01, 0.03, 0.1, 0.3], np.arange(0.6, 260.0, 0.6)])
    half, middle = 0.5 * np.diff(edges)[:, None], 0.5 * (edges[1:] + edges[:-1])[:, None]
    return (middle + half * x).ravel(), (half * w).ravel()


@pytest.mark.parametrize("row", sampled(REFERENCE["rows"][::5], 3),
                         ids=lambda row: f"{row['load']}-{row['z']}-{row['side']}-{row['r']}")
def test_waves_agree_with_independent_stresses(row: dict) -> None:
    """Circular loads on one and several layers, to the tolerance of the data."""
    k, weights = nodes()
    body, z, r, a = body_of(row), depth_of(row), row["r"], row["radius"]
    mean, difference, zz, kz = (-part[:, 1] for part in waves_along(body, k, z))
    if z <= body.layers[0].thickness:
        # Boussinesq's half-space of the uppermost layer (Johnson 3.2), in waves.
        ratio, decay = body.layers[0].poisson_ratio, np.exp(-k * z)
        along, across = -(1.0 - k * z) * decay, -2.0 * ratio * decay
        mean, difference = mean + 0.5 * (along + across), difference + 0.5 * (along - across)
        zz, kz = zz - (1.0 + k * z) * decay, kz + k * z * decay
    load = a * j1(k * a) / k if row["load"] == "uniform" else (np.sin(k * a) - k * a * np.cos(k * a)) / (k**3 * a)
    load = load * k * weights
    total, turned = (load * mean * j0(k * r)).sum(), (load * difference * jn(2, k * r)).sum()
    found = {"zz": (load * zz * j0(k * r)).sum(), "rr": total - turned, "tt": total + turned,
             "rz": -(load * kz * j1(k * r)).sum()}
    assert found == pytest.approx({name: row[name] for name in found}, abs=REFERENCE["tolerance"])


STACKS = (
    LayeredBody((Layer(2e-4, 1000e9, 0.2),), STEEL), LayeredBody((Layer(5e-5, 3e9, 0.5), Layer(2e-4, 70e9, 0.1)), STEEL),
    LayeredBody((Layer(2e-6, 250e9, 0.2), Layer(5e-7, 280e9, 0.21)), STEEL))  # fmt: skip


@pytest.mark.parametrize("body", STACKS, ids=["stiff", "soft", "thin"])
def test_strains_and_tractions_are_continuous_at_interfaces(body: LayeredBody) -> None:
    """σ_zz, σ_xz, σ_yz and the strains ε_xx, ε_yy, ε_xy, under all three loads; the other stresses jump."""
    materials = [(layer.youngs_modulus, layer.poisson_ratio) for layer in body.layers] + [body.substrate]
    for number, face in enumerate(body.interfaces):
        sides = []
        for (modulus, ratio), depth in zip(materials[number:], (face, float(np.nextafter(face, np.inf))), strict=False):
            xx, yy, zz, xy, xz, yz = all_tables(body, (9, 7), 1e-4, 2e-4, depth).swapaxes(0, 1)
            strains = [xx - ratio * (yy + zz), yy - ratio * (xx + zz), (1.0 + ratio) * xy]
            sides.append((np.stack([zz, xz, yz]), np.stack(strains) / modulus, xx))
        for above, below in zip(*(side[:2] for side in sides), strict=True):
            assert np.abs(above - below).max() < 1e-9 * np.abs(above).max()
        assert np.abs(sides[0][2] - sides[1][2]).max() > 0.01 * np.abs(sides[0][2]).max()


@pytest.mark.parametrize("body", STACKS, ids=["stiff", "soft", "thin"])
def test_the_surface_carries_the_load(body: LayeredBody) -> None:
    tables = all_tables(body, (6, 9), 2e-4, 1e-4, 0.0)
    inside = np.zeros((6, 9))
    inside[0, 0] = -1.0
    for load, carried in enumerate((2, 4, 5)):
        for component in (2, 4, 5):
            assert np.allclose(tables[load, component], inside if component == carried else 0.0, rtol=0.0, atol=1e-10)


def largest_error(row_stack: list, elements: int) -> float:
    """Largest error of the stresses below hemispherical pressures, in p₀."""
    grid = Grid.over((elements, elements), 2.2, 2.2)
    edges, worst = (np.arange(elements + 1) - 0.5 * elements) * grid.dx, 0.0
    load = element_averages(HertzContact(*8 * (1.0,)), edges, edges)[0]
    transforms = StressTransforms(grid, mirrored=False)
    for row in row_stack:
        body = body_of(row)
        layers = ElasticStresses(transforms, load, None, body.layers[0].poisson_ratio, body)
        stress = layers.at(depth_of(row))[0]
        got = [at_point(stress[component], (grid.x, grid.y), (row["r"], 0.0)) for component in (0, 1, 2, 4)]
        worst = max(worst, np.abs(np.subtract(got, [row[name] for name in ("rr", "tt", "zz", "rz")])).max())
    return worst


@pytest.mark.slow
def test_stresses_of_pressures_converge_to_exact_ones() -> None:
    rows = [row for row in REFERENCE["rows"] if row["load"] != "uniform" and row["r"] <= 1.0]
    assert len(rows) >= 20
    errors = [largest_error(rows, elements) for elements in (24, 48, 96)]
    assert (np.log2(np.divide(errors[:-1], errors[1:])) > 2.5).all()
    assert errors[2] < 2e-4
