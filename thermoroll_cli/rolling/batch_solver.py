"""Many tangential problems that differ in creepage alone, solved together: `newton` on (B, 2, n, m) arrays.

Pressure, friction, border and kernels are the same for all, so set-up is paid once and every step of Python does the work of
a whole group. Points that are solved drop out."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from thermoroll_cli.arrays import AnyArray, Mask
from thermoroll_cli.numerics.batch_krylov import batch_gmres
from thermoroll_cli.numerics.solver_options import RollingOptions
from thermoroll_cli.rolling.batch_operators import BatchGradient, BatchInverse, begins
from thermoroll_cli.rolling.newton import Newton
from thermoroll_cli.rolling.rolling_gradient import RollingGradient
from thermoroll_cli.rolling.stick_inverse import StickInverse
from thermoroll_cli.rolling.tangential_problem import TangentialProblem

FINEST_FORCING = 1e-5
"""Single precision solves a linear system no further."""
ROUNDS = 2
"""How often Newton goes on from the slip computed afresh in double precision."""


@dataclass(frozen=True)
class BatchSolution:
    """`traction` (Pa), `slip` s/V, both (B, 2, n, m), `stick` (B, n, m), `residual` and `converged` (B,), each as in
    `TangentialSolution`; `newton_steps` (B,)."""

    traction: AnyArray
    slip: AnyArray
    stick: Mask
    residual: AnyArray
    converged: Mask
    newton_steps: AnyArray


@dataclass
class _State:
    """Iterates of some points, all arrays with the point as first axis."""

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

    def __init__(
        self, problem: TangentialProblem, gradient: RollingGradient, inverse: StickInverse,
        options: RollingOptions | None = None,
    ) -> None:
        self._options = options or RollingOptions()
        shape, compliance = gradient.shape, gradient.compliance
        self._newton = newton = Newton(replace(problem, rigid_slip=np.zeros((2, *shape))), gradient, inverse, self._options)
        self._shape = shape
        self._contact = newton.contact
        on = shape, gradient.dx, gradient.dy, compliance, gradient.weights, newton.contact
        self._gradient, self._inverse = BatchGradient(*on), BatchInverse(*on)
        self._border = np.zeros((3, *shape))
        for part, values in zip(self._border, (newton.border.xx, newton.border.yy, newton.border.xy), strict=True):
            part[newton.border._index] = values
        self._own_size = float(np.mean(gradient.self_gradient))

    @property
    def applications(self) -> int:
        return self._gradient.applications

    def full_stick(self, rigid: AnyArray) -> AnyArray:
        """Tractions (B, 2, n, m) that let nothing slip under `rigid` slips: a linear problem."""
        bound = self._newton.traction_bound * self._options.unbounded
        state = self._iterate(np.zeros_like(rigid), rigid.copy(), bound)
        return self._step(state, rigid, bound, np.full(len(rigid), self._options.stick_forcing)).traction

    def solve(self, rigid: AnyArray, starts: AnyArray, tolerance: float) -> BatchSolution:
        """Solve for `rigid` slips from the tractions `starts`, both (B, 2, n, m), to the residual `tolerance`.

        Points that do not get there are told in `converged`; from full stick cut down to the bound almost all do."""
        bound, newton = self._newton.traction_bound, self._newton
        reference = self._references(rigid)
        size = np.hypot(starts[:, 0], starts[:, 1])
        shrink = np.where(size > bound, bound / np.where(size > 0.0, size, 1.0), 1.0) * self._contact
        traction = starts * shrink[:, None]
        state = self._iterate(traction, self._slip(traction, rigid), bound, reference)
        steps = np.zeros(len(rigid), dtype=int)
        for _ in range(ROUNDS):
            active = np.flatnonzero(state.norm > tolerance)
            last = np.full(len(rigid), np.nan)
            for _ in range(self._options.most_newton_steps):
                if not active.size:
                    break
                part = state.take(active)
                ratio = part.norm / last[active]
                loosest = self._options.loosest_forcing
                forcing = np.clip(self._options.forcing_share * ratio**2, 0.5 * tolerance / part.norm, loosest)
                forcing = np.maximum(np.where(np.isnan(forcing), loosest, forcing), FINEST_FORCING)
                last[active] = part.norm
                state.put(active, self._step(part, rigid[active], bound, forcing, reference[active]))
                steps[active] += 1
                stuck = state.norm[active] >= last[active]
                active = active[(state.norm[active] > tolerance) & ~stuck]
            # The slip was combined from images in single precision.
            state = self._iterate(state.traction, self._slip(state.traction, rigid), bound, reference)
        return BatchSolution(state.traction, np.where(state.stick[:, None], 0.0, state.slip) * self._contact,
                             state.stick & newton.contact, state.norm, state.norm <= 2.0 * tolerance, steps)

    def _references(self, rigid: AnyArray) -> AnyArray:
        """What residuals count against, as in `Newton`."""
        size = np.hypot(rigid[:, 0], rigid[:, 1])
        expected = np.minimum(self._newton.traction_bound, self._options.stick_traction * size / self._own_size)
        norm = np.sqrt(np.einsum("bij,bij->b", expected, expected))
        return np.where(norm > 0.0, norm, 1.0)

    def _slip(self, traction: AnyArray, rigid: AnyArray) -> AnyArray:
        slip = rigid - self._gradient(traction)
        return self._add_border(slip, traction, -1.0)

    def _add_border(self, out: AnyArray, traction: AnyArray, sign: float) -> AnyArray:
        xx, yy, xy = (sign * self._border).astype(out.dtype)
        out[:, 0] += xx * traction[:, 0] + xy * traction[:, 1]
        out[:, 1] += xy * traction[:, 0] + yy * traction[:, 1]
        return out

    def _iterate(self, traction: AnyArray, slip: AnyArray, bound: AnyArray, reference: AnyArray | float = 1.0) -> _State:
        trial = traction + self._newton.rho * slip
        length = np.hypot(trial[:, 0], trial[:, 1])
        stick = length <= bound
        safe = np.where(stick, 1.0, length)
        scale = np.where(stick, 1.0, bound / safe)
        residual = traction - scale[:, None] * trial
        residual *= self._contact
        direction = np.where(stick[:, None], 0.0, trial / safe[:, None])
        norm = np.sqrt(np.einsum("bcij,bcij->b", residual, residual)) / reference
        return _State(traction, slip, residual, stick, scale, direction, norm)

    def _step(
        self, state: _State, rigid: AnyArray, bound: AnyArray, forcing: AnyArray, reference: AnyArray | None = None
    ) -> _State:
        """One Newton step of each point, as long as it lowers the residual."""
        reference = self._references(rigid) if reference is None else reference
        system = _Linearisations(self, state)
        count = len(state.norm)
        right = (state.residual / -reference[:, None, None, None]).astype(np.float32).reshape(count, -1)
        step, image = batch_gmres(system.expensive, system.cheap, system.precondition, right, forcing,
                                  self._options.most_krylov_steps)
        full = (count, 2, *self._shape)
        change, gradient = (v.reshape(full) * reference[:, None, None, None] for v in (step, image))
        change_slip = -self._add_border(gradient, change, 1.0)
        best = self._iterate(state.traction + change, state.slip + change_slip, bound, reference)
        length = 1.0
        for _ in range(self._options.most_halvings):
            worse = np.flatnonzero(best.norm > (1.0 - self._options.sufficient_decrease * length) * state.norm)
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
        newton, contact = solver._newton, solver._contact
        stick = state.stick & contact
        slip = contact & ~stick
        nx, ny = state.direction[:, 0], state.direction[:, 1]
        f = state.scale
        xx, yy, xy = f * (1.0 - nx * nx), f * (1.0 - ny * ny), -f * nx * ny
        one = slip.astype(float)
        rho = newton.rho * contact
        self._p = _stack(one * (1.0 - xx), one * (1.0 - yy), -one * xy)
        self._q = _stack(rho * xx, rho * yy, rho * xy)
        head = stick & newton.border.partial
        head[:, 1:] &= ~stick[:, :-1]
        inner = stick & ~head
        own_x, own_y = newton.self_compliance
        scale_x, scale_y = head / (newton.rho * own_x), head / (newton.rho * own_y)
        across = one / np.where(slip, 1.0 - f + f * newton.rho * (own_x * ny * ny + own_y * nx * nx), 1.0)
        self._local = _stack(scale_x + one * nx * nx + across * ny * ny, scale_y + one * ny * ny + across * nx * nx,
                             one * nx * ny - across * nx * ny)
        self._inner = inner[:, None].astype(np.float32)
        self._starts = begins(inner)
        self._inverse_rho = (self._inner / newton.rho).astype(np.float32)
        self._border = solver._border.astype(np.float32)
        self._who: AnyArray = np.arange(len(state.norm))

    def _keep(self, who: AnyArray) -> None:
        """Drop the coefficients of all systems but `who`: what has dropped out is never asked for again."""
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
        inner = images.reshape(change.shape).copy()
        xx, yy, xy = self._border
        inner[:, 0] += xx * change[:, 0] + xy * change[:, 1]
        inner[:, 1] += xy * change[:, 0] + yy * change[:, 1]
        out = _times(self._q, inner)
        out += _times(self._p, change)
        return out.reshape(vectors.shape)

    def precondition(self, who: AnyArray, vectors: AnyArray) -> AnyArray:
        self._keep(who)
        right = vectors.reshape(-1, 2, *self._solver._shape)
        out = self._solver._inverse(right * self._inverse_rho, self._inner, self._starts)
        out += _times(self._local, right)
        return out.reshape(vectors.shape)


def _stack(xx: AnyArray, yy: AnyArray, xy: AnyArray) -> AnyArray:
    return np.stack([xx, yy, xy], axis=1).astype(np.float32)


def _times(block: AnyArray, v: AnyArray) -> AnyArray:
    out = np.empty_like(v)
    term = block[:, 2] * v[:, 1]
    np.multiply(block[:, 0], v[:, 0], out=out[:, 0])
    out[:, 0] += term
    np.multiply(block[:, 1], v[:, 1], out=out[:, 1])
    np.multiply(block[:, 2], v[:, 0], out=term)
    out[:, 1] += term
    return out
