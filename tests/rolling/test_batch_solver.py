"""Many creepages at once: the same tractions as one by one, for less work of Python."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.support.scenes import elastic, ellipse, rolling
from thermoroll_cli.creep_table.point_solver import EllipseSolver
from thermoroll_cli.halfspace.elastic import ShearCompliance
from thermoroll_cli.numerics.krylov import batch_gmres
from thermoroll_cli.problem.problem import Motion
from thermoroll_cli.refinement.solve import Solver
from thermoroll_cli.rolling.batch_solver import BatchGradient, BatchInverse
from thermoroll_cli.rolling.rolling_gradient import RollingGradient
from thermoroll_cli.rolling.stick_inverse import StickInverse, run_starts

RNG = np.random.default_rng(3)


@pytest.mark.parametrize("poisson_ratio", [0.0, 0.28])
def test_matrices_are_the_operators_of_one_point(poisson_ratio: float) -> None:
    compliance = compliance_of(poisson_ratio)
    shape, dx, dy = (9, 12), 1e-4, 0.7e-4
    tractions = RNG.normal(size=(3, 2, *shape))
    gradient, batch = RollingGradient(shape, dx, dy, compliance), BatchGradient(shape, dx, dy, compliance)
    for one, other in zip(tractions, batch(tractions), strict=True):
        np.testing.assert_allclose(other, gradient(one), rtol=1e-11, atol=1e-13 * np.abs(other).max())
    assert batch.applications == gradient.applications == 3
    mask = RNG.random((3, *shape)) < 0.8
    inverse, batch_inverse = StickInverse(shape, dx, dy, compliance), BatchInverse(shape, dx, dy, compliance)
    inside = tractions * mask[:, None]
    found = batch_inverse(inside, mask[:, None].astype(float), run_starts(mask)[:, None] // shape[1])
    for one, own, other in zip(inside, mask, found, strict=True):
        np.testing.assert_allclose(other, inverse(one, own, run_starts(own)), rtol=1e-9, atol=1e-11 * np.abs(other).max())


@pytest.mark.parametrize("symmetric", [True, False])
def test_matrices_of_a_contact_are_the_same_inside_it(symmetric: bool) -> None:
    shape, dx, dy = (9, 12), 1e-4, 0.7e-4
    contact = np.hypot(*np.meshgrid(np.linspace(-1, 1, 9), np.linspace(-1, 1, 12), indexing="ij")) < 1.0
    contact[4, 0] |= not symmetric
    tractions = np.random.default_rng(4).normal(size=(3, 2, *shape)) * contact
    compliance = compliance_of(0.28)
    whole, part = BatchGradient(shape, dx, dy, compliance), BatchGradient(shape, dx, dy, compliance, contact=contact)
    wanted = whole(tractions)
    np.testing.assert_allclose(part(tractions) * contact, wanted * contact, rtol=1e-11, atol=1e-13 * np.abs(wanted).max())
    sides = [len(operator._apply._matrices[np.dtype(float)][0]) for operator in (whole, part)]
    assert sides == [9 * 12, int(contact.sum()) if symmetric else 9 * 12]


def compliance_of(poisson_ratio: float) -> ShearCompliance:
    return ShearCompliance.of((8e10, poisson_ratio), (8e10, poisson_ratio))


def test_krylov_solves_every_system_to_its_own_tolerance() -> None:
    count, size = 7, 30
    matrices = np.eye(size) + 0.3 * RNG.normal(size=(count, size, size)) / np.sqrt(size)
    right = RNG.normal(size=(count, size))
    right[4] = 0.0
    wanted = 10.0 ** -np.linspace(1, 8, count)

    def cheap(who: np.ndarray, vectors: np.ndarray, images: np.ndarray) -> np.ndarray:
        assert len(who) == len(vectors)
        return np.einsum("bij,bj->bi", matrices[who], vectors) + 0.5 * images

    step, image = batch_gmres(lambda v: 0.2 * v, cheap, lambda who, v: v, right, wanted, 40)
    np.testing.assert_allclose(image, 0.2 * step)
    left = np.linalg.norm(np.einsum("bij,bj->bi", matrices, step) + 0.1 * step - right, axis=1)
    assert (left <= 1.001 * wanted * np.linalg.norm(right, axis=1)).all()
    assert (left[wanted > 1e-3] > 1e-6).any(), "solved no further than asked for"


@pytest.mark.parametrize("aspect_ratio", [0.2, 3.0])
def test_forces_are_those_of_single_runs(aspect_ratio: float) -> None:
    """On the same grid, to a hundredth of the discretisation error."""
    solver = EllipseSolver(aspect_ratio, 0.28, accuracy=4e-3)
    grid = solver._grids[1]
    creepages = RNG.uniform([[0.0], [0.0], [-1.0]], [[1.0], [1.0], [1.0]], (3, 6)) / np.array(solver.scales)[:, None]
    creepages *= np.array([0.2, 0.5, 1.0, 2.0, 5.0, 30.0])
    values, converged, _ = grid.solve(creepages)
    assert converged.all()
    base = rolling(grid=grid.grid.shape, geometry=ellipse(aspect_ratio), body=elastic(0.28), load=100.0)
    limit, single = base.traction_limit, Solver()
    hertz = single.solve(base).hertz
    a, b = hertz["hertz_a_mm"] * 1e-3, hertz["hertz_b_mm"] * 1e-3
    unit = limit / (base.lower.shear_modulus * a * b)
    for (x, y, z), (force_x, force_y, _, stick) in zip(creepages.T, values.T, strict=True):
        motion = Motion(1.0, x * unit, y * unit, z * unit / np.sqrt(a * b), differential_slip=False)
        result = single.solve(replace(base, motion=motion))
        shear = np.array([result.isothermal.fields["shear_x"], result.isothermal.fields["shear_y"]])
        total = shear.sum(axis=(1, 2)) * (result.x[1] - result.x[0]) * (result.y[1] - result.y[0]) / limit
        np.testing.assert_allclose((force_x, force_y), total, atol=2e-5)
        assert stick == pytest.approx(result.isothermal.scalars["gamma_st"], abs=2e-3)
