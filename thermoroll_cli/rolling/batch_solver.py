"""Many tangential problems that differ in creepage alone, solved together: `newton` on (B, 2, n, m) arrays.

Pressure, friction, border and kernels are the same for all, so set-up is done once and every step of Python does the work of
a whole group. Points that are solved drop out. The operators are matrices: on grids of up to some thirty elements a side one
product of matrices is faster than many small transforms. A point of a table takes 0.41 to 0.46 of the CPU time that the solver
of one point takes from a start as good, on 16 × 16 and 32 × 32 elements; residual and blocks of the derivative are those of
`Newton`.

Kernels are symmetric across y = 0, so tractions are split into two parts: τ_x even and τ_y odd across y = 0, and the other
way round. Each part needs half the elements, and both together half the work.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from thermoroll_cli.arrays import AnyArray, Mask
from thermoroll_cli.halfspace.elastic import ShearCompliance
from thermoroll_cli.numerics.convolution import even_length
from thermoroll_cli.numerics.grid import UPSTREAM_WEIGHTS
from thermoroll_cli.numerics.krylov import batch_gmres
from thermoroll_cli.process import safe_point
from thermoroll_cli.rolling.element_borders import times
from thermoroll_cli.rolling.newton import (
    MOST_HALVINGS,
    MOST_KRYLOV_STEPS,
    STICK_TRACTION,
    SUFFICIENT_DECREASE,
    Iterate,
    Linearisation,
    Newton,
    TangentialProblem,
)
from thermoroll_cli.rolling.rolling_gradient import RollingGradient, RollingOptions
from thermoroll_cli.rolling.rolling_solver import (
    FORCING_SHARE,
    FULL_STICK_BOUND,
    LOOSEST_FORCING,
    MOST_NEWTON_STEPS,
    STICK_FORCING,
)
from thermoroll_cli.rolling.stick_inverse import StickInverse, inverse_symbols

Kernels = tuple[AnyArray, AnyArray, AnyArray]
"""Influence at offsets −(n−1)…n−1 by −(m−1)…m−1, (2n−1, 2m−1) each: τ_x on u_x, τ_y on u_y, each on the other."""


class PairMatrix:
    """Three kernels applied to pairs of fields, (B, 2, n, m) -> (B, 2, n, m), in the precision of these. m is even.

    The matrices are restricted to `contact` (n, m), extended to be symmetric in y: an ellipse has a fifth fewer elements than
    its rectangle, and a product of matrices two fifths less work."""

    def __init__(self, shape: tuple[int, int], kernels: Kernels, contact: Mask | None = None) -> None:
        n, m = self._shape = shape
        if m % 2:
            raise ValueError(f"an even number of columns is needed to split them at y = 0, got {m}")
        whole = contact is None or not np.array_equal(contact, contact[:, ::-1])
        above = np.ones((n, m // 2), dtype=bool) if whole or contact is None else contact[:, m // 2 :]
        self._cells = np.flatnonzero(above)
        self._everywhere = bool(above.all())
        rows, columns = np.nonzero(above)
        along = rows[:, None] - rows + n - 1
        same, mirrored = columns[:, None] - columns + m - 1, columns[:, None] + columns + m

        def block(kernel: AnyArray, parity: int) -> AnyArray:
            """Effect of a field with this parity on the elements y > 0."""
            return np.asarray(kernel[along, same] + parity * kernel[along, mirrored])

        xx, yy, xy = kernels
        self._matrices: dict[Any, list[AnyArray]] = {np.dtype(np.float64): [
            # Rows are sources: fields multiply the matrix from the left.
            np.block([[block(xx, even), block(xy, -even)], [block(xy, even), block(yy, -even)]]).T.copy()
            for even in (1, -1)
        ]}

    def __call__(self, pairs: AnyArray) -> AnyArray:
        safe_point()  # every step of the batched solver passes here
        if pairs.dtype not in self._matrices:
            double = self._matrices[np.dtype(np.float64)]
            self._matrices[pairs.dtype] = [matrix.astype(pairs.dtype) for matrix in double]
        count, m = len(pairs), self._shape[1]
        above, below = self._within(pairs[..., m // 2 :]), self._within(pairs[..., : m // 2][..., ::-1])
        even, odd = above + below, above - below
        halves = []
        for parts, matrix in zip(((even, odd), (odd, even)), self._matrices[pairs.dtype], strict=True):
            part = np.empty_like(even)
            part[:, 0], part[:, 1] = parts[0][:, 0], parts[1][:, 1]
            halves.append((part.reshape(count, -1) @ matrix).reshape(part.shape))
        first, second = halves
        out = np.empty_like(pairs)
        out[..., m // 2 :] = self._spread(0.5 * (first + second))
        # The elements y < 0 follow by the parity of each component.
        difference = self._spread(0.5 * (first - second))[..., ::-1]
        out[:, 0, :, : m // 2] = difference[:, 0]
        np.negative(difference[:, 1], out=out[:, 1, :, : m // 2])
        return out

    def _within(self, half: AnyArray) -> AnyArray:
        """(B, 2, n, m/2) -> (B, 2, cells)"""
        flat = half.reshape(*half.shape[:2], -1)
        return flat if self._everywhere else flat[..., self._cells]

    def _spread(self, values: AnyArray) -> AnyArray:
        """(B, 2, cells) -> (B, 2, n, m/2), 0 outside."""
        n, m = self._shape
        if self._everywhere:
            return values.reshape(*values.shape[:2], n, m // 2)
        out = np.zeros((*values.shape[:2], n * (m // 2)), dtype=values.dtype)
        out[..., self._cells] = values
        return out.reshape(*values.shape[:2], n, m // 2)


class BatchGradient:
    """D A of `RollingGradient` for (B, 2, n, m) tractions on `contact`. `applications` counts points, for comparison with that
    of `RollingGradient`."""

    def __init__(
        self, shape: tuple[int, int], dx: float, dy: float, compliance: ShearCompliance,
        weights: tuple[float, ...] = UPSTREAM_WEIGHTS, contact: Mask | None = None,
    ) -> None:
        n, m = shape
        everywhere = RollingGradient((2 * n - 1, 2 * m - 1), dx, dy, compliance, weights=weights)
        units = np.zeros((2, 2, 2 * n - 1, 2 * m - 1))
        units[[0, 1], [0, 1], n - 1, m - 1] = 1.0
        (xx, xy), (_, yy) = (everywhere(unit) for unit in units)
        self._apply = PairMatrix(shape, (xx, yy, xy), contact)
        self.applications = 0

    def __call__(self, traction: AnyArray) -> AnyArray:
        self.applications += len(traction)
        return self._apply(traction)


class BatchInverse:
    """`StickInverse` for (B, 2, n, m) gradients."""

    def __init__(
        self, shape: tuple[int, int], dx: float, dy: float, compliance: ShearCompliance,
        weights: tuple[float, ...] = UPSTREAM_WEIGHTS, contact: Mask | None = None,
    ) -> None:
        n, m = shape
        px, py = padded = (even_length(n + 4), even_length(m + 4))
        periodic = (np.fft.irfft2(symbol.T, s=padded) for symbol in inverse_symbols(padded, dx, dy, compliance, weights))
        rows, columns = np.arange(-(n - 1), n) % px, np.arange(-(m - 1), m) % py
        xx, yy, xy = (table[np.ix_(rows, columns)] for table in periodic)
        self._apply = PairMatrix(shape, (xx, yy, xy), contact)

    def __call__(self, gradient: AnyArray, mask: AnyArray, starts: AnyArray) -> AnyArray:
        """As `StickInverse`; `mask` (B, 1, n, m) as numbers, `starts` (B, 1, n, m) the row in which the run of each begins."""
        count, _, n, m = gradient.shape
        sums = np.zeros((count, 2, n + 1, m), dtype=gradient.dtype)
        np.cumsum(gradient, axis=2, out=sums[:, :, 1:])
        base = np.take_along_axis(sums, starts, axis=2)
        np.subtract(sums[:, :, 1:], base, out=base)
        base *= mask
        traction = self._apply(base)
        traction *= mask
        return traction


FINEST_FORCING = 1e-5
"""Smallest relative residual of linear systems: they are solved in single precision."""
ROUNDS = 2
"""Rounds of Newton's iteration; each starts from the slip recomputed in double precision."""


