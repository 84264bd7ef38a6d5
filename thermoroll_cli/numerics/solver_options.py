"""Every number that steers the solvers, with the reason for its value. A case never needs another one; experiments do.

What belongs to a formula (difference coefficients, quadrature) stays with it, unless experiments replace it.
"""

from __future__ import annotations

from dataclasses import dataclass

UPSTREAM_WEIGHTS = (0.7 / 6 + 0.3 / 2, -0.7 - 0.3 * 2, 0.7 / 2 + 0.3 * 3 / 2, 0.7 / 3)
"""∂u/∂x over u at rows −2 … 1, times dx: 0.7 of the third-order and 0.3 of the second-order upstream formula. Their errors in
the dissipated heat have opposite signs, and both damp odd–even modes: Re D̂ = 0.7·(1−cos θ)²/3 + 0.3·(1−cos θ)² ≥ 0, so D A is
monotone (docs/numerics.md)."""


@dataclass(frozen=True)
class NormalOptions:
    """Active sets and conjugate gradients of the normal problem."""

    first_reduction: float = 0.1
    """By how much the gap is closed on an active set before the set is looked at: the first sets are far off."""
    solved_share: float = 0.5
    """Conjugate gradients go on to this part of the tolerance, so that adding nothing to the set ends the iteration."""
    patience: int = 8
    """Active sets without fewer changes after which elements are only dropped: two may swap for ever on a symmetric border."""
    border_passes: int = 3
    """Times that elements under tension are dropped after the border was resolved, before whole elements are kept after all."""
    border_iterations: int = 60
    """Conjugate gradients per such pass, which start from the solution with whole elements."""


@dataclass(frozen=True)
class HeatedContactOptions:
    """How the active sets and the steps in heat are chosen."""

    most_active_sets: int = 30
    """Active sets tried for one heat. A step that is not too large takes three to eight."""
    most_iterations: int = 120
    """GMRES steps per active set: four to eight are usual."""
    wandering: float = 0.3
    """A step is given up when an active set wants to grow by this part of itself at the same time as it shrinks: it began with
    a contact that is too large for its heat."""
    reduction: float = 1e-3
    """By how much the gap on one active set is closed before the set is looked at."""
    growth: float = 1.5
    """A step in heat that was found lets the next one be so much longer; one that was not is halved."""
    smallest_step: float = 1.0 / 256.0
    """Part of the heat below which a step is not halved any more: there is no steady state beyond."""
    most_applications: int = 1000
    """Applications of A − E after which the heat is not raised any further: one to four hundred take it to where it gets."""
    on_the_way: float = 1e-4
    """Residual at which states on the way are solved, relative to the elastic displacement."""


@dataclass(frozen=True)
class RollingOptions:
    """Newton's method for the tangential problem, its linear systems, and what it knows of borders inside elements."""

    difference_weights: tuple[float, float, float, float] = UPSTREAM_WEIGHTS
    relaxation: float = 0.35
    """ρ is this fraction of the inverse of an element's own compliance. A much larger ρ lets elements alternate between stick
    and slip without end: near the kink the natural residual then measures the slip and no longer the traction."""
    stick_traction: float = 1.0
    """Traction that a creepage causes in full stick, in units of creepage over an element's own compliance; from below."""
    unseen_creepage: float = 2.0
    """Free creepages may begin with steps of this many units (the creepage that saturates a single element)."""
    force_weight: float = 20.0
    """A prescribed force is met so many times more closely than the tractions are: it is compared with what was asked for."""
    force_tolerance: float = 0.4
    """Where a force is prescribed tractions are solved to this part of their tolerance: creepages amplify what is left."""
    most_newton_steps: int = 40
    most_krylov_steps: int = 60
    """Preconditioned systems take about ten, on any grid."""
    most_halvings: int = 10
    loosest_forcing: float = 0.1
    """Each Newton step is solved at least this well."""
    forcing_share: float = 0.9
    """Share of the square of the last gain to which the next step is solved (Eisenstat & Walker 1996, choice 2)."""
    slow: float = 0.6
    """A Newton step that leaves more than this of the residual may only move false slip along: it is looked for then."""
    no_help: float = 0.95
    """What a step without such slip has to leave less of for another one like it."""
    sufficient_decrease: float = 1e-4
    """Part of the step's length by which the residual must fall (Armijo's rule, its usual value)."""
    finest_forcing: float = 30.0
    """A linear system is solved down to this many rounding errors at most."""
    stick_forcing: float = 1e-2
    """Full stick is only a start: solved this well."""
    unbounded: float = 1e8
    """Times the traction bound: nothing slips."""
    single_suffices: float = 1e-6
    """Down to this tolerance the linear systems are solved in single precision: half the memory to move."""
    refinable: float = 1e-2
    """A residual that grew when computed afresh, but no further than this, is iterated on."""
    preconditioned: bool = True
    """Whether linear systems are preconditioned with the inverse of D A on the stick area."""
    smallest_cover: float = 1e-3
    """Thinner slivers carry less than 1e-4 of an element's load; a larger compliance would only lose digits."""
    deepest: float = 0.117
    """Most that the known gradient at the leading edge falls below the operator's, in units of Σ(1−ν)/G along x and Σ1/G
    along y: on elements that the border just touches. Infinite: nothing is taken from the known gradient."""
    leading_ring: int = 2
    """Elements that the error of the border reaches; further in, sticking tractions are no longer shaped like the pressure."""
    leading_known: bool = True
    """Whether the gradient at the leading edge is taken as known at all."""


