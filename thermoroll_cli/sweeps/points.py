"""The points of a sweep, each a checked problem, and the stretches in which they are solved."""

from __future__ import annotations

import dataclasses
import itertools
import json
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache

from thermoroll_cli.files.case import Case, CaseError, Finding, Override
from thermoroll_cli.files.case_source import CaseSource, parse_source
from thermoroll_cli.interruption import safe_point
from thermoroll_cli.problem.problem import Problem
from thermoroll_cli.sweeps.axis import Axis, Number

LONGEST_STRETCH = 5
"""Points that start from each other. More save nothing that can be measured; fewer leave work for more processes, and
less to solve again where a sweep is resumed."""


@dataclass(frozen=True)
class Point:
    """One combination: its `number` (from 1) in the sweep, the `name` of its result file without .h5, the swept
    `values`, and the case. Plain enough to be sent to a process that has read no case file."""

    number: int
    name: str
    values: tuple[Number, ...]
    problem: Problem
    case_text: str
    case_json: str

    @property
    def identity(self) -> str:
        return identity(self.case_json)


@dataclass(frozen=True)
class Stretch:
    """Neighbouring points, solved one after the other by one worker.

    `finished` points have their files already; they are solved again, and not written, only to start the next point from
    them, so that its result is the same as if nothing had been interrupted. `given_up` points are left out: they kill
    the process that solves them.
    """

    points: tuple[Point, ...]
    finished: frozenset[int] = frozenset()
    given_up: frozenset[int] = frozenset()

    @property
    def pending(self) -> tuple[Point, ...]:
        return tuple(p for p in self.points if p.number not in self.finished | self.given_up)


def identity(case_json: str) -> str:
    """What tells whether two resolved cases are the same: all that enters the result, whatever order it is written in.

    Raises ValueError for text that is no JSON object."""
    content = json.loads(case_json)
    if not isinstance(content, dict):
        raise ValueError("not a resolved case")
    content.pop("output", None)
    return json.dumps(content, sort_keys=True)


@dataclass(frozen=True)
class PointMaker:
    """Makes the points of a sweep one by one, so that a hundred thousand of them need not be held at once.

    The values of `axes` are put into the case `text` (read from `source`) after `settings`; the last axis varies fastest.
    Points are called `stem` and their number. Plain enough to be sent to another process."""

    text: str
    source: str
    stem: str
    axes: tuple[Axis, ...]
    settings: tuple[Override, ...] = ()

    @property
    def shape(self) -> tuple[int, ...]:
        return tuple(len(axis.values) for axis in self.axes)

    @property
    def count(self) -> int:
        return math.prod(self.shape)

    def values(self, number: int) -> tuple[Number, ...]:
        """The swept values of the point `number` (from 1)."""
        rest, values = number - 1, []
        for axis in reversed(self.axes):
            rest, index = divmod(rest, len(axis.values))
            values.append(axis.values[index])
        return tuple(reversed(values))

    def name(self, number: int) -> str:
        return f"{self.stem}_{number:0{max(4, len(str(self.count)))}d}"

    def point(self, number: int) -> Point:
        """The checked point `number`. Raises CaseError, which names --over where a swept value is to blame."""
        values = self.values(number)
        swept = [Override(a.path, v, f"{a.key}={v!r}") for a, v in zip(self.axes, values, strict=True)]
        try:
            case = Case.from_source(_parsed(self.text, self.source).overridden([*self.settings, *swept]), self.source)
        except CaseError as cause:
            raise CaseError([_blame(finding, swept) for finding in cause.findings]) from None
        return Point(number, self.name(number), values, case.problem, case.text, case.to_json())

    def points(self) -> Iterator[Point]:
        """All points. Raises CaseError at the end, with the errors of all of them, each told once."""
        findings: dict[tuple[str, str, str], Finding] = {}
        for number in range(1, self.count + 1):
            safe_point()
            try:
                yield self.point(number)
            except CaseError as cause:
                # What is wrong with a key rather than its value is wrong at every point.
                new = ((f.key, f.message, f.value) for f in cause.findings)
                findings |= {key: f for key, f in zip(new, cause.findings, strict=True) if key not in findings}
        if findings:
            raise CaseError(list(findings.values()))


@lru_cache(maxsize=1)
def _parsed(text: str, source: str) -> CaseSource:
    return parse_source(text, source)


def make_points(
    text: str, source: str, stem: str, axes: Sequence[Axis], settings: Sequence[Override] = ()
) -> tuple[Point, ...]:
    """All points of a sweep (see `PointMaker`). Raises CaseError with the errors of all points, each told once."""
    return tuple(PointMaker(text, source, stem, tuple(axes), tuple(settings)).points())


def _blame(finding: Finding, swept: Iterable[Override]) -> Finding:
    for override in swept:
        if finding.source == f"--set {override.text}":
            return dataclasses.replace(finding, source=f"--over {override.text}")
    return finding


def stretches(points: Sequence[Point], axes: Sequence[Axis]) -> list[Stretch]:
    """Divide `points` into stretches (see `stretch_numbers`)."""
    return [Stretch(tuple(points[number - 1] for number in numbers)) for numbers in stretch_numbers(axes)]


def stretch_numbers(axes: Sequence[Axis]) -> Iterator[range]:
    """The numbers of the points of each stretch: along the axis that varies fastest, none longer than `LONGEST_STRETCH`."""
    # Axes of one value do not vary.
    row = next((len(axis.values) for axis in reversed(axes) if len(axis.values) > 1), 1)
    parts = -(-row // LONGEST_STRETCH)
    ends = [row * part // parts for part in range(parts + 1)]
    for first in range(1, math.prod(len(axis.values) for axis in axes) + 1, row):
        for start, end in itertools.pairwise(ends):
            yield range(first + start, first + end)
