"""The tangential problem, and one Newton step on τ − Proj(τ + ρ s) = 0, the natural residual of Coulomb friction, with its
generalised derivative.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from thermoroll_cli.physics.numerics.krylov import gmres, length_of
from thermoroll_cli.physics.rolling.element_borders import EdgeCompliance, block_product, edge_compliance
from thermoroll_cli.physics.rolling.hardening import Hardening
from thermoroll_cli.physics.rolling.rolling_gradient import RollingGradient, RollingOptions
from thermoroll_cli.physics.rolling.slip_friction import FrictionResponse, SlipFriction
from thermoroll_cli.physics.rolling.stick_inverse import StickInverse, run_starts
from thermoroll_cli.tools.arrays import AnyArray, Array, Mask

STICK_TRACTION = 1.0
"""Traction by a creepage in full stick, in units of creepage over an element's own compliance; a lower bound."""
UNSEEN_CREEPAGE = 2.0
"""Largest first step of free creepages, in units of the creepage that saturates a single element."""
FORCE_WEIGHT = 20.0
"""Weight of the residual of a prescribed force beside that of the tractions: users compare the force with their input."""
MOST_KRYLOV_STEPS = 150
"""Preconditioned systems need about ten, on any grid."""
MOST_UNPRECONDITIONED = 1500
"""The same without a preconditioner, where the number grows with the grid."""
MOST_HALVINGS = 10
SUFFICIENT_DECREASE = 1e-4
"""Part of the step's length by which the residual must fall (Armijo's rule, its usual value)."""
GROWTH, SETTLED = 3.0, 1e-3
"""Factor by which a step may enlarge a residual above `SETTLED` in a contact of spots. Which elements stick there is found by
whole steps that first go up; those that always go down are short, and on 64 × 64 elements 17 are needed in place of 9."""
FINEST_FORCING = 30.0 * float(np.finfo(float).eps)
"""Smallest relative residual of a linear system: some rounding errors."""


@dataclass(frozen=True)
class TangentialProblem:
    """Data on the contact's bounding box (n, m).

    `traction_bound`: Coulomb's bound μp, element averages in Pa, 0 outside.
    `covered`: fraction of each element's length along x that lies in contact.
    `rigid_slip`: (2, n, m) creepage and spin, ξ_x − ξ_φ y and ξ_y + ξ_φ x; if a force is prescribed, without the creepage of
    its direction.
    `force`: prescribed resultants along x and y in N, None if the creepage is given.
    `leading`: (3, n, m) error of the difference formula at the leading edge (`known_gradient`), None if unknown.
    `variation`: (n, m) half the change of ξ_x across the width of an element, None if negligible (`neutral_compliance`).
    `slip_friction`: factor of `traction_bound` by slip; None for a constant bound.
    `spots`: whether the surfaces are rough, so that many elements change between stick and slip at once.
    """

    traction_bound: Array
    covered: Array
    rigid_slip: Array
    element_area: float
    force: tuple[float | None, float | None] = (None, None)
    leading: Array | None = None
    variation: Array | None = None
    slip_friction: SlipFriction | Hardening | None = None
    spots: bool = False

    @property
    def free(self) -> tuple[int, ...]:
        """Directions (0: x, 1: y) whose creepage is an unknown."""
        return tuple(i for i in (0, 1) if self.force[i] is not None)


LEAST_STIFFNESS = 0.1
"""Least share of an element's stiffness in the preconditioner if friction falls with slip: at zero a single element is
unstable."""
NO_FORCE_RESPONSE = 1e-30
"""Responses of the force to a free creepage below this count as zero."""


@dataclass(frozen=True)
class Iterate:
    """One iterate with everything the next Newton step needs."""

    traction: AnyArray
    unknown: AnyArray
    slip: AnyArray
    residual: AnyArray
    stick: Mask
    scale: AnyArray
    direction: AnyArray
    norm: float
    bound: AnyArray
    sliding: AnyArray | None = None
    response: FrictionResponse | None = None


