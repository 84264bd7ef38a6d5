"""The table [history]: inputs that change over time, and what is not computed with it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from itertools import pairwise
from typing import Annotated, Any

from pydantic import Field

from thermoroll_cli.files.case_errors import Fault
from thermoroll_cli.files.case_line import LOAD, is_line, value_of
from thermoroll_cli.files.case_table import Allowed, Table
from thermoroll_cli.files.result.labelled import ResultFileError
from thermoroll_cli.files.result.outcome import read_result
from thermoroll_cli.many_contacts.history.course import (
    OF_WHEELSETS,
    SHIFTS,
    SPEED,
    VARIED,
    Begin,
    Course,
    History,
    WheelsetHistory,
    extreme_rows,
)
from thermoroll_cli.many_contacts.history.history_plan import FIRST
from thermoroll_cli.many_contacts.wheelset.wheelset_problem import WheelsetProblem
from thermoroll_cli.problem.geometry import Unsolvable
from thermoroll_cli.problem.problem import Problem
from thermoroll_cli.problem.result import Result

MOST_PLACES = 100000
RETURNING = ("heat that recirculates comes back a revolution later, and a history does not tell the revolutions before it",
             "without it; thermal.bulk_temperature_lower_K is how warm the body enters, and history.values may change it")
REFUSED = {**dict.fromkeys(("strength", "wear"), (
    "is not computed over time", "a case without it, or without [history]")),
    "thermal.lower": RETURNING, "thermal.upper": RETURNING}
"""Tables and keys that are not computed over time, with the reason and what is allowed."""
LARGEST_SHIFT = 1e15
"""Magnitude of a shift in µm, which no key outside a history has."""

Numbers = Annotated[list[float], Field(min_length=2, max_length=MOST_PLACES)]
STATES: dict[str, Begin] = {"steady": "steady", "pressed": "pressed"}
"""Words for states to begin with."""
BEGIN = Allowed('"steady", "pressed", or the result file of a contact, FILE.h5')
RISING = Allowed("2 or more numbers that rise; the same number twice is a jump")


class HistoryTable(Table):
    """A contact over time: what changes, and when."""

    distance_mm: Annotated[Numbers | None, RISING] = Field(default=None, description="Distances rolled, of values")
    time_s: Annotated[Numbers | None, RISING] = Field(default=None, description="Times, of values, instead of distance_mm")
    steps: int | None = Field(default=None, ge=1, le=MOST_PLACES,
                              description="Equal steps from the first place to the last; a row for each place if left out")
    file: str | None = Field(default=None, max_length=1000,
                             description="CSV file with distance_mm or time_s, and values, in place of them")
    fields_every: int = Field(default=0, ge=0, le=MOST_PLACES, description="Fields of every so manieth row are kept; 0: none")
    begin: Annotated[str | None, BEGIN] = Field(
        default=None, max_length=1000,
        description='The steady state (default), "pressed": no tractions yet (default at speed 0), or the result file FILE.h5')
    length_mm: float | None = Field(
        default=None, ge=1e-9, le=1e9, description="Length of a line contact: its displacements grow with the logarithm of it")
    values: Annotated[dict[str, list[float]], Allowed("lists of numbers by key, one for each place")] = Field(
        default={}, description="Values at the places, linear between them, of "
        f"{', '.join(VARIED)}; of a wheelset {', '.join(OF_WHEELSETS)}")


def history_faults(
    sections: Mapping[str, Any], history: HistoryTable,
    values_of: Callable[[Mapping[str, Any], HistoryTable], Iterator[Fault]],
) -> Iterator[Fault]:
    """What is wrong with a history, also with the values of its keys, and the keys that do not go with one."""
    for key, (why, allowed) in REFUSED.items():
        if value_of(sections, key):
            yield tuple(key.split(".")), why, allowed
    if history.begin and history.begin not in STATES and not history.begin.endswith(".h5"):
        yield ("history", "begin"), "is no state to begin with", BEGIN.words
    if (history.distance_mm is None) == (history.time_s is None):
        yield ("history",), "needs distance_mm or time_s", "one of them, or a file"
        return
    places = history.distance_mm or history.time_s or []
    name = "time_s" if history.distance_mm is None else "distance_mm"
    if any(other < one for one, other in pairwise(places)) or places[0] == places[-1]:
        yield ("history", name), "must rise", "numbers that rise; the same number twice is a jump"
    if any(one == other == third for one, other, third in zip(places, places[1:], places[2:], strict=False)):
        yield ("history", name), "has a number three times", "the same number twice is a jump"
    if is_line(sections) == (history.length_mm is None):  # which no other contact has
        why, allowed = ("is missing: displacements of a line contact grow with the logarithm of its length",
                        "the length of the contact in mm") if is_line(sections) else (
            "belongs to a line contact, but the load is not one per length", LOAD)
        yield ("history", "length_mm"), why, allowed
    yield from _friction(sections.get("friction"), sections.get("load"), history)
    uneven = {key: len(values) for key, values in history.values.items() if len(values) != len(places)}
    for key, count in uneven.items():
        yield ("history", "values"), f"{key} has {count} values for {len(places)} places", "one value for each place"
    if not uneven:
        yield from values_of(sections, history)


def _friction(friction: Any, load: Any, history: HistoryTable) -> Iterator[Fault]:
    """What is wrong with friction that depends on slip, or that changes."""
    coefficients = history.values.get("load.friction_coefficient", ())
    if coefficients and (friction is None or friction.law):
        yield ("history", "values"), "friction cannot change where it depends on slip", "a case without [friction]"
    if friction is None:
        return
    if friction.memory_um and history.begin and history.begin not in STATES:
        yield ("history", "begin"), "does not tell the memory of friction", '"steady" or "pressed", or no friction.memory_um'
    elif friction.law and not friction.memory_um:
        at_rest = (0.0 if load is None else load.friction_coefficient) or 0.0
        values = friction.coefficients if friction.table else [at_rest, *friction.coefficients]
        if any(other < one for one, other in pairwise(values)):
            yield (("friction", "law"), "falls with slip: over time it has no solution without memory",
                   "friction.memory_um above 0, or a law that does not fall")


def values_of_contact(sections: Mapping[str, Any], history: HistoryTable) -> Iterator[Fault]:
    """What is wrong with the values of keys of one contact, and with stresses below it."""
    rolling, below, path = sections.get("rolling"), sections.get("subsurface"), ("history", "values")
    if below is not None and not history.fields_every:
        yield ("history", "fields_every"), "keeps no fields: stresses below the surface are those of rows with fields", (
            "1 or more, or a case without [subsurface]")
    if below is not None and below.fields != "plane":
        yield ("subsurface", "fields"), "are not kept over time: there are the largest stresses of each row", "without it"
    for key, values in history.values.items():
        if key not in VARIED:
            yield path, f"{key} cannot change over time", ", ".join(VARIED)
        elif key in SHIFTS and max(map(abs, values)) > LARGEST_SHIFT:
            yield path, f"{key} is outside the allowed range", f"{-LARGEST_SHIFT:g} to {LARGEST_SHIFT:g}"
    speeds = history.values.get(SPEED) or ([] if rolling is None else [rolling.speed_m_s or 0.0])
    if history.distance_mm is not None and not all(speeds):
        yield ("history", "distance_mm"), "nothing is rolled at rolling.speed_m_s = 0", "time_s"
    given = [name for name in ("longitudinal", "lateral", "spin_rad_mm") if getattr(sections.get("creepage"), name, None)]
    creeps = [*(f"creepage.{name}" for name in given), *(key for key in history.values if key.startswith("creepage."))]
    for key in [] if any(speeds) else creeps:
        yield path if key in history.values else tuple(key.split(".")), (
            f"{key} is slip over the rolling speed, and nothing rolls" if key in history.values else
            "is slip over the rolling speed, and nothing rolls"), "shift.longitudinal_um, shift.lateral_um, or a force"
    if any(speeds) and any(len({*history.values.get(key, [])}) > 1 for key in SHIFTS) and SPEED not in history.values:
        yield path, "shifts happen without rolling", "rolling.speed_m_s = 0, or creepages"


def extremes(history: HistoryTable) -> dict[int, dict[str, float]]:
    """The values of the keys of a case, by key, at the places (numbers from 0) where one of them is least or largest: what is
    right there is so at all places, for a key allows a range."""
    given = {key: values for key, values in history.values.items() if key not in SHIFTS}
    return {number: {key: values[number] for key, values in given.items()} for number in extreme_rows(given)}


def wheelset_over_time(table: HistoryTable, problem: WheelsetProblem) -> WheelsetHistory:
    """The history that a table describes of a wheelset. Raises Unsolvable where it begins with a result of something else."""
    keys = {key: key in table.values for key in OF_WHEELSETS}
    problem = replace(
        problem, finds_roll=problem.finds_roll and not keys["wheelset.roll_mrad"],
        finds_speed=problem.finds_speed and not keys["wheelset.angular_velocity_rad_s"],
        vertical=None if keys["wheelset.height_mm"] else problem.vertical)
    numerics = problem.contact.numerics
    numerics = replace(numerics, grid=numerics.grid or (FIRST, FIRST), accuracy=None)
    problem = replace(problem, contact=replace(problem.contact, numerics=numerics))
    values = {key: tuple(table.values[key]) for key in OF_WHEELSETS if key in table.values}
    begin = STATES.get(table.begin or "steady") or _result_in(str(table.begin), problem.kind)
    return WheelsetHistory(problem, _course(table, values, begin))


def contact_over_time(table: HistoryTable, problem: Problem) -> History:
    """The history that a table describes of a contact. Raises Unsolvable where it begins with a result of something else."""
    still = table.values.get(SPEED, [problem.motion.speed])[0] == 0.0
    values = {key: tuple(table.values[key]) for key in VARIED if key in table.values}
    begin = STATES.get(table.begin or ("pressed" if still else "steady")) or _result_in(str(table.begin))
    problem = replace(problem, length=math.inf if table.length_mm is None else 1e-3 * table.length_mm)
    return History(problem, _course(table, values, begin))


def _course(table: HistoryTable, values: dict[str, tuple[float, ...]], begin: Begin) -> Course:
    places = tuple(1e-3 * place for place in table.distance_mm or ()) or tuple(table.time_s or ())
    return Course(places, values, table.distance_mm is not None, table.steps, begin, table.fields_every)


def _result_in(path: str, assembly: str = "") -> Result:
    """The result in the file at `path`, of a contact or of an `assembly` with tractions. Raises Unsolvable."""
    try:
        result = read_result(path)
    except ResultFileError as cause:
        raise Unsolvable(str(cause), "history.begin", BEGIN.words) from None
    contacts = [patch for patch in result.patches if isinstance(patch, Result)] if assembly else [result]
    if result.assembly != assembly or not all({"pressure", "shear_x", "shear_y"} <= {*each.fields} for each in contacts):
        raise Unsolvable(f"{path} has no tractions of a {assembly or 'contact'}", "history.begin", BEGIN.words)
    return result
