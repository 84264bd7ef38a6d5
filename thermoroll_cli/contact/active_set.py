"""Frictionless normal contact: primal–dual active set with preconditioned conjugate gradients (Eqs. 1–6)."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from thermoroll_cli.arrays import Array, Mask
from thermoroll_cli.contact.contact_border import border_elements
from thermoroll_cli.halfspace.elastic import normal_table
from thermoroll_cli.numerics.convolution import Convolution, even_length, multiply, periodic_symbol
from thermoroll_cli.numerics.fftw import fftw
from thermoroll_cli.numerics.grid import Grid
from thermoroll_cli.numerics.solver_options import NormalOptions


@dataclass(frozen=True)
class NormalSolution:
    """`pressure` in Pa and `gap`, `displacement` in m on the grid; `approach` in m; `residual` is the rms of the remaining
    gap on the contact over the approach; `touches_rim` tells that the contact reaches the edge of the domain."""

    pressure: Array
    displacement: Array
    gap: Array
    approach: float
    contact: Mask
    residual: float
    iterations: int
    applications: int
    converged: bool
    touches_rim: bool
    history: tuple[float, ...] = field(default=())


@dataclass(frozen=True)
class _Iterate:
    pressure: Array
    displacement: Array
    approach: float
    error: float
    scale: float
    iterations: int
    history: list[float]


@dataclass(frozen=True)
class RefinedContact:
    """A solution whose border elements carry the load of their covered part: `pressure` as element averages in Pa, `covered`
    fraction of each element, `displacement` and `gap` in m, `approach` in m."""

    pressure: Array
    covered: Array
    displacement: Array
    gap: Array
    approach: float
    iterations: int


class NormalSolver:
    """Keeps Love's kernel and the plans for one grid. `applications` counts convolutions."""

    def __init__(self, grid: Grid, contact_modulus: float, options: NormalOptions | None = None) -> None:
        pyfftw = fftw()

        nx, ny = grid.shape
        self.grid = grid
        self.contact_modulus = contact_modulus
        self.options = options or NormalOptions()
        self.applications = 0
        self._convolution = Convolution(nx, ny)
        px, py = (even_length(k + 4) for k in grid.shape)
        reach = (max(nx, px // 2 + 1), max(ny, py // 2 + 1))
        table = normal_table(*reach, grid.dx, grid.dy, contact_modulus)
        self._kernel = self._convolution.quadrant_spectrum(table)
        self._hat = self._convolution.empty_spectrum()
        symbol = periodic_symbol(table, (px, py))
        # Rounding could leave a wavenumber without stiffness; the kernel itself is positive.
        self._inverse_symbol = 1.0 / np.maximum(symbol, 1e-12 * symbol.max())
        self._field = pyfftw.zeros_aligned((px, py))
        self._field_hat = pyfftw.zeros_aligned((px, py // 2 + 1), dtype=np.complex128)
        flags = ("FFTW_ESTIMATE",)
        self._forward = pyfftw.FFTW(self._field, self._field_hat, axes=(0, 1), flags=flags)
        self._backward = pyfftw.FFTW(self._field_hat, self._field, axes=(0, 1), direction="FFTW_BACKWARD",
                                     flags=(*flags, "FFTW_DESTROY_INPUT"))

    @property
    def transforms(self) -> int:
        return self._convolution.transforms

    def displacement(self, pressure: Array) -> Array:
        """u_z^e = A p in m, by free-space convolution (Eq. 6)."""
        self.applications += 1
        hat = self._convolution.forward(pressure, out=self._hat)
        return self._convolution.inverse(multiply(hat, self._kernel, out=hat))

    def precondition(self, residual: Array, contact: Mask) -> Array:
        nx, ny = self.grid.shape
        self._field[nx:, :] = 0.0
        self._field[:nx, ny:] = 0.0
        self._field[:nx, :ny] = residual
        self._forward.execute()
        self._field_hat *= self._inverse_symbol
        self._backward.execute()
        z = self._field[:nx, :ny] * contact
        z -= contact * (z.sum() / np.count_nonzero(contact))
        return z

    def _conjugate_gradients(
        self, gap: Array, pressure: Array, displacement: Array, free: Mask, tolerance: float, max_iterations: int,
        reduction: float = 0.0,
    ) -> _Iterate:
        """Close the gap on the `free` elements at constant load, down to `tolerance` or by the factor `reduction`."""
        count = np.count_nonzero(free)
        scale = max(float(np.abs(displacement[free]).mean()), 1e-300)

        def residual_of(displacement: Array) -> tuple[Array, float, float]:
            residual = -(displacement + gap)
            approach = -float(residual[free].sum()) / count
            residual = np.where(free, residual + approach, 0.0)
            return residual, approach, float(np.linalg.norm(residual)) / np.sqrt(count) / scale

        residual, approach, error = residual_of(displacement)
        goal = max(reduction * error, tolerance)
        direction = residual
        rz_old = 0.0
        history: list[float] = []
        while error > goal and len(history) < max_iterations:
            z = self.precondition(residual, free)
            rz = float(np.vdot(residual, z))
            if rz <= 0.0:  # the circulant inverse is only nearly positive: plain CG for this step
                z, rz_old = residual, 0.0
                rz = float(np.vdot(residual, z))
            direction = z + direction * (rz / rz_old) if rz_old else z
            if rz <= 0.0:
                break  # a contact of one element: the load leaves nothing to solve for
            rz_old = rz
            image = self.displacement(direction)
            step = rz / float(np.vdot(direction, image))
            pressure = pressure + step * direction
            displacement = displacement + step * image
            residual, approach, error = residual_of(displacement)
            history.append(error)
        return _Iterate(pressure, displacement, approach, error, scale, len(history), history)

    def solve(
        self, gap: Array, normal_force: float, pressure: Array, tolerance: float = 1e-9, max_iterations: int = 400
    ) -> NormalSolution:
        """Contact pressure of surfaces `gap` apart (m, (nx, ny), any constant) under `normal_force` (N).

        `pressure` is the first guess; where it is positive is the first guess of the contact. On the active set A p = δ − h
        is solved under ∬p = W in the subspace of constant load; then p < 0 is dropped, h < 0 added, and so on.
        """
        before = self.applications
        load = normal_force / self.grid.element_area
        contact = pressure > 0.0
        if not contact.any():
            contact = gap == gap.min()
            pressure = np.where(contact, 1.0, 0.0)
        pressure = np.where(contact, pressure, 0.0)
        pressure *= load / pressure.sum()
        displacement = self.displacement(pressure)
        history: list[float] = []
        iterations, stalled = 0, 0
        target = self.options.first_reduction
        converged = False
        seen_changes = contact.size
        while iterations < max_iterations:
            state = self._conjugate_gradients(gap, pressure, displacement, contact, self.options.solved_share * tolerance,
                                              max_iterations - iterations, target)
            pressure, displacement, approach = state.pressure, state.displacement, state.approach
            iterations += state.iterations
            history.extend(state.history)
            error, scale = state.error, state.scale
            opening = displacement + gap - approach
            drop = contact & (pressure < 0.0)
            add = ~contact & (opening < -tolerance * scale)
            changes = int(np.count_nonzero(drop) + np.count_nonzero(add))
            if changes == 0:
                if error <= tolerance:
                    converged = True
                    break
                target = min(target, tolerance / error)
                continue
            # Two elements may swap for ever on a symmetric border: then only what must go goes.
            stalled = stalled + 1 if changes >= seen_changes else 0
            seen_changes = min(seen_changes, changes)
            contact = contact & ~drop
            if stalled < self.options.patience or not drop.any():
                contact |= add
            pressure = np.where(contact, pressure, 0.0)
            if pressure.any():
                pressure *= load / pressure.sum()
            else:
                # A bulge has moved the contact somewhere else: begin again where the bodies are closest.
                contact |= opening == opening.min()
                pressure = np.where(contact, load / np.count_nonzero(contact), 0.0)
            displacement = self.displacement(pressure)
        displacement = self.displacement(pressure)
        opening = displacement + gap - approach
        return NormalSolution(
            pressure, displacement, np.where(contact, 0.0, opening), float(approach), contact, residual=float(error),
            iterations=iterations, applications=self.applications - before, converged=converged,
            touches_rim=_touches_rim(contact), history=tuple(history))

    def refine(self, solution: NormalSolution, gap: Array, normal_force: float, tolerance: float = 1e-9) -> RefinedContact:
        """Resolve the border inside its elements (see `border_elements`): they keep the load that the continued pressure
        gives them, the others are solved for once more.

        Element averages of a Hertz pressure come out 4–5 times closer than by collocation on whole elements; the contact area,
        also of contacts far from Hertz's, to about 1e-3 at N = 32 and 1e-4 at N = 128. A second pass would be worse: the errors
        that whole elements make on both sides of the border cancel, those beside elements of known load do not.
        """
        border, load, covered = border_elements(solution.pressure, solution.contact, solution.gap, self.grid,
                                                self.contact_modulus)
        free = solution.contact & ~border
        fixed = np.where(border, load, 0.0)
        wanted = normal_force / self.grid.element_area - float(fixed.sum())
        unrefined = RefinedContact(solution.pressure, covered, solution.displacement, solution.gap, solution.approach, 0)
        if wanted <= 0.0 or not free.any():
            return unrefined
        pressure = np.where(free, solution.pressure, 0.0)
        for _ in range(self.options.border_passes):
            pressure = pressure * (wanted / float(pressure.sum())) + fixed
            state = self._conjugate_gradients(gap, pressure, self.displacement(pressure), free, tolerance,
                                              self.options.border_iterations)
            negative = state.pressure < 0.0
            if not negative.any():
                break
            free = free & ~negative
            pressure = np.where(free, state.pressure, 0.0)
            covered = np.where(negative, 0.0, covered)
        else:
            return unrefined
        opening = np.maximum(state.displacement + gap - state.approach, 0.0)
        return RefinedContact(state.pressure, covered, state.displacement, np.where(covered > 0.0, 0.0, opening),
                              state.approach, state.iterations)


def _touches_rim(contact: Mask) -> bool:
    return bool(contact[0].any() or contact[-1].any() or contact[:, 0].any() or contact[:, -1].any())