@dataclass(frozen=True)
class Newton:
    """The linearisation of τ − Proj(τ + ρ s) = 0, with Σ τ dA = F for the directions whose creepage is free."""

    problem: TangentialProblem
    gradient: RollingGradient
    inverse: StickInverse
    options: RollingOptions

    @cached_property
    def contact(self) -> Mask:
        return np.asarray((self.problem.traction_bound > 0.0) & (self.problem.covered > 0.0))

    @cached_property
    def traction_bound(self) -> AnyArray:
        """Coulomb's bound in Pa, (n, m), 0 outside the contact."""
        return np.where(self.contact, self.problem.traction_bound, 0.0)

    @cached_property
    def border(self) -> EdgeCompliance:
        problem = self.problem
        at_slip = self.traction_bound
        if problem.slip_friction is not None and problem.variation is not None:
            at_slip = at_slip * problem.slip_friction.about_neutral(problem.variation)
        return edge_compliance(problem.covered, self.traction_bound, self.gradient, problem.leading, problem.variation,
                               self.options, at_slip)

    @cached_property
    def self_compliance(self) -> AnyArray:
        """∂u_x/∂x and ∂u_y/∂x of each element by its own traction, (2, n, m), in 1/Pa."""
        return np.array(self.gradient.self_gradient)[:, None, None] + self.border.diagonal

    @cached_property
    def rho(self) -> AnyArray:
        """ρ in Pa, (n, m). Over time a part of the slip is a displacement, which all elements of a row cause: with the
        compliance of a single one elements would change from one direction of slip to the other."""
        return np.asarray(self.options.relaxation / (self.self_compliance.mean(axis=0) + self._beside))

    @property
    def _beside(self) -> float:
        """What the other elements of a row add to the compliance of each, in 1/Pa: nothing where nothing is remembered."""
        return max(int(self.contact.sum(axis=0).max()) - 1, 0) * self.gradient.remembered if self.gradient.rate else 0.0

    @cached_property
    def free(self) -> tuple[int, ...]:
        return self.problem.free

    @cached_property
    def resolves_friction(self) -> bool:
        """Whether each τ + ρ s belongs to one slip on the law of friction, which then gives the bound (`_free_slip`): with the
        bound of the iterate's own slip, Newton's steps would be short where friction changes steeply."""
        friction = self.problem.slip_friction
        return isinstance(friction, SlipFriction) and friction.outweighed_by(self.rho, self.traction_bound)

    @cached_property
    def count(self) -> int:
        """Elements of the contact, at least 1."""
        return max(int(self.contact.sum()), 1)

    @cached_property
    def size(self) -> int:
        return self.traction_bound.size

    @cached_property
    def force_scale(self) -> float:
        """Scale of a sum of tractions in the residual."""
        return math.sqrt(self.count) / FORCE_WEIGHT

    @cached_property
    def reference(self) -> float:
        """2-norm of the expected tractions: the bound, or those of the creepage in full stick if that is less. Slip counts by
        the compliance of single elements."""
        problem = self.problem
        rigid = np.hypot(problem.rigid_slip[0], problem.rigid_slip[1])
        force_traction = math.hypot(*(f or 0.0 for f in problem.force)) / (self.count * problem.element_area)
        bound, friction = self.traction_bound, problem.slip_friction
        if friction is not None and not self.free:  # a slip is known, which is about this one
            bound = bound * friction.expected(rigid)
        expected = np.minimum(bound, STICK_TRACTION * rigid / self._element + force_traction)
        return float(np.linalg.norm(expected)) * self._element / (self._element + self._beside) or 1.0

    @cached_property
    def creepage_unit(self) -> float:
        """A creepage of the size that matters."""
        return float(self.traction_bound.sum()) / self.count * self._element or 1.0

    @cached_property
    def target(self) -> AnyArray:
        """Sums of the tractions for the prescribed forces."""
        return np.array([self.problem.force[i] / self.problem.element_area for i in self.free])  # type: ignore[operator]

    @property
    def _element(self) -> float:
        """Mean gradient of a uniformly loaded element."""
        return 0.5 * sum(self.gradient.self_gradient)

    # --- state ---------------------------------------------------------------------------------------------------

    def creepage(self, unknown: AnyArray) -> AnyArray:
        creep = np.zeros(2)
        creep[list(self.free)] = unknown * self.creepage_unit
        return creep

    def start(self, traction: AnyArray, creepage: tuple[float, float]) -> Iterate:
        """The iterate from `traction`, cut down to the largest bound of any slip, and the free creepages of `creepage`."""
        size, friction = np.hypot(traction[0], traction[1]), self.problem.slip_friction
        most = self.traction_bound * (1.0 if friction is None else friction.highest)
        shrink = np.where(size > most, most / np.where(size > 0.0, size, 1.0), 1.0)
        unknown = np.array([creepage[i] for i in self.free]) / self.creepage_unit
        traction = traction * (shrink * self.contact)
        return self._iterate(traction, unknown, self._slip_of(self.gradient(traction), traction, unknown))

    def finish(self, state: Iterate) -> tuple[Iterate, AnyArray, AnyArray, float, AnyArray]:
        """The last iterate with its slip recomputed (combined images accumulate rounding), the slip to report, (2, n, m), the
        power lost to the discretisation, (n, m), the sum of that lost inside bodies that relax, and the displacement in m,
        (2, n, m)."""
        gradient, dissipative, displacement = self.gradient.split(state.traction)
        slip = self._slip_of(gradient, state.traction, state.unknown)
        state = self._iterate(state.traction, state.unknown, slip)
        back = self._taken_at_borders(state.traction)
        stick = self.sticking(state)
        back = np.where(stick, 0.0, back)
        # Only the component along the traction: the compliance differs between x and y, and Coulomb's slip has none across.
        size = np.hypot(state.traction[0], state.traction[1])
        along = state.traction / np.where(size > 0.0, size, 1.0)
        back = along * (along * back).sum(axis=0)
        lost = (state.traction * (dissipative + block_product(self.border.k, state.traction) - back)).sum(axis=0)
        # The antisymmetric part of the difference formula conserves the power on elastic bodies.
        inside = float((state.traction * (gradient - dissipative)).sum()) if self.gradient.bodies.relaxes else 0.0
        return state, np.where(stick, 0.0, state.slip + back), lost, inside, displacement

    def _taken_at_borders(self, traction: AnyArray) -> AnyArray:
        """Slip by the compliance of the trailing border and of neutral lines, (2, n, m)."""
        back = self.border.trailing(traction)
        neutral = self.border.neutral
        return back if neutral is None else back + neutral * traction

    def _free_slip(self, slip: AnyArray, traction: AnyArray) -> tuple[AnyArray, AnyArray]:
        """Direction (2, n, m) of the traction, and size (n, m) along it of the slip that friction depends on, without that by
        border compliances: the slip of the iterate, zero if it is against the traction, or that at which the traction of the
        law, plus ρ times this slip, is |τ + ρ s| (the resolvent of the law). Both are the same in the solution."""
        trial = traction + self.rho * slip
        length = np.hypot(trial[0], trial[1])
        direction = trial / np.where(length > 0.0, length, 1.0)
        taken, friction = self._taken_at_borders(traction), self.problem.slip_friction
        if isinstance(friction, SlipFriction) and self.resolves_friction:
            total = length + self.rho * (direction * taken).sum(axis=0)
            size = friction.resolvent(total, self.rho, self.traction_bound)
        else:
            size = np.maximum((direction * (slip + taken)).sum(axis=0), 0.0)
        size = np.where(self.contact, size, 0.0)
        return np.where(size > 0.0, direction, 0.0), size

    def free_slip(self, state: Iterate) -> AnyArray:
        """Size of the relative slip that friction depends on, (n, m); zero where the surfaces stick."""
        return np.where(state.stick, 0.0, self._free_slip(state.slip, state.traction)[1])

    def sticking(self, state: Iterate) -> Mask:
        """Elements that stick, (n, m): below their bound, and not sliding both ways about a neutral line."""
        return np.asarray(state.stick & self.contact & ~self.border.crossed)

    def _slip_of(self, gradient: AnyArray, traction: AnyArray, unknown: AnyArray) -> AnyArray:
        slip = self.problem.rigid_slip - gradient
        slip -= block_product(self.border.k, traction)
        slip += self.creepage(unknown)[:, None, None]
        return slip

    def _iterate(self, traction: AnyArray, unknown: AnyArray, slip: AnyArray) -> Iterate:
        bound, sliding, response = self.traction_bound, None, None
        if self.problem.slip_friction is not None:
            sliding, size = self._free_slip(slip, traction)
            response = self.problem.slip_friction.response(size)
            bound = bound * response.factor
        residual, stick, scale, direction = self.natural_residual(traction, slip, bound)
        force = (traction.sum(axis=(1, 2))[list(self.free)] - self.target) / self.force_scale
        full = np.concatenate([residual.ravel(), force])
        return Iterate(traction, unknown, slip, full, stick, scale, direction,
                       length_of(full) / self.reference, bound, sliding, response)

    def natural_residual(
        self, traction: AnyArray, slip: AnyArray, bound: AnyArray
    ) -> tuple[AnyArray, Mask, AnyArray, AnyArray]:
        """τ − Proj(τ + ρ s) for fields (2, n, m), where elements stick, and of those that slip the factor of the projection
        and the direction of τ + ρ s."""
        trial = traction + self.rho * slip
        length = np.hypot(trial[0], trial[1])
        stick = length <= bound
        safe = np.where(stick, 1.0, length)
        scale = np.where(stick, 1.0, bound / safe)
        residual = traction - scale * trial
        residual *= self.contact
        return residual, stick, scale, np.where(stick, 0.0, trial / safe)

    def without_false_slip(self, state: Iterate) -> Iterate:
        """`state` with stick where only one or two elements, or rows, slip between sticking ones.

        Such slip is false: it moves downstream by an element per Newton step, and the residual falls by 1/N only. The norm is
        that of the residual with these elements sticking."""
        slip, stick = self.contact & ~state.stick, self.sticking(state)
        lone = _lone(slip, stick) | _lone(slip.T, stick.T).T
        if not lone.any():
            return state
        residual = state.residual.copy()
        tractions = residual[: 2 * self.size].reshape(2, *self.contact.shape)
        tractions[:, lone] = -(self.rho * state.slip)[:, lone]
        return replace(state, residual=residual, stick=state.stick | lone, scale=np.where(lone, 1.0, state.scale),
                       direction=np.where(lone, 0.0, state.direction), norm=length_of(residual) / self.reference)

    # --- one step ------------------------------------------------------------------------------------------------

    def step(self, state: Iterate, forcing: float) -> Iterate:
        linear = Linearisation(self, state)
        forcing = max(forcing, FINEST_FORCING)
        most = MOST_KRYLOV_STEPS if self.options.preconditioned else MOST_UNPRECONDITIONED
        solution = gmres(linear.expensive, linear.cheap, linear.precondition, -state.residual, forcing, most)
        shape = (2, *self.traction_bound.shape)
        n = 2 * self.size
        change, change_unknown = solution.step[:n].reshape(shape), solution.step[n:]
        change_slip = self.creepage(change_unknown)[:, None, None] - solution.image.reshape(shape)
        change_slip -= block_product(self.border.k, change)
        # Slip is affine in the traction, so a shorter step needs no convolution.
        length = self._longest(state.unknown, change_unknown)
        growth = GROWTH if self.problem.spots and state.norm > SETTLED else 1.0
        trials: list[Iterate] = []
        for _ in range(MOST_HALVINGS):
            trial = self._iterate(state.traction + length * change, state.unknown + length * change_unknown,
                                  state.slip + length * change_slip)
            trials.append(trial)
            if trial.norm <= (1.0 - SUFFICIENT_DECREASE * length) * growth * state.norm:
                return trial if growth > 1.0 else min(trials, key=lambda t: t.norm)
            length *= 0.5
        return min(trials, key=lambda t: t.norm)

    def _longest(self, unknown: AnyArray, change: AnyArray) -> float:
        """Longest step that at most doubles the free creepages: close to the friction limit the force hardly depends on them,
        and a full step could reach full sliding, where the gradient vanishes."""
        size = length_of(change)
        allowed = length_of(unknown) + UNSEEN_CREEPAGE
        return min(1.0, allowed / size) if size > allowed else 1.0