@dataclass(frozen=True)
class Tolerances:
    """Relative: residual of the tractions, residual gap over approach, change of what acts back on the contact.

    Far below the discretisation error of any grid: a residual r moves forces and heat by r/3 at most."""

    tangential: float = 1e-5
    normal: float = 1e-7
    coupling: float = 3e-6

    def times(self, factor: float) -> Tolerances:
        """All of them looser by `factor`."""
        return Tolerances(factor * self.tangential, factor * self.normal, factor * self.coupling)


@dataclass(frozen=True)
class FixedPointOptions:
    """How the fixed point is iterated. The defaults are those of heat, which may move the surfaces by half of the approach."""

    depth: int = 8
    """Turns that Anderson's mixing remembers: the turns are not solved so closely that more would gain anything. Strong heat of
    contacts that partly stick needs them: the article's case goes to twice the speed that it does with four."""
    first_damping: float = 0.7
    """Part of the first change that is taken: a bulge and its pressure push each other further than they end up."""
    max_turns: int = 60
    """The last state below the thermo-elastic limit took 44; beyond it no number of turns would do."""
    first_residual: float = 0.1
    """Residual that the first turn counts with. A start from a coarser grid is closer, and mixing learns nothing from turns
    that are solved less closely than they change: with 1 the exact case at 11.28 W takes 276 transforms, with 0.1 it
    takes 173."""
    tangential_share: float = 0.05
    """Residual of the tractions over that of the fixed point: heat follows the tractions one to one, and the mixing must not
    take what is left of their residual for a change."""
    normal_share: float = 1e-3
    """The same of the gap. It is cheap, and an open gap at the border adds or drops elements there."""
    last_turn: float = 10.0
    """From this many times the tolerance the next turn is expected to reach it: its tractions are solved to the end."""
    few_turns: int = 60
    """From this turn on each may be the last."""
    loosest: float = 1e-2
    """No turn solves its tractions less closely: stick and slip would not yet be those of a solution."""
    patience: int = 20
    recent: int = 12
    gain: float = 0.5
    """An iteration stagnates if after `patience` turns the `recent` ones have not brought the residual below `gain` times the
    least one before them. Close to the thermo-elastic limit a dozen turns may pass without any gain."""
    close: int = 4
    """The same number of turns where the residual is below what is accepted then: nothing but elements of the border that come
    and go is left."""
    dampings: int = 5
    """How often falling friction may be damped to transmit a prescribed force, before there is no steady state: each time half
    of what it has in reserve is lost."""
    unbalanced: int = 2
    """How often a turn may find no pressure in balance with its heat: the first turns have the slip of another contact."""
    raised: int = 4
    """How often the heat may be raised from none for that: later turns should begin with the pressure of the last."""
    closest_balance: float = 1e-8
    """Residual, over the elastic displacement, below which no pressure in balance with its heat is solved."""
    indifferent: float = 10.0
    """Times the tolerance: the residual that is accepted where no further turn reduces it, still below 1e-4 of the approach."""
    border_element: float = 0.3
    """The same for dissimilar bodies, over N²: an element of the border that comes and goes with the shear beneath it moves the
    surfaces by less than its share of the contact, 4/(πN²)·(extent/2)²."""
    heated_element: float = 2.0
    """The same for heat, over the variation of the expansion and the elements of the contact: they come and go in pairs, one on
    either side."""


