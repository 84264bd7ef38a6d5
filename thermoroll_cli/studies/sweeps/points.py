"""The swept keys and the points of a sweep: each a checked problem.

`KEY=START:STOP:COUNT[:log]` or `KEY=v1,v2,…` make an axis, and all combinations of the axes are points; or a CSV file lists
the points one by one.
"""

from __future__ import annotations

import contextlib
import hashlib
import itertools
import json
import math
import pathlib
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from thermoroll_cli.files.case import Case, CaseError, Finding, Override
from thermoroll_cli.files.case_schema import entry_at
from thermoroll_cli.files.case_source import CaseSource, key_path, parse_source, toml_value
from thermoroll_cli.files.csv_table import read_columns
from thermoroll_cli.files.spellings import converted, in_own_units, meant
from thermoroll_cli.one_contact.refinement.plan import leaves_out_deformation
from thermoroll_cli.problem.columns import CASE, TEXTS
from thermoroll_cli.problem.names import ALL_SCALARS, OVER_LIMIT
from thermoroll_cli.problem.problem import Problem
from thermoroll_cli.tools.process import safe_point

Value = bool | int | float | str

LARGEST_BATCH = 20
"""Points that are solved one after the other, each from the one before it: the first of a batch gains nothing. Fewer leave
work for more processes, and less to solve again where a sweep is resumed."""

MOST_POINTS = 100_000
"""A COUNT with too many zeros should not fill the memory or the folder first."""
MOST_ROWS = 2_000_000
"""The same where points get no files of their own."""

FORMS = "START:STOP:COUNT, START:STOP:COUNT:log or v1,v2,…"

DEFORMATION, MOST_EXTREMES = ("thermal", "deformation"), 64
"""The key that is decided once for all points; how many of them are looked at for it."""

_DIGITS = 12
"""Significant digits of computed values: 0.3, not 0.30000000000000004."""
_WORD = re.compile(r"[A-Za-z][\w.-]*")


@dataclass(frozen=True)
class Axis:
    """A dotted key of the case and the values it takes, in their order; with `label` it is none, and names the points alone."""

    key: str
    values: tuple[Value, ...]
    label: bool = False

    @classmethod
    def parse(cls, text: str) -> Axis:
        """The axis that `text` describes. Raises ValueError with what is wrong."""
        key, equals, written = (part.strip() for part in text.partition("="))
        if not (key and equals and written):
            raise ValueError(f'"{text}" is not of the form KEY=VALUES, with {FORMS}')
        return cls(key, parse_values(written, text))

    @property
    def path(self) -> tuple[str | int, ...]:
        return key_path(self.key)

    @property
    def numeric(self) -> bool:
        return not any(isinstance(value, bool | str) for value in self.values)


def parse_values(written: str, text: str = "") -> tuple[Value, ...]:
    """The values of a range or list that is `written` within `text`, or alone. Raises ValueError with what is wrong."""
    text = text or written
    values = _range(text, written.split(":")) if ":" in written else tuple(_value(text, v) for v in written.split(","))
    if len(set(values)) < len(values):
        raise ValueError(f'"{text}" has the same value more than once')
    return values


def parse_axes(texts: Sequence[str], most: int = MOST_POINTS) -> tuple[Axis, ...]:
    """The axes of a sweep. Raises ValueError: wrong form, the same key twice, more than `most` points."""
    axes = tuple(Axis.parse(text) for text in texts)
    _check_keys([axis.key for axis in axes])
    check_count(math.prod(len(axis.values) for axis in axes), most)
    return axes


def check_count(count: int, most: int = MOST_POINTS) -> None:
    """Raises ValueError where there are more than `most` points."""
    if count > most:
        hint = f", or {MOST_ROWS} with --scalars-only" if most < MOST_ROWS else ""
        raise ValueError(f"{count} points are too many: at most {most}{hint}")


def read_points(path: pathlib.Path) -> tuple[Axis, ...]:
    """The columns of the CSV file at `path` (`read_columns`), a line per point, in the units of their keys. Columns whose name
    begins with # are labels.

    Raises ValueError (not such a file, the same key or the same point twice, a label that is called like another column),
    OSError.
    """
    names, lines = read_columns(path, "a list of points")
    labels = [name.startswith("#") for name in names]
    keys, factors = in_own_units(str(path), [f"label{place}" if label else name
                                             for place, (name, label) in enumerate(zip(names, labels, strict=True))])
    keys = [name.removeprefix("#").strip() if label else key for name, key, label in zip(names, keys, labels, strict=True)]
    _check_keys(keys)
    for key, label in zip(keys, labels, strict=True):
        if label and (not key or "." in key or key in (*ALL_SCALARS, *OVER_LIMIT, *TEXTS, "point")):
            raise ValueError(f"{path}: a label cannot be called {key or 'nothing'}: choose a name that no other column has")
        if not label and not entry_at(key_path(key)) and "." not in key:
            near = f"; did you mean {meant(key)}?" if meant(key) else "."
            raise ValueError(f"{path}: the column {key} is no key of a case{near} A label of the points, which is only "
                             f"written to the table, begins with #: #{key}")
    seen, rows = dict[tuple[Value, ...], int](), list[tuple[Value, ...]]()
    for number, cells in lines:
        place = f"{path}, line {number}"
        values = tuple(_label(cell) if label else _value(place, cell) if factor == 1.0 else
                       converted(_number(place, cell), factor)
                       for cell, factor, label in zip(cells, factors, labels, strict=True))
        if values in seen:
            raise ValueError(f"{place}: the same point as in line {seen[values]}; a label (#NAME) may tell them apart")
        seen[values] = number
        rows.append(values)
    return tuple(Axis(*column) for column in zip(keys, zip(*rows, strict=True), labels, strict=True))


