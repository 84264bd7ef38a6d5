"""The points of a sweep, each a checked problem, and the stretches in which they are solved."""

from __future__ import annotations

import dataclasses
import itertools
import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from thermoroll_cli.files.case.case import Case, CaseError, Finding, Override
from thermoroll_cli.model.problem import Problem
from thermoroll_cli.sweep.axis import Axis, Number

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


def make_points(
    text: str, source: str, stem: str, axes: Sequence[Axis], settings: Sequence[Override] = ()
) -> tuple[Point, ...]:
    """All combinations of the values of `axes` put into the case `text` (read from `source`) after `settings`; the last
    axis varies fastest. Files are called `stem` and the point's number.

    Raises CaseError with the errors of all points, each told once.
    """
    combinations = list(itertools.product(*(axis.values for axis in axes)))
    digits = max(4, len(str(len(combinations))))
    points: list[Point] = []
    findings: dict[tuple[str, str, str], Finding] = {}
    for number, values in enumerate(combinations, start=1):
        swept = [Override(a.path, v, f"{a.key}={v!r}") for a, v in zip(axes, values, strict=True)]
        try:
            case = Case.parse(text, name=source, overrides=[*settings, *swept])
        except CaseError as cause:
            blamed = (_blame(finding, swept) for finding in cause.findings)
            # What is wrong with a key rather than its value is wrong at every point.
            findings |= {(f.key, f.message, f.value): f for f in blamed if (f.key, f.message, f.value) not in findings}
            continue
        points.append(Point(number, f"{stem}_{number:0{digits}d}", values, case.problem, case.text, case.to_json()))
    if findings:
        raise CaseError(list(findings.values()))
    return tuple(points)


def _blame(finding: Finding, swept: Iterable[Override]) -> Finding:
    for override in swept:
        if finding.source == f"--set {override.text}":
            return dataclasses.replace(finding, source=f"--over {override.text}")
    return finding


def stretches(points: Sequence[Point], axes: Sequence[Axis]) -> list[Stretch]:
    """Divide `points` into stretches along the axis that varies fastest, none longer than `LONGEST_STRETCH`."""
    # Axes of one value do not vary.
    row = next((len(axis.values) for axis in reversed(axes) if len(axis.values) > 1), 1)
    parts = -(-row // LONGEST_STRETCH)
    ends = [row * part // parts for part in range(parts + 1)]
    return [
        Stretch(tuple(points[first + start : first + end]))
        for first in range(0, len(points), row)
        for start, end in itertools.pairwise(ends)
    ]