SHEAR = FixedPointOptions(first_damping=1.0, first_residual=2e-4, tangential_share=2.0, few_turns=6, patience=11, recent=6,
                          gain=0.7)
"""Shear between dissimilar bodies moves the surfaces by a few per cent of the approach at most: a turn gains a factor of ten or
more from the first on, its tractions matter to a few per cent, and what has not converged in a dozen turns wavers between
elements of the border."""


@dataclass(frozen=True)
class RefinementOptions:
    """The sequence of grids, and when it ends."""

    coarsest: int = 8
    """Elements per side of the coarsest grid, twice as many where three grids are left without it: the Hertz contact is 7 wide,
    enough for a first guess."""
    finest_for_accuracy: int = 512
    """Largest grid where an accuracy is asked for: the next one takes more than 2 GB."""
    smallest_extent: float = 2.1
    """The Hertz contact spans 2 semi-axes; a domain must leave a little room around it."""
    largest_extent: float = 12.0
    growth: float = 1.25
    """Factor by which the domain grows when the contact reaches its rim."""
    most_moves: int = 8
    """Domains that are tried on one grid to follow a heated contact; one that proves too small is left after a few turns."""
    least_cover: float = 0.3
    """Elements that the isothermal contact covers by less start without pressure between dissimilar bodies: the solver adds an
    element more readily than it drops one."""
    first_guess: float = 1e-2
    """Residual at which tractions under the isothermal pressure are good enough for what acts back to start from."""
    coarse_tolerance: float = 3.0
    """Factor by which coarser grids are solved less closely: less work, and neither finest grid nor estimates notice."""
    share_of_accuracy: float = 0.03
    """Where an accuracy is asked for any grid may turn out to be the last: its residual must not show in the estimates."""
    normal_share_of_shear: float = 0.1
    """Residual gap over the residual of the tractions between dissimilar bodies: elements of the border come and go with the
    shear, so that a closer pressure gains nothing."""
    sequence: bool = True
    """Whether coarser grids are solved first. They give the start, the estimates and the extrapolation."""
    extrapolated: bool = True
    """Whether integrals are extrapolated from the last three grids."""


@dataclass(frozen=True)
class LimitOptions:
    """The search for the largest speed that has a steady state, where the wanted one has none."""

    coarse: tuple[int, int] = (32, 32)
    """Grid of the search: fine enough that the limit moves by less than the last step of the bracket on finer ones."""
    lowered_by: float = 4.0
    """Factor by which speed is lowered until there is a state. Then it is raised by this factor at most."""
    lowerings: int = 9
    """Speeds down to 1/260000 of the wanted one are tried; 0: nothing is searched for."""
    resolution: float = 0.02
    """Part of the speed by which it is no longer raised."""
    attempts: int = 12
    """Speeds tried on the way up at most."""
    retreats: tuple[float, ...] = (1.0, 0.95, 0.8)
    """Parts of that speed tried on the wanted grid, which may have its limit a little earlier."""
    raised_by: float = 1.12
    """From there the speed is raised by this factor, each state begun with the one before; by its root after a failure."""
    raises: int = 6
    """Times that it is: to twice the speed that was found from a cold start at most."""
    most_work: float = 5.0
    """Work of raising the speed over that of the state that it began with: from then on it is not raised any more."""
    most_moves: int = 6
    """As in `RefinementOptions`, for the search: starts are close, and what fails is given up."""


@dataclass(frozen=True)
class SolverOptions:
    """All of them. `heat` and `shear` are for fixed points with and without heat acting back."""

    tolerances: Tolerances = Tolerances()
    normal: NormalOptions = NormalOptions()
    heated_contact: HeatedContactOptions = HeatedContactOptions()
    rolling: RollingOptions = RollingOptions()
    heat: FixedPointOptions = FixedPointOptions()
    shear: FixedPointOptions = SHEAR
    refinement: RefinementOptions = RefinementOptions()
    limit: LimitOptions = LimitOptions()
    whole_elements: bool = False
    """Hertz's pressure at the centres of whole elements, as CONTACT takes it, instead of its averages over covered parts."""