@dataclass(frozen=True)
class BatchSolution:
    """`traction` (Pa), `slip` s/V, both (B, 2, n, m), `stick` (B, n, m), `residual` and `converged` (B,), each as in
    `TangentialSolution`."""

    traction: AnyArray
    slip: AnyArray
    stick: Mask
    residual: AnyArray
    converged: Mask


@dataclass
class _State:
    """Iterates of some points; the first axis of all arrays is the point."""

    traction: AnyArray
    slip: AnyArray
    residual: AnyArray
    stick: Mask
    scale: AnyArray
    direction: AnyArray
    norm: AnyArray

    def take(self, which: Any) -> _State:
        return _State(*(values[which] for values in vars(self).values()))

    def put(self, which: Any, other: _State) -> None:
        for mine, theirs in zip(vars(self).values(), vars(other).values(), strict=True):
            mine[which] = theirs


class BatchSolver:
    """Solves `problem` (its `rigid_slip` is not used, its creepages are given) for many rigid slips."""

    def __init__(self, problem: TangentialProblem, gradient: RollingGradient, inverse: StickInverse) -> None:
        shape, compliance = gradient.shape, gradient.compliance
        self._newton = newton = Newton(replace(problem, rigid_slip=np.zeros((2, *shape))), gradient, inverse, RollingOptions())
        self._shape = shape
        self._contact = newton.contact
        on = shape, gradient.dx, gradient.dy, compliance, gradient.weights, newton.contact
        self._gradient, self._inverse = BatchGradient(*on), BatchInverse(*on)
        self._border = newton.border.k
        self._own_size = float(np.mean(gradient.self_gradient))

    @property
    def applications(self) -> int:
        return self._gradient.applications

    def full_stick(self, rigid: AnyArray) -> AnyArray:
        """Tractions (B, 2, n, m) of full stick under `rigid` slips: a linear problem."""
        bound = self._newton.traction_bound * FULL_STICK_BOUND
        state = self._iterate(np.zeros_like(rigid), rigid.copy(), bound)
        return self._step(state, rigid, bound, np.full(len(rigid), STICK_FORCING)).traction

    def solve(self, rigid: AnyArray, starts: AnyArray, tolerance: float) -> BatchSolution:
        """Solve for `rigid` slips from the tractions `starts`, both (B, 2, n, m), to the residual `tolerance`.

        `converged` marks the points that reach it; from full stick cut down to the bound almost all do."""
        bound, newton = self._newton.traction_bound, self._newton
        reference = self._references(rigid)
        size = np.hypot(starts[:, 0], starts[:, 1])
        shrink = np.where(size > bound, bound / np.where(size > 0.0, size, 1.0), 1.0) * self._contact
        traction = starts * shrink[:, None]
        state = self._iterate(traction, self._slip(traction, rigid), bound, reference)
        for _ in range(ROUNDS):
            active = np.flatnonzero(state.norm > tolerance)
            last = np.full(len(rigid), np.nan)
            for _ in range(MOST_NEWTON_STEPS):
                if not active.size:
                    break
                part = state.take(active)
                ratio = part.norm / last[active]
                loosest = LOOSEST_FORCING
                forcing = np.clip(FORCING_SHARE * ratio**2, 0.5 * tolerance / part.norm, loosest)
                forcing = np.maximum(np.where(np.isnan(forcing), loosest, forcing), FINEST_FORCING)
                last[active] = part.norm
                state.put(active, self._step(part, rigid[active], bound, forcing, reference[active]))
                stuck = state.norm[active] >= last[active]
                active = active[(state.norm[active] > tolerance) & ~stuck]
            # The slip so far was combined from images in single precision.
            state = self._iterate(state.traction, self._slip(state.traction, rigid), bound, reference)
        return BatchSolution(state.traction, np.where(state.stick[:, None], 0.0, state.slip) * self._contact,
                             state.stick & newton.contact, state.norm, state.norm <= 2.0 * tolerance)

    def _references(self, rigid: AnyArray) -> AnyArray:
        """Scale of the residuals, as in `Newton`."""
        size = np.hypot(rigid[:, 0], rigid[:, 1])
        expected = np.minimum(self._newton.traction_bound, STICK_TRACTION * size / self._own_size)
        norm = np.sqrt(np.einsum("bij,bij->b", expected, expected))
        return np.where(norm > 0.0, norm, 1.0)

    def _slip(self, traction: AnyArray, rigid: AnyArray) -> AnyArray:
        slip = rigid - self._gradient(traction)
        return slip - times(self._border.astype(slip.dtype), traction)

    def _iterate(self, traction: AnyArray, slip: AnyArray, bound: AnyArray, reference: AnyArray | float = 1.0) -> _State:
        natural = self._newton.natural_residual(np.moveaxis(traction, 1, 0), np.moveaxis(slip, 1, 0), bound)
        residual, direction = np.moveaxis(natural[0], 0, 1), np.moveaxis(natural[3], 0, 1)
        norm = np.sqrt(np.einsum("bcij,bcij->b", residual, residual)) / reference
        return _State(traction, slip, residual, natural[1], natural[2], direction, norm)

    def _step(
        self, state: _State, rigid: AnyArray, bound: AnyArray, forcing: AnyArray, reference: AnyArray | None = None
    ) -> _State:
        """One Newton step of each point, shortened until it lowers the residual."""
        reference = self._references(rigid) if reference is None else reference
        system = _Linearisations(self, state)
        count = len(state.norm)
        right = (state.residual / -reference[:, None, None, None]).astype(np.float32).reshape(count, -1)
        step, image = batch_gmres(system.expensive, system.cheap, system.precondition, right, forcing,
                                  MOST_KRYLOV_STEPS)
        full = (count, 2, *self._shape)
        change, gradient = (v.reshape(full) * reference[:, None, None, None] for v in (step, image))
        change_slip = -(gradient + times(self._border.astype(gradient.dtype), change))
        best = self._iterate(state.traction + change, state.slip + change_slip, bound, reference)
        length = 1.0
        for _ in range(MOST_HALVINGS):
            worse = np.flatnonzero(best.norm > (1.0 - SUFFICIENT_DECREASE * length) * state.norm)
            if not worse.size:
                break
            length *= 0.5
            trial = self._iterate(state.traction[worse] + length * change[worse],
                                  state.slip[worse] + length * change_slip[worse], bound, reference[worse])
            better = trial.norm < best.norm[worse]
            best.put(worse[better], trial.take(better))
        return best