def _check_keys(keys: Sequence[str]) -> None:
    twice = next((key for key in keys if keys.count(key) > 1), None)
    if twice is not None:
        raise ValueError(f"{twice} is swept twice")


def _range(text: str, parts: list[str]) -> tuple[Value, ...]:
    logarithmic = len(parts) == 4 and parts[3].strip() == "log"
    if len(parts) != 3 and not logarithmic:
        raise ValueError(f'"{text}" does not give values as {FORMS}')
    start, stop = _number(text, parts[0]), _number(text, parts[1])
    count = int(parts[2]) if parts[2].strip().isdecimal() else 0
    if not 2 <= count <= MOST_POINTS:
        raise ValueError(f'"{text}": COUNT must be a whole number from 2 to {MOST_POINTS}, not {parts[2].strip() or "nothing"}')
    if not (math.isfinite(start) and math.isfinite(stop)):
        raise ValueError(f'"{text}": START and STOP must be finite')
    if logarithmic and start * stop <= 0:
        raise ValueError(f'"{text}": START and STOP of a logarithmic range must have the same sign and not be zero')
    spaced = (np.geomspace if logarithmic else np.linspace)(start, stop, count)[1:-1]
    inner = (float(f"{value:.{_DIGITS}g}") for value in spaced)
    whole = isinstance(start, int) and isinstance(stop, int)
    # A whole-number key such as numerics.grid does not accept 64.0.
    return (start, *(int(value) if whole and value.is_integer() else value for value in inner), stop)


def _value(text: str, written: str) -> Value:
    """A number, true, false or a word."""
    value = toml_value(written.strip())
    number = isinstance(value, int | float) and not math.isnan(value)
    word = isinstance(value, str) and _WORD.fullmatch(value) and value.lower() != "nan"
    if number or word:
        return value
    raise ValueError(f'"{text}": "{written.strip()}" is neither a number nor a word')


def _label(written: str) -> Value:
    """A number, or any text."""
    value = toml_value(written)
    return value if isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value) else written


def _number(text: str, written: str) -> int | float:
    value = toml_value(written.strip())
    if isinstance(value, int | float) and not isinstance(value, bool) and not math.isnan(value):
        return value
    raise ValueError(f'"{text}": "{written.strip()}" is not a number')


def key_of(case: Case) -> str:
    """Identifies a resolved case: everything that enters the result, in whatever order it is written."""
    content = json.loads(case.to_json())
    content.pop("output", None)
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()[:32]


class Base(NamedTuple):
    """The `text` of a case, read from `source`, into which values are put; its points are called `stem` and their number."""

    text: str
    source: str
    stem: str


