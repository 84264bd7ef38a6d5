"""Layered half-spaces against transfer matrices of sixty digits and direct quadratures."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from thermoroll_cli.physics.halfspace.elastic import ShearCompliance, coupling_tables, normal_table, shear_tables
from thermoroll_cli.physics.halfspace.layered import LayeredBody, difference_compliance, halfspace_compliance
from thermoroll_cli.problem.problem import Layer
from thermoroll_cli.tools.arrays import Array

REFERENCE = Path(__file__).parents[1] / "reference"
SYMBOLS, TABLES = (json.loads((REFERENCE / f"layered_{name}.json").read_text()) for name in ("symbols", "tables"))
STEEL = (210e9, 0.3)


def stack(row: dict) -> tuple[list[Layer], tuple[float, float]]:
    substrate = row["substrate"]
    return [Layer(**layer) for layer in row["layers"]], (substrate["youngs_modulus"], substrate["poisson_ratio"])


@dataclass(frozen=True)
class Tables:
    normal: Array
    xx: Array
    yy: Array
    xy: Array
    x_normal: Array
    y_normal: Array


def difference_tables(
    layers: list[Layer], substrate: tuple[float, float], shape: tuple[int, int], dx: float, dy: float
) -> Tables:
    body, place = LayeredBody(tuple(layers), substrate), (shape, dx, dy)
    return Tables(*body.tables("normal", *place), *body.tables("shear", *place), *body.tables("coupling", *place))


@pytest.mark.parametrize("row", SYMBOLS["rows"])
def test_symbols_agree_with_transfer_matrices(row: dict) -> None:
    layers, substrate = stack(row)
    difference = difference_compliance(layers, substrate, np.array([row["k"]]))
    top = halfspace_compliance(layers[0].youngs_modulus, layers[0].poisson_ratio)
    largest = 2.0 * 1.5 / min(substrate[0], *(layer.youngs_modulus for layer in layers))
    for name in ("tt", "tn", "nn", "ss"):
        found = float(getattr(top, name) + getattr(difference, name)[0])
        assert found == pytest.approx(row[f"kB_{name}"], abs=SYMBOLS["tolerance"] * largest)


@pytest.mark.parametrize("row", TABLES["rows"], ids=lambda row: f"{row['layers'][0]['thickness']}-{row['i']}-{row['j']}")
def test_tables_agree_with_direct_quadrature(row: dict) -> None:
    layers, substrate = stack(row)
    dx, dy, i, j = row["dx"], row["dy"], row["i"], row["j"]
    size = max(i, j, 4) + 1
    difference = difference_tables(layers, substrate, (size, size), dx, dy)
    modulus, ratio = layers[0].youngs_modulus, layers[0].poisson_ratio
    shear_modulus = 0.5 * modulus / (1.0 + ratio)
    normal = normal_table(size, size, dx, dy, modulus / (1.0 - ratio**2)) + difference.normal
    xx, yy, xy = shear_tables(size, size, dx, dy, ShearCompliance.of((shear_modulus, ratio)))
    x_normal = -(1.0 - 2.0 * ratio) / (4.0 * np.pi * shear_modulus) * coupling_tables(size, size, dx, dy)[0]
    found = {"uz_p": normal, "ux_qx": xx + difference.xx, "uy_qy": yy + difference.yy, "ux_qy": xy + difference.xy,
             "ux_p": x_normal + difference.x_normal}
    for name, table in found.items():
        assert table[i, j] == pytest.approx(row[name], abs=TABLES["tolerance_of_peak"] * normal[0, 0]), name


def test_a_layer_of_the_substrates_material_changes_nothing() -> None:
    found = difference_tables([Layer(1e-3, *STEEL), Layer(2e-3, *STEEL)], STEEL, (8, 6), 1e-4, 2e-4)
    peak = normal_table(8, 6, 1e-4, 2e-4, STEEL[0] / (1.0 - STEEL[1] ** 2))[0, 0]
    assert max(np.abs(table).max() for table in vars(found).values()) < 1e-14 * peak


@pytest.mark.parametrize(("thickness", "expected"), [(1e-9, STEEL), (1e3, (50e9, 0.2))])
def test_thin_and_thick_layers_are_half_spaces(thickness: float, expected: tuple[float, float]) -> None:
    """Of the substrate and of the layer. A thin layer's own self-compliance remains, of the order of its thickness."""
    layer = Layer(thickness, 50e9, 0.2)
    found = difference_tables([layer], STEEL, (6, 6), 1e-3, 1e-3).normal + normal_table(6, 6, 1e-3, 1e-3, 50e9 / (1.0 - 0.2**2))
    wanted = normal_table(6, 6, 1e-3, 1e-3, expected[0] / (1.0 - expected[1] ** 2))
    assert np.allclose(found, wanted, rtol=0.0, atol=1e-5 * wanted[0, 0])


def test_tables_along_both_axes_are_transposes() -> None:
    layers = [Layer(3e-4, 50e9, 0.2)]
    wide, tall = difference_tables(layers, STEEL, (7, 5), 1e-4, 3e-4), difference_tables(layers, STEEL, (5, 7), 3e-4, 1e-4)
    assert np.allclose(wide.x_normal, tall.y_normal.T, rtol=1e-9, atol=1e-18)
    assert np.allclose(wide.xx, tall.yy.T, rtol=1e-9, atol=1e-18) and np.allclose(wide.xy, tall.xy.T, rtol=1e-9, atol=1e-18)


@pytest.mark.parametrize("thickness", [1e-5, 1e-3])
def test_long_elements_are_sums_of_short_ones(thickness: float) -> None:
    layers, parts, columns, dx, dy = [Layer(thickness, 5e9, 0.4)], 21, 3, 1e-4, 1e-3
    long = difference_tables(layers, STEEL, (12, columns), dx, dy)
    short = difference_tables(layers, STEEL, (12, parts * columns), dx, dy / parts)
    for name, parity in (("normal", 1), ("xx", 1), ("yy", 1), ("xy", -1), ("x_normal", 1), ("y_normal", -1)):
        table = getattr(short, name)
        both, middle = np.concatenate([parity * table[:, :0:-1], table], axis=1), table.shape[1] - 1
        for j in range(columns):
            start = middle + j * parts - parts // 2
            found = both[:, start : start + parts].sum(axis=1)
            assert np.abs(found - getattr(long, name)[:, j]).max() < 1e-9 * abs(long.normal[0, 0]), name
