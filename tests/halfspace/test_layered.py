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