@dataclass(frozen=True)
class Points:
    """The points of a sweep, made one by one, so that a hundred thousand of them need not be held at once.

    The values of `axes` are put into each of the `bases` after `settings`. The last axis varies fastest; with `listed` the axes
    are the columns of a list of points instead. Plain enough to be sent to another process."""

    bases: tuple[Base, ...]
    axes: tuple[Axis, ...]
    settings: tuple[Override, ...] = ()
    listed: bool = False
    origin: str = "--over"
    """Where the values were given, for messages."""

    @classmethod
    def of(cls, bases: Sequence[Base], axes: tuple[Axis, ...], settings: Sequence[Override] = (), *, listed: bool = False,
           origin: str = "--over", most: int = MOST_POINTS) -> Points:  # fmt: skip
        """Points of one case, or those of several, one case after the other, told apart by a first axis `CASE`. Raises
        ValueError: cases that are called alike, a label that is called like that axis, more than `most` points."""
        names = [base.stem for base in bases]
        if twice := next((name for name in names if names.count(name) > 1), None):
            raise ValueError(f"several cases are called {twice}: they need names of their own (of files, or in Python by "
                             f'dataclasses.replace(case, name="…"))')
        if len(bases) > 1:
            if any(axis.key == CASE for axis in axes):
                raise ValueError(f"a label cannot be called {CASE} where there are several cases: that column names them")
            each = len(axes[0].values) if listed else 1
            axes = (Axis(CASE, tuple(name for name in names for _ in range(each)), label=True),
                    *(replace(axis, values=axis.values * len(bases)) if listed else axis for axis in axes))
        points = cls(tuple(bases), axes, tuple(settings), listed, origin)
        check_count(points.count, most)
        return points

    @property
    def per_case(self) -> int:
        """How many points each of the cases has."""
        return self.count // len(self.bases)

    def base(self, number: int) -> Base:
        """The case into which the values of the point `number` are put."""
        return self.bases[(number - 1) // self.per_case]

    @property
    def shape(self) -> tuple[int, ...]:
        lengths = tuple(len(axis.values) for axis in self.axes)
        return lengths[:1] if self.listed else lengths

    @property
    def count(self) -> int:
        return math.prod(self.shape)

    def values(self, number: int) -> tuple[Value, ...]:
        """The swept values of the point `number` (from 1)."""
        places: Sequence[Any] = [number - 1] * len(self.axes) if self.listed else np.unravel_index(number - 1, self.shape)
        return tuple(axis.values[place] for axis, place in zip(self.axes, places, strict=True))

    def over(self, number: int) -> dict[str, Value]:
        """The swept values of the point `number` by key."""
        return {axis.key: value for axis, value in zip(self.axes, self.values(number), strict=True)}

    def name(self, number: int) -> str:
        return f"{self.base(number).stem}_{(number - 1) % self.per_case + 1:0{max(4, len(str(self.per_case)))}d}"

    def case(self, number: int) -> Case:
        """The case of the point `number`. Raises CaseError, which names `origin` where a swept value is wrong."""
        swept = [Override(axis.path, value, f"{axis.key}={_written(value)}", self.origin)
                 for axis, value in zip(self.axes, self.values(number), strict=True) if not axis.label]
        text, source, _ = self.base(number)
        return Case.from_source(_parsed(text, source).overridden([*self.settings, *swept]), source)

    def checked(self) -> Iterator[Case]:
        """The cases of all points. Raises CaseError at the end, with the errors of all of them, each once."""
        findings: dict[tuple[str, ...], Finding] = {}
        for number in range(1, self.count + 1):
            safe_point()
            try:
                yield self.case(number)
            except CaseError as cause:
                # A wrong key is wrong at every point of its case.
                new = ((f.key, f.message, f.value, self.base(number).stem) for f in cause.findings)
                findings |= {key: f for key, f in zip(new, cause.findings, strict=True) if key not in findings}
        if findings:
            raise CaseError(list(findings.values()))

    def extremes(self) -> Iterator[int]:
        """The numbers of points between which all others lie: corners of the axes, with every word; of a list the points
        with the smallest and the largest value of each key."""
        ends = [sorted({axis.values.index(min(axis.values)), axis.values.index(max(axis.values))}) if axis.numeric
                else list(range(len(axis.values))) for axis in self.axes]
        if self.listed:
            yield from sorted({1 + index for indices in ends for index in indices})
            return
        for corner in itertools.product(*ends):
            yield 1 + int(np.ravel_multi_index(corner, self.shape))

    def with_one_decision(self) -> Points:
        """These points, of which all or none leave out thermal deformation where its effect is small: otherwise curves over
        the sweep would jump where one point decides differently from the next.

        Effects are monotonic along most keys, so the extremes show whether any point needs it."""
        decision = Override(DEFORMATION, "always", 'thermal.deformation="always"', "decided for the whole sweep")
        if any(axis.path == decision.path for axis in self.axes):
            return self
        left_out = set()
        for number in itertools.islice(self.extremes(), MOST_EXTREMES):
            safe_point()
            with contextlib.suppress(CaseError, ValueError):
                problem = self.case(number).task
                if isinstance(problem, Problem):
                    left_out.add(leaves_out_deformation(problem))
        return replace(self, settings=(*self.settings, decision)) if {True, False} <= left_out else self

    def batches(self) -> Iterator[range]:
        """The numbers of the points of each batch: neighbours along the axis that varies fastest, at most
        `LARGEST_BATCH`. They depend on the swept values alone, so the results do not depend on who computes them."""
        # Axes of one value do not vary; another case is no neighbour.
        lengths = (self.per_case,) if self.listed else self.shape[len(self.bases) > 1 :]
        row = next((length for length in reversed(lengths) if length > 1), 1)
        parts = -(-row // LARGEST_BATCH)
        ends = [row * part // parts for part in range(parts + 1)]
        for first in range(1, self.count + 1, row):
            for start, end in itertools.pairwise(ends):
                yield range(first + start, first + end)


@lru_cache(maxsize=1)
def _parsed(text: str, source: str) -> CaseSource:
    return parse_source(text, source)


def _written(value: Value) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)