class Linearisation:
    """Element-wise 2×2 blocks of the generalised derivative, P dτ + Q (D A dτ + K dτ − dξ), and its preconditioner."""

    def __init__(self, newton: Newton, state: Iterate) -> None:
        self.newton, self.state = newton, state
        self.stick = state.stick & newton.contact
        self.slip = newton.contact & ~self.stick
        self._blocks()
        self._preconditioner()
        self._border_force()

    def _blocks(self) -> None:
        """P and Q, as xx, yy and xy of each element."""
        nx, ny = self.state.direction
        f = self.state.scale
        # Projection across the traction, I − n nᵀ, on slip elements; identity on stick elements.
        xx, yy, xy = f * (1.0 - nx * nx), f * (1.0 - ny * ny), -f * nx * ny
        self.p = tuple(np.where(self.slip, part, 0.0) for part in (1.0 - xx, 1.0 - yy, -xy))
        rho = self.newton.rho * self.newton.contact
        self.q = rho * xx, rho * yy, rho * xy

    def _preconditioner(self) -> None:
        """The `inner` elements, which are integrated along x, and the `local` inverse of all others, which depend most on their
        own traction."""
        newton, state, stick, slip = self.newton, self.state, self.stick, self.slip
        nx, ny = state.direction
        # Where a border, a neutral line or the end of an interlayer outweighs the element, its own traction decides its slip.
        border = stick & (np.abs(newton.border.diagonal).max(axis=0) > min(newton.gradient.self_gradient))
        own_x, own_y = newton.self_compliance
        own_along, own_across = own_x * nx * nx + own_y * ny * ny, own_x * ny * ny + own_y * nx * nx
        one = np.where(slip, 1.0, 0.0)
        along, steep = one, np.zeros_like(slip)
        if state.response is not None:
            # Decrease of the element's bound by its own traction, because that reduces the slip. If that is more than the
            # traction itself, the element almost sticks and is integrated, too.
            rise = newton.traction_bound * state.response.local
            self.share = 1.0 / (1.0 + rise / newton.rho) if newton.resolves_friction else np.ones_like(rise)
            along = one / (self.share * np.maximum(LEAST_STIFFNESS, 1.0 + rise * own_along))
            steep = slip & (rise * own_along > 1.0) & ~newton.border.partial
        across = one / np.where(slip, 1.0 - state.scale + state.scale * newton.rho * own_across, 1.0)
        stuck = np.where(stick, 1.0 / newton.rho, 0.0)
        self.local = (stuck / own_x + along * nx * nx + across * ny * ny, stuck / own_y + along * ny * ny + across * nx * nx,
                      along * nx * ny - across * nx * ny)
        self.inner = (stick & ~border) | steep
        self.starts = run_starts(self.inner)

    def _border_force(self) -> None:
        """Response of the preconditioner to each free creepage, for the bordered system."""
        newton = self.newton
        columns = []
        for i in newton.free:
            unit = np.zeros(2)
            unit[i] = newton.creepage_unit
            e = np.broadcast_to(unit[:, None, None], (2, *newton.traction_bound.shape))
            change = block_product(self.q, e)
            if self.state.response is not None and self.state.sliding is not None:
                # Where all slides, a force answers by friction that changes with slip alone.
                along = self.state.response.change((self.state.sliding * (self.share * e)).sum(axis=0))
                change += self.state.direction * (newton.traction_bound * along * self.slip)
            columns.append(self._invert(change))
        self.response = columns
        free = list(newton.free)
        if free:
            schur = np.array([[c[i].sum() for c in columns] for i in free]) / newton.force_scale
            # A zero response has no inverse: pinv maps zero to zero.
            self.schur_inverse = np.linalg.pinv(np.where(np.abs(schur) > NO_FORCE_RESPONSE, schur, 0.0))

    def expensive(self, v: AnyArray) -> AnyArray:
        n = 2 * self.newton.size
        return self.newton.gradient(v[:n].reshape(2, *self.newton.traction_bound.shape)).ravel()

    def cheap(self, v: AnyArray, image: AnyArray) -> AnyArray:
        newton = self.newton
        shape = (2, *newton.traction_bound.shape)
        n = 2 * newton.size
        change = v[:n].reshape(shape)
        inner = block_product(newton.border.k, change)
        inner += image.reshape(shape)
        if newton.free:
            inner -= newton.creepage(v[n:])[:, None, None]
        out = block_product(self.q, inner)
        out += block_product(self.p, change)
        if self.state.response is not None and self.state.sliding is not None:
            moved = newton._taken_at_borders(change) - inner
            if newton.resolves_friction:
                moved = self.share * (change / newton.rho + moved)
            along = (self.state.sliding * moved).sum(axis=0)
            bound = newton.traction_bound * self.state.response.change(along)
            out -= self.state.direction * (bound * self.slip)
        if not newton.free:
            return out.ravel()
        force = change.sum(axis=(1, 2))[list(newton.free)] / newton.force_scale
        return np.concatenate([out.ravel(), force])

    def _invert(self, r: AnyArray) -> AnyArray:
        out = block_product(self.local, r)
        gradient = out * np.where(self.inner, self.newton.self_compliance, 0.0)
        out *= ~self.inner
        out += self.newton.inverse(gradient, self.inner, self.starts)
        return out

    def precondition(self, v: AnyArray) -> AnyArray:
        newton = self.newton
        if not newton.options.preconditioned:
            return v
        n = 2 * newton.size
        change = self._invert(v[:n].reshape(2, *newton.traction_bound.shape))
        if not newton.free:
            return change.ravel()
        force = change.sum(axis=(1, 2))[list(newton.free)] / newton.force_scale
        unknown = self.schur_inverse @ (v[n:] - force)
        for u, column in zip(unknown, self.response, strict=True):
            change += float(u) * column
        return np.concatenate([change.ravel(), unknown])


def _lone(slip: Mask, stick: Mask) -> Mask:
    """Mask of one or two elements of `slip` between elements of `stick` along the first axis."""
    lone = np.zeros_like(slip)
    lone[1:-1] = slip[1:-1] & stick[:-2] & stick[2:]
    pairs = slip[1:-2] & slip[2:-1] & stick[:-3] & stick[3:]
    lone[1:-2] |= pairs
    lone[2:-1] |= pairs
    return lone
