"""The populations of `make stress`: each has a generator, which makes the case of a seed, and a check, which solves it."""

from __future__ import annotations

import contextlib
import itertools
import pathlib
import resource
import signal
import traceback
import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from types import FrameType
from typing import Any

import numpy as np

from scripts.stress import (
    bearings,
    conicities,
    courses,
    fits,
    neighbours,
    outlines,
    profile_files,
    service,
    tracks,
    wear,
    wheelsets,
)
from scripts.stress.checks import distinct, narrow, patches, same_elsewhere, solved
from scripts.stress.coverage import covered, covered_beyond
from scripts.stress.outcome import Outcome
from scripts.stress.random_cases import StressCase, stress_case
from scripts.stress.random_conformal import agrees, random_pair
from scripts.stress.random_contacts import random_contact
from scripts.stress.random_friction import (
    random_friction,
    random_from_zero,
    random_history,
    random_rising,
    random_steps,
    random_strength,
    random_yield,
)
from scripts.stress.random_grids import few_depths, slender_grid
from scripts.stress.random_layers import random_hot_layers, random_layers
from scripts.stress.random_lines import random_line, random_line_of_bodies
from scripts.stress.random_profiles import (
    AWKWARD,
    NARROW,
    ROUGH,
    SHARP,
    friction_across,
    profile_on_a_grid,
    random_profile_contact,
    shifted_profile,
)
from scripts.stress.random_relaxing import random_relaxing
from thermoroll_cli import CaseError
from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.problem.problem import Numerics, Problem, SubsurfaceRequest

GRID = 32
"""Elements per side, for generators that leave the grid open."""


@dataclass(frozen=True)
class Population:
    """`draw` makes the case of a seed, always the same; `check` solves it, and if it compares grids it takes them as further
    arguments; `cases` are drawn by default. A case that takes more than `limit` seconds of processor time is broken."""

    draw: Callable[[int], Any]
    check: Callable[..., Outcome]
    cases: int
    limit: float = 60.0


def _on_the_grid(draw: Callable[[int], Problem]) -> Callable[[int], Problem]:
    return lambda seed: replace(draw(seed), numerics=Numerics((GRID, GRID)))


def _coated(seed: int) -> Problem:
    """Every fourth with stresses below the surface, and every fourth with heat."""
    problem = random_hot_layers(seed) if seed % 4 == 2 else random_layers(seed)
    return replace(problem, subsurface=SubsurfaceRequest() if seed % 4 == 0 else None)


def _profile(problem: Problem) -> Outcome:
    return solved(problem, patches)


def _contact(case: StressCase) -> Outcome:
    outcome = solved(case.problem)
    return replace(outcome, excused=outcome.excused or not case.below_limit)


def _at_an_approach(seed: int) -> StressCase:
    """A contact with its Hertzian approach, up to doubled or halved, in place of its load, which must be able to transmit its
    forces. A heat source that rests lifts bodies by a constant that nothing decides."""
    factor = 2.0 ** np.random.default_rng([41, seed]).uniform(-1.0, 1.0)
    for case in (stress_case(number) for number in itertools.count(910000 + seed, 100000)):
        if case.problem.heating.heat and case.problem.heating.peclet == "stationary":
            continue
        with contextlib.suppress(CaseError):
            approach = DerivedQuantities(case.problem).scales.approach * factor
            given = case.case.with_values({"load.approach_um": 1e6 * approach})
            return replace(case, case=given, problem=given.problem)
    raise AssertionError


def _covered_contact(case: StressCase, *grids: int) -> Outcome:
    return covered(case.problem, *grids) if case.below_limit else Outcome(reason="beyond the limit", excused=True)


def _covered_on_its_grid(problem: Problem, *_: int) -> Outcome:
    assert problem.numerics.grid is not None
    return covered(problem, problem.numerics.grid)