class _Linearisations:
    """`newton.Linearisation` of many points, in single precision."""

    def __init__(self, solver: BatchSolver, state: _State) -> None:
        self._solver = solver
        exact = Linearisation(solver._newton, Iterate(
            state.traction, np.zeros(0), state.slip, state.residual, state.stick, state.scale,
            np.moveaxis(state.direction, 1, 0), np.nan, solver._newton.traction_bound))
        self._p, self._q, self._local = (np.stack(part, axis=1).astype(np.float32) for part in (exact.p, exact.q, exact.local))
        self._inner = exact.inner[:, None].astype(np.float32)
        self._starts = exact.starts[:, None] // solver._shape[1]
        self._inverse_rho = exact.inverse_rho[:, None].astype(np.float32)
        self._border = solver._border.astype(np.float32)
        self._who: AnyArray = np.arange(len(state.norm))

    def _keep(self, who: AnyArray) -> None:
        """Drop the coefficients of all systems but `who`: systems that have dropped out are not needed again."""
        if len(who) == len(self._who):
            return
        left = np.isin(self._who, who)
        self._p, self._q, self._local = self._p[left], self._q[left], self._local[left]
        self._inner, self._starts, self._inverse_rho = self._inner[left], self._starts[left], self._inverse_rho[left]
        self._who = who

    def expensive(self, vectors: AnyArray) -> AnyArray:
        full = vectors.reshape(-1, 2, *self._solver._shape)
        return self._solver._gradient(full).reshape(vectors.shape)

    def cheap(self, who: AnyArray, vectors: AnyArray, images: AnyArray) -> AnyArray:
        self._keep(who)
        change = vectors.reshape(-1, 2, *self._solver._shape)
        inner = images.reshape(change.shape) + times(self._border, change)
        out = times(np.moveaxis(self._q, 1, 0), inner)
        out += times(np.moveaxis(self._p, 1, 0), change)
        return out.reshape(vectors.shape)

    def precondition(self, who: AnyArray, vectors: AnyArray) -> AnyArray:
        self._keep(who)
        right = vectors.reshape(-1, 2, *self._solver._shape)
        out = self._solver._inverse(right * self._inverse_rho, self._inner, self._starts)
        out += times(np.moveaxis(self._local, 1, 0), right)
        return out.reshape(vectors.shape)
