"""The leading edge, on which hangs how close rolling forces and heat come to those of fine grids."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.support.scenes import elastic, ellipse, reference_problem, rolling
from thermoroll_cli.exact.hertz import hertz_contact, shear_gradients
from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.one_contact.steady_state.discretisation import Discretisation
from thermoroll_cli.one_contact.steady_state.traction import Window
from thermoroll_cli.physics.halfspace.bodies import Bodies
from thermoroll_cli.physics.halfspace.elastic import ShearCompliance
from thermoroll_cli.physics.rolling.element_borders import block_product, continued_gradient, edge_compliance, known_gradient
from thermoroll_cli.physics.rolling.rolling_gradient import RollingGradient
from thermoroll_cli.problem.contact import Traction

NU, G = 0.28, 80e9


# --- tractions shaped like the pressure ---------------------------------------------------------------------------


def test_shear_gradients_of_a_circle_are_cattaneos():
    hertz = hertz_contact(20.0, 20.0, 1e11, 50.0)
    c = ShearCompliance.of((G, NU), (G, NU))
    scale = 2.0 * math.pi * hertz.peak_pressure / (32.0 * G * hertz.semi_axis_x)  # of both bodies
    expected = [-2.0 * (4.0 - 3.0 * NU) * scale, -2.0 * (4.0 - NU) * scale, 2.0 * NU * scale]
    assert shear_gradients(hertz, c.isotropic, c.directional) == pytest.approx(expected, rel=1e-12)


def box_of(aspect: float, n: int) -> tuple[Discretisation, Window, RollingGradient]:
    discretisation = Discretisation(DerivedQuantities(rolling(grid=n, geometry=ellipse(aspect), body=elastic(NU))), (n, n), 2.2)
    box = discretisation.traction.window_around(discretisation.isothermal_pressure.contact, None)
    return discretisation, box, discretisation.traction.solver_of(box).gradient


@pytest.mark.parametrize("aspect", [0.1, 0.5, 3.0, 10.0])
def test_shear_gradients_of_an_ellipse_are_the_operators(aspect):
    """Away from the border, to the error of the difference formula."""
    discretisation, box, gradient = box_of(aspect, 128)
    hertz, c = discretisation.derived.hertz, discretisation.derived.bodies.shear
    x, y = np.broadcast_arrays(discretisation.grid.x[box.rows][:, None], discretisation.grid.y[box.columns])
    inside = np.hypot(x / hertz.semi_axis_x, y / hertz.semi_axis_y) < 0.7
    found = gradient.of_shape(box.cut(discretisation.isothermal_pressure.pressure))
    for values, slope, arm in zip(found, shear_gradients(hertz, c.isotropic, c.directional), (x, x, y), strict=True):
        assert np.abs(values - slope * arm)[inside].max() < 3e-3 * np.abs(slope * arm).max()


def test_of_shape_is_the_operator_on_both_directions():
    gradient = RollingGradient((20, 26), 1.0, 0.7, Bodies.of_shear(ShearCompliance.of((1.0, 0.3), (2.0, 0.1))))
    shape = np.random.default_rng(2).uniform(size=(20, 26))
    along, across = gradient(np.stack([shape, 0.0 * shape])), gradient(np.stack([0.0 * shape, shape]))
    xx, yy, xy = gradient.of_shape(shape)
    for found, expected in ((xx, along[0]), (yy, across[1]), (xy, along[1]), (xy, across[0])):
        np.testing.assert_allclose(found, expected, atol=1e-13 * np.abs(along).max())


# --- the leading edge -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("aspect", [0.5, 1.0])
def test_operator_with_leading_edge_knows_pressure_shaped_tractions(aspect):
    """(D A + E) τ is exact at the leading edge for τ = p c, whatever the direction of c, slivers apart."""
    discretisation, box, gradient = box_of(aspect, 48)
    normal, grid, c = discretisation.isothermal_pressure, discretisation.grid, discretisation.derived.bodies.shear
    pressure, covered = box.cut(normal.pressure), box.cut(normal.covered)
    leading = discretisation.traction.leading(discretisation.derived, normal, box, undisturbed=True)
    border = edge_compliance(covered, np.where(covered > 0.0, pressure, 0.0), gradient, leading)
    direction = np.array([0.6, -0.8])
    traction = direction[:, None, None] * pressure
    found = gradient(traction) + block_product(border.k, traction)
    along, across, mixed = shear_gradients(discretisation.derived.hertz, c.isotropic, c.directional)
    x, y = np.broadcast_arrays(grid.x[box.rows][:, None], grid.y[box.columns])
    exact = np.stack([along * x * 0.6 - mixed * y * 0.8, mixed * y * 0.6 - across * x * 0.8])
    ring = leading.any(axis=0) & (pressure > 0.01 * pressure.max())
    assert ring.sum() > 60
    np.testing.assert_allclose(found[:, ring], exact[:, ring], atol=1e-12 * np.abs(exact).max())


def test_leading_edge_is_the_leading_half_and_mirror_symmetric():
    discretisation, box, _ = box_of(1.0, 64)
    hertz = discretisation.isothermal_pressure
    xx, yy, xy = discretisation.traction.leading(discretisation.derived, hertz, box, undisturbed=True)
    half = xx.shape[0] // 2
    assert xx[:half].any() and not np.stack([xx, yy, xy])[:, half:].any()
    scale = 1e-9 * np.abs(xx).max()
    np.testing.assert_allclose(xx, xx[:, ::-1], atol=scale)
    np.testing.assert_allclose(yy, yy[:, ::-1], atol=scale)
    np.testing.assert_allclose(xy, -xy[:, ::-1], atol=scale)


def test_leading_edge_from_the_gap_is_that_of_the_closed_form():
    """Below other than Hertz pressures only ∬p/r is known: for Hertz's own pressure the two agree to a few per cent, since
    border elements vary along the border, too."""
    discretisation, box, gradient = box_of(1.0, 64)
    normal, c = discretisation.isothermal_pressure, discretisation.derived.bodies.shear
    pressure, covered = box.cut(normal.pressure), box.cut(normal.covered)
    exact = discretisation.traction.leading(discretisation.derived, normal, box, undisturbed=True)
    x = np.broadcast_to(discretisation.grid.x[box.rows][:, None], pressure.shape)
    isotropic = -math.pi * discretisation.derived.problem.contact_modulus * discretisation.derived.hertz.curvature_x * x
    found = gradient.of_shape(pressure)
    continued = continued_gradient(pressure, found, isotropic, discretisation.grid.dx, discretisation.grid.dy, c)
    near = known_gradient(pressure, found, continued, covered)
    weight = pressure  # what counts is the gradient that it makes
    for a, b in zip(exact, near, strict=True):
        assert np.linalg.norm((a - b) * weight) < 0.1 * np.linalg.norm(exact[0] * weight)


def test_pressed_contact_rolls_like_hertz():
    """The same contact, its pressure solved for as with thermal deformation: forces within 1e-4 μW."""
    discretisation = Discretisation(DerivedQuantities(reference_problem("article_3_1_case_3", 64)), (64, 64), 2.2)
    hertz, start = discretisation.isothermal_pressure, Traction.unknown((64, 64))
    pressed = discretisation.press(np.zeros(discretisation.grid.shape), hertz, 1e-9)
    forces = [discretisation.roll(normal, start, 1e-5).traction.sum(axis=(1, 2)) * discretisation.grid.element_area
              for normal in (hertz, pressed)]
    assert np.abs(forces[1] - forces[0]).max() < 1e-4 * discretisation.derived.problem.traction_limit