POPULATIONS = {
    "contacts": Population(stress_case, _contact, 2400),
    "profiles": Population(profile_on_a_grid, _profile, 200),
    "awkward profiles": Population(lambda seed: profile_on_a_grid(seed, AWKWARD), _profile, 200),
    "kinks and ends": Population(lambda seed: profile_on_a_grid(seed, SHARP), _profile, 200),
    "ridges": Population(lambda seed: profile_on_a_grid(seed, NARROW), lambda case: solved(case, patches, narrow), 200),
    "conformal pairs": Population(random_pair, agrees, 200),
    "falling friction": Population(_on_the_grid(random_friction), lambda problem: solved(problem, distinct), 200),
    "offsets": Population(shifted_profile, same_elsewhere, 200),
    "friction across": Population(friction_across, _profile, 200),
    "friction from zero": Population(_on_the_grid(random_from_zero), solved, 200),
    "rising friction": Population(_on_the_grid(random_rising), solved, 200),
    "yielding interlayers": Population(_on_the_grid(random_yield), solved, 200),
    "coatings": Population(_on_the_grid(_coated), solved, 200),
    "bodies that relax": Population(_on_the_grid(random_relaxing), solved, 200),
    "line contacts": Population(_on_the_grid(random_line), lambda problem: solved(problem, distinct), 200),
    "line contacts of coated or relaxing bodies": Population(
        _on_the_grid(random_line_of_bodies), lambda problem: solved(problem, distinct), 200),
    "wear": Population(wear.worn_contact, wear.check, 40, limit=300.0),
    "wear at an approach": Population(wear.worn_at_an_approach, wear.check_approach, 40, limit=300.0),
    "wear in service": Population(service.in_service, service.check, 40, limit=600.0),
    "given approaches": Population(_at_an_approach, _contact, 200),
    "wheelsets": Population(wheelsets.random_wheelset, wheelsets.check, 200, limit=120.0),
    "tread and flange": Population(wheelsets.tread_and_flange, wheelsets.check, 200, limit=120.0),
    "displaced wheelsets": Population(wheelsets.displaced, wheelsets.check, 200, limit=60.0),
    "conicities": Population(conicities.random_track, conicities.check, 200),
    "worn conicities": Population(conicities.worn_track, conicities.check_worn, 200),
    "worn wheelsets": Population(wheelsets.worn_wheelset, wheelsets.check, 200, limit=120.0),
    "moved rails": Population(wheelsets.moved_rails, wheelsets.check, 200, limit=120.0),
    "rollers": Population(wheelsets.on_rollers, wheelsets.check, 200, limit=120.0),
    "wrong references": Population(wheelsets.wrong_reference, wheelsets.check_reference, 200, limit=120.0),
    "files of profiles": Population(profile_files.random_file, profile_files.check, 200),
    "damaged files of profiles": Population(profile_files.damaged_file, profile_files.check_damaged, 1000),
    "tracks that change": Population(tracks.random_track, tracks.check, 40, limit=120.0),
    "odd outlines": Population(outlines.random_outline, outlines.check, 200, limit=120.0),
    "bearings": Population(bearings.random_bearing, bearings.check, 40, limit=300.0),
    "contacts over time": Population(courses.random_course, courses.check, 100, limit=120.0),
    "heat over time": Population(courses.warm_course, courses.check, 40, limit=300.0),
    "line contacts over time": Population(courses.line_course, courses.check, 100, limit=120.0),
    "few rows and ends over time": Population(courses.odd_course, courses.check, 100, limit=120.0),
    "wheelsets over time": Population(
        lambda seed: (wheelsets.over_time(seed), seed), lambda drawn: wheelsets.check_over_time(*drawn), 100, limit=300.0),
    "neighbours": Population(neighbours.neighbours, neighbours.check, 100),
    "fits of two values": Population(lambda seed: fits.random_curve(seed, 2), fits.covered, 200),
    "fits of three values": Population(lambda seed: fits.random_curve(seed, 3), fits.covered, 200),
    "coverage of slender grids": Population(slender_grid, _covered_on_its_grid, 40, 300.0),
    "coverage of few depths": Population(few_depths, covered, 40, 300.0),
    "coverage of random contacts": Population(random_contact, covered, 40, 300.0),
    "coverage of contacts": Population(lambda seed: stress_case(810000 + seed), _covered_contact, 40, 300.0),
    "coverage of profiles": Population(random_profile_contact, covered, 40, 300.0),
    "coverage of rough profiles": Population(lambda seed: random_profile_contact(seed, ROUGH), covered, 40, 300.0),
    "coverage below the surface": Population(
        lambda seed: replace(random_contact(50000 + seed), subsurface=SubsurfaceRequest()), covered, 40, 300.0),
    "coverage of falling friction": Population(random_friction, covered, 40, 300.0),
    "coverage of steps of friction": Population(random_steps, covered, 40, 300.0),
    "coverage of strength and wear": Population(random_strength, covered, 40, 300.0),
    "coverage of histories": Population(random_history, covered_beyond, 40, 300.0),
    "coverage over time": Population(courses.random_course, courses.covered, 40, 300.0),
    "coverage of line contacts over time": Population(courses.line_course, courses.covered, 40, 300.0),
    "coverage of surfaces over time": Population(courses.rough_course, courses.covered, 40, 300.0),
    "coverage of heat over time": Population(courses.warm_course, courses.covered, 15, 300.0),
    "coverage of wheelsets over time": Population(wheelsets.over_time, wheelsets.covered_over_time, 40, 900.0),
    "coverage of bearings": Population(bearings.random_bearing, bearings.covered, 40, 900.0),
    "coverage of line contacts": Population(random_line, covered, 100, 60.0),
    "coverage of line contacts of coated or relaxing bodies": Population(random_line_of_bodies, covered, 60, 60.0),
    "coverage below line contacts": Population(
        lambda seed: replace(random_line(seed), subsurface=SubsurfaceRequest()), covered, 40, 300.0),
    "coverage of coatings": Population(random_layers, covered, 40, 300.0),
    "coverage of bodies that relax": Population(random_relaxing, covered, 40, 300.0),
    "coverage of heat through coatings": Population(random_hot_layers, covered, 40, 300.0),
    "coverage of stresses in coatings": Population(
        lambda seed: replace(random_layers(seed), subsurface=SubsurfaceRequest()), covered, 40, 300.0),
}


class OutOfTime(BaseException):
    """No `Exception`, so that no solver takes it for a fault of its own."""


def run_seed(name: str, seed: int, grids: tuple[int, ...] = ()) -> Outcome:
    """Draw the case of `seed` of a population and check it, on `grids` if these are compared; warnings of libraries count as
    crashes."""
    population, start = POPULATIONS[name], _processor_seconds()
    before = signal.signal(signal.SIGPROF, _out_of_time)
    signal.setitimer(signal.ITIMER_PROF, population.limit)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            outcome = population.check(population.draw(seed), *(grids if name.startswith("coverage") else ()))
    except (Exception, OutOfTime) as cause:
        place = traceback.extract_tb(cause.__traceback__)[-1]
        outcome = Outcome(broken=(f"{type(cause).__name__}: {cause} ({pathlib.Path(place.filename).name}:{place.lineno})",))
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)
    return replace(outcome, population=name, seed=seed, seconds=_processor_seconds() - start)


def _out_of_time(number: int, frame: FrameType | None) -> None:
    raise OutOfTime("not done within the time of its population")


def _processor_seconds() -> float:
    """Processor seconds of this process and of those that it started and that have ended."""
    used = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(each.ru_utime + each.ru_stime for each in used)
