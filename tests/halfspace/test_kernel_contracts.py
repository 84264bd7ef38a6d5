"""What every table of influence keeps: nine elements are one, mirror images, exchanged axes, layers that make no difference.

A kernel is a function of a body, the numbers and sizes of elements (m) and the speed (m/s) at which the body passes; it gives
the response around one loaded element at offsets of both signs, (2nx − 1, 2ny − 1) per name, in SI units. The values themselves
are held against quadratures in the other files of this folder."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np
import pytest

from thermoroll_cli.physics.halfspace.elastic import ShearCompliance, coupling_tables, normal_table, shear_tables
from thermoroll_cli.physics.halfspace.layered import LayeredBody
from thermoroll_cli.physics.halfspace.layered_stress import element_stresses
from thermoroll_cli.physics.halfspace.layered_thermal import LayeredHeat
from thermoroll_cli.physics.halfspace.subsurface_elastic import pressure_stress, traction_x_stress, traction_y_stress
from thermoroll_cli.physics.halfspace.thermal import displacement_table, temperature_slope_table, temperature_table
from thermoroll_cli.problem.problem import Layer, Material

Tables = dict[str, np.ndarray]
Kernel = Callable[[Material, tuple[int, int], tuple[float, float], tuple[float, float]], Tables]
STEEL = Material(210e9, 0.3, 46.0, 11.8e-6, 12.5e-6)
SOFT = Material(50e9, 0.2, 1.5, 2.3e-6, 0.7e-6)
PARITIES = {"zz": (1, 1), "xx": (1, 1), "yy": (1, 1), "xy": (-1, -1), "xz": (-1, 1), "yz": (1, -1)}
"""Of the table of each name where x or y change their signs: of what is vertical, along x or y, under loads likewise."""


def coated(*thicknesses: float, by: Material = SOFT) -> Material:
    """Steel below layers of another material."""
    return replace(STEEL, layers=tuple(Layer(thickness, **{
        name: value for name, value in vars(by).items() if name in Layer.__dataclass_fields__}) for thickness in thicknesses))


def whole(quadrant: np.ndarray, parity: tuple[int, int]) -> np.ndarray:
    """A table at offsets of both signs from that at offsets ≥ 0."""
    half = np.concatenate([parity[0] * quadrant[:0:-1], quadrant])
    return np.concatenate([parity[1] * half[:, :0:-1], half], axis=1)


def surface(body: Material, shape: tuple[int, int], sizes: tuple[float, float], _: tuple[float, float]) -> Tables:
    """Displacements of the surface under pressure and shear, and those along it under pressure."""
    top, place = body.surface, (*shape, *sizes)
    constant = -(1.0 - 2.0 * top.poisson_ratio) / (4.0 * math.pi * top.shear_modulus)
    tables = [normal_table(*place, top.plane_strain_modulus),
              *shear_tables(*place, ShearCompliance.of((top.shear_modulus, top.poisson_ratio))),
              *(constant * table for table in coupling_tables(*place))]
    if body.layers:
        below = LayeredBody.of(body)
        more = (table for kind in ("normal", "shear", "coupling") for table in below.tables(kind, shape, *sizes))
        tables = [own + other for own, other in zip(tables, more, strict=True)]
    return {name: whole(table, PARITIES[name]) for name, table in zip(PARITIES, tables, strict=True)}


def heat(body: Material, shape: tuple[int, int], sizes: tuple[float, float], speed: tuple[float, float]) -> Tables:
    """Temperature under a uniform flux and under one that changes along the element, and the expansion."""
    top = body.layers[0] if body.layers else body
    place = (*shape, sizes[1] / sizes[0], *(v * sizes[0] / top.diffusivity for v in speed))
    unit = sizes[0] / top.conductivity
    tables = {"temperature": unit * temperature_table(*place), "slope": unit * temperature_slope_table(*place),
              "expansion": unit * sizes[0] * (1.0 + top.poisson_ratio) * top.expansion * displacement_table(*place)}
    if body.layers:
        layers = LayeredHeat(body)
        for name in tables:
            quantity = "expansion" if name == "expansion" else "temperature"
            tables[name] = tables[name] + layers.table(quantity, shape, sizes, speed, slope=name == "slope")
    if speed == (0.0, 0.0):  # known up to a constant
        tables["expansion"] = tables["expansion"] - tables["expansion"][shape[0] - 1, shape[1] - 1]
    return tables


def stress(depth: float, body: Material, shape: tuple[int, int], sizes: tuple[float, float], _: tuple[float, float]) -> Tables:
    """Six stresses at a depth under pressure (z) and tractions along x and y."""
    if body.layers:
        loads = element_stresses(LayeredBody.of(body), shape, *sizes, depth)
    else:
        at = (np.arange(float(shape[0])), np.arange(float(shape[1])) * (sizes[1] / sizes[0]), depth / sizes[0],
              sizes[1] / sizes[0], body.poisson_ratio)
        loads = [pressure_stress(*at), traction_x_stress(*at), traction_y_stress(*at)]
    tables = {}
    for load, own, stresses in zip("zxy", ((1, 1), (-1, 1), (1, -1)), loads, strict=True):
        for name, table in zip(("xx", "yy", "zz", "xy", "xz", "yz"), stresses, strict=True):
            tables[f"{load} {name}"] = whole(table, tuple(a * b for a, b in zip(own, PARITIES[name], strict=True)))
    return tables


class Row(NamedTuple):
    """A kernel under a speed, the size of its elements, and how closely sums of elements are one, over its largest value,
    without and with layers."""

    kernel: Kernel
    speed: tuple[float, float] = (0.0, 0.0)
    size: float = 1e-4
    within: float = 1e-13
    layered: float = 1e-11


def peclet(x: float, y: float = 0.0) -> tuple[float, float]:
    """The speed at which steel passes an element of 10 µm in that Péclet number."""
    return x * STEEL.diffusivity / 1e-5, y * STEEL.diffusivity / 1e-5


ROWS = {
    "surface": Row(surface),
    "stresses at the surface": Row(partial(stress, 0.0)),
    "stresses at an interface": Row(partial(stress, 0.1 * 1e-4)),
    "stresses in a layer": Row(partial(stress, 5e-5)),
    "stresses below": Row(partial(stress, 1.5e-4)),
    "heat at rest": Row(heat, size=1e-5),
    "heat, P = 500": Row(heat, peclet(500.0), 1e-5, 3e-10, 1e-8),
    # Oblique motion: layers are known less closely.
    "heat, P = 4 and 0.02": Row(heat, peclet(4.0, 0.02), 1e-5, 1e-10, 1e-3),
}
BODIES = {"half-space": STEEL, "two layers": coated(2e-5, 3e-4)}


def assert_alike(found: Tables, expected: Tables, within: float) -> None:
    """Beside the largest value of the same load."""
    assert found.keys() == expected.keys()
    for name, table in expected.items():
        scale = max(np.abs(other).max() for key, other in expected.items() if key == name or (" " in key and key[0] == name[0]))
        scale = scale or max(np.abs(other).max() for other in expected.values())
        assert np.abs(found[name] - table).max() <= within * scale, name


@pytest.mark.parametrize(("row", "body"), [
    pytest.param(row, body, id=f"{name}-{of}", marks=pytest.mark.slow if "heat" in name and body.layers else ())
    for name, row in ROWS.items() for of, body in BODIES.items()])  # fmt: skip
def test_nine_elements_make_one(row: Row, body: Material) -> None:
    """An element of three times the size in both directions, all signs of offsets included."""
    (nx, ny), (dx, dy) = (4, 3), (row.size, 1.7 * row.size)
    coarse = row.kernel(body, (nx, ny), (3.0 * dx, 3.0 * dy), row.speed)
    fine = row.kernel(body, (3 * nx, 3 * ny), (dx, dy), row.speed)
    sums = {name: table[1:-1, 1:-1].reshape(2 * nx - 1, 3, 2 * ny - 1, 3).sum(axis=(1, 3)) for name, table in fine.items()}
    for tables in (coarse, sums):
        tables.pop("slope", None)  # not that of nine slopes
        if "expansion" in tables and row.speed == (0.0, 0.0):
            tables["expansion"] -= tables["expansion"][nx - 1, ny - 1]
    assert_alike(sums, coarse, row.layered if body.layers else row.within)


@pytest.mark.parametrize("body", BODIES.values(), ids=BODIES)
@pytest.mark.parametrize("row", ROWS.values(), ids=ROWS)
def test_exchanged_axes(row: Row, body: Material) -> None:
    """x for y: of elements, motion, loads and responses."""
    dx, dy = row.size, 0.4 * row.size
    table = row.kernel(body, (3, 2), (dx, dy), row.speed)
    other = row.kernel(body, (2, 3), (dy, dx), row.speed[::-1])
    back = str.maketrans("xy", "yx")
    names = {name: name if name in ("temperature", "slope", "expansion") else name.translate(back).replace("yx", "xy")
             for name in table}
    exchanged = {name: other[names[name]].T for name in table}
    for tables in (table, exchanged):
        tables.pop("slope", None)  # along x
    assert_alike(exchanged, table, 1e-13)


@pytest.mark.parametrize("body", BODIES.values(), ids=BODIES)
@pytest.mark.parametrize("row", [pytest.param(row, id=name) for name, row in ROWS.items() if any(row.speed)])
def test_reversed_motion_is_the_mirror_image(row: Row, body: Material) -> None:
    place = (3, 2), (row.size, 0.4 * row.size)
    table, (x, y) = row.kernel(body, *place, row.speed), row.speed
    for speed, flipped in (((-x, y), np.s_[::-1]), ((x, -y), np.s_[:, ::-1])):
        mirrored = {name: other[flipped] for name, other in row.kernel(body, *place, speed).items()}
        if speed[0] != x:
            mirrored["slope"] = -mirrored["slope"]
        assert_alike(mirrored, table, 1e-15)


@pytest.mark.parametrize("row", [
    pytest.param(row, id=name, marks=pytest.mark.slow if "heat" in name else ())
    for name, row in ROWS.items() if "500" not in name])  # fmt: skip
def test_layers_that_make_no_difference(row: Row) -> None:
    """Of the body's own material; so thin or so thick that one of both materials is alone; one cut in two."""
    def kernel(body: Material) -> Tables:
        return row.kernel(body, (3, 2), (row.size, 1.4 * row.size), row.speed)

    assert_alike(kernel(coated(0.1 * row.size, row.size, by=STEEL)), kernel(STEEL), 1e-12)
    if row is not ROWS["stresses at the surface"]:  # which are those of any coating, though it is thin
        assert_alike(kernel(coated(1e-9 * row.size)), kernel(STEEL), max(1e-6, row.layered))
    assert_alike(kernel(coated(1e6 * row.size)), kernel(SOFT), 1e-6)
    assert_alike(kernel(coated(row.size, 2.0 * row.size)), kernel(coated(3.0 * row.size)), 1e-12)
