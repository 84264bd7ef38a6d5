"""Stresses below one loaded or heated element against independent quadratures, limits and exact theorems."""

from __future__ import annotations

from collections import defaultdict

import numpy as np
import pytest

from tests.support.sampling import sampled
from tests.support.scenes import reference
from thermoroll_cli.physics.halfspace import subsurface_thermal
from thermoroll_cli.physics.halfspace.subsurface_elastic import (
    EXCHANGED_AXES,
    pressure_stress,
    traction_x_stress,
    traction_y_stress,
)
from thermoroll_cli.physics.halfspace.subsurface_thermal import thermal_stress
from thermoroll_cli.physics.halfspace.thermal import temperature_at_depths, temperature_table

ELEMENTS = reference("subsurface_elements")
NU = 0.3
LOADS = {"p": pressure_stress, "tx": traction_x_stress, "ty": traction_y_stress}
X = np.arange(-2.0, 9.0)


def by_case():
    cases = defaultdict(list)
    for record in ELEMENTS["thermal"]:
        cases[record["b"], record["P"]].append(record)
    return sorted(cases.items())


def test_elastic_closed_forms():
    """Boussinesq's and Cerruti's integrals over an element, by quadrature to 5e-15: 120 values."""
    assert len(ELEMENTS["elastic"]) == 120
    for record in ELEMENTS["elastic"]:
        at = np.array([float(record["X"])]), np.array([float(record["Y"])]), record["z"], record["b"], NU
        np.testing.assert_allclose(LOADS[record["load"]](*at)[:, 0, 0], record["stress"], rtol=0.0, atol=1e-12)


@pytest.mark.parametrize(("steps", "share"), [({}, 1e-5), ({"OUTER_STEP": 0.22, "INNER_STEP": 0.32, "PASSING": 1.0}, 1e-8)],
                         ids=["usual", "exact"])
def test_thermal_stresses(steps, share, monkeypatch):
    """All 160 values, over the largest of their Péclet number, beyond what the reference itself leaves open."""
    for name, step in steps.items():
        monkeypatch.setattr(subsurface_thermal, name, step)
    seen = 0
    for (aspect, peclet), records in by_case():
        y, depths = aspect * np.arange(-2.0, 2.0), np.array(sorted({r["z"] for r in records}))
        stress = thermal_stress(X, y, depths, aspect, peclet, 0.0, NU)
        largest = max(np.abs(r["stress"]).max() for r in records)
        for record in records:
            i, j = round(record["X"]) + 2, round(record["Y"] / aspect) + 2
            got = stress[list(depths).index(record["z"]), :, i, j]
            np.testing.assert_allclose(got, record["stress"], rtol=0.0, atol=share * largest + record["uncertainty"])
            seen += 1
    assert seen == 160


def test_temperature_below():
    for (aspect, peclet), records in by_case():
        for record in records:
            at = np.array([float(record["X"])]), np.array([float(record["Y"])])
            got = temperature_at_depths(*at, np.array([record["z"]]), aspect, peclet)
            assert abs(got[0, 0, 0] - record["temperature"]) < 2e-11 + record["uncertainty"]


def test_the_surface_is_the_surface():
    """At depth 0 the table is the one that the solver uses, and heat leaves the surface free of traction."""
    table = temperature_table(9, 9, 0.7, 3.0, 0.2)
    y = 0.7 * np.arange(-8.0, 9.0)
    below = temperature_at_depths(np.arange(-8.0, 9.0), y, np.zeros(1), 0.7, 3.0, 0.2)[0]
    np.testing.assert_array_equal(below, table)
    assert np.abs(thermal_stress(X, y, np.zeros(1), 0.7, 3.0, 0.2, NU)[0, [2, 4, 5]]).max() < 1e-14


def test_heat_without_motion_leaves_planes_free():
    """Sternberg and McDowell: steady heat at rest makes no stress on any plane parallel to the surface; slow motion, little."""
    y, depths = 2.5 * np.arange(-2.0, 3.0), np.array([0.0, 0.4, 3.0])
    still = thermal_stress(X, y, depths, 2.5, 0.0, 0.0, NU)
    assert np.abs(still[:, [2, 4, 5]]).max() == 0.0
    slow = [np.abs(thermal_stress(X, y, depths, 2.5, peclet, 0.0, NU) - still).max() for peclet in (1e-4, 1e-5)]
    assert slow[0] < 1e-3
    assert slow[1] == pytest.approx(slow[0] / 10.0, rel=0.05)


@pytest.mark.parametrize(("peclet", "ratio"), [(1e2, -0.881), (1e3, -0.965), (1e4, -0.989)])
def test_fast_sources_heat_a_skin(peclet, ratio):
    """With P → ∞ the skin is held by the cold body: σ_xx → −EαT/(1−ν), slowly."""
    at = np.array([0.25]), np.zeros(1), np.zeros(1), 1.0, peclet, 0.0
    assert thermal_stress(*at, NU)[0, 0, 0, 0] / temperature_at_depths(*at)[0, 0, 0] == pytest.approx(ratio, abs=6e-4)


@pytest.mark.parametrize("peclet", sampled([3.0, 0.1, 20.0], 3))
def test_oblique_motion(peclet):
    """Motion along the diagonal is its mirror image in it, although the rules treat both axes differently."""
    across = np.arange(-4.0, 5.0)
    stress = thermal_stress(across, across, np.array([0.0, 0.3, 2.0]), 1.0, peclet, peclet, NU)
    mirrored = stress.transpose(0, 1, 3, 2)[:, list(EXCHANGED_AXES)]
    np.testing.assert_allclose(stress, mirrored, rtol=0.0, atol=1e-7 * np.abs(stress).max())


def test_direction_of_motion():
    """Reversed motion is the mirror image; motion along y that along x with the axes exchanged."""
    x, y, z = np.arange(-3.0, 4.0), 1.6 * np.arange(-3.0, 4.0), np.array([0.0, 0.5])
    stress = thermal_stress(x, y, z, 1.6, 2.0, 0.3, NU)
    back = thermal_stress(x, y, z, 1.6, -2.0, 0.3, NU)[:, :, ::-1] * np.array([1, 1, 1, -1, -1, 1])[:, None, None]
    np.testing.assert_array_equal(stress, back)
    turned = thermal_stress(y / 1.6, x / 1.6, z / 1.6, 1.0 / 1.6, 0.3 * 1.6, 2.0 * 1.6, NU)
    np.testing.assert_allclose(stress, 1.6 * turned.transpose(0, 1, 3, 2)[:, list(EXCHANGED_AXES)], rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("aspect", [0.4, 2.5])
def test_whole_planes_carry_what_is_put_on_them(aspect):
    """Equal elements side by side make a uniform pressure: σ_zz = −p, and σ_xx, σ_yy of uniaxial compression at the middle."""
    x, y = np.arange(-400.0, 401.0), aspect * np.arange(-400.0, 401.0)
    total = pressure_stress(x, y, 1.0, aspect, NU).sum(axis=(1, 2))
    assert total[2] == pytest.approx(-1.0, abs=1e-4)
    assert np.abs(total[3:]).max() < 1e-10
