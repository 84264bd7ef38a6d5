"""Limits that scalars have to keep, as `--limit 'pressure_max_MPa<1200'`: met only if a value with its estimated error is."""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from thermoroll_cli.problem.names import UNCERTAINTY, check_scalar, known_as, over_limit
from thermoroll_cli.problem.scalar_errors import computed, row_of, with_error

RELATIONS: dict[str, Callable[[float, float], bool]] = {
    "<=": operator.le, ">=": operator.ge, "<": operator.lt, ">": operator.gt}
_FORM = re.compile(r"\s*([\w.]+)\s*(<=|>=|<|>)\s*(\S+)\s*")


@dataclass(frozen=True)
class Limit:
    """A scalar of a summary, or `uncertainty.SCALAR`, its `relation` and the `bound`, in its unit; `text` as it was given."""

    text: str
    scalar: str
    relation: str
    bound: float

    @classmethod
    def parse(cls, text: str) -> Limit:
        """Raises ValueError: not of this form, or no scalar."""
        parts = _FORM.fullmatch(text)
        try:
            bound = float(parts[3]) if parts else math.nan
        except ValueError:
            bound = math.nan
        if parts is None or math.isnan(bound):
            raise ValueError(f'"{text}" is not of the form SCALAR<VALUE, with <, <=, > or >=')
        check_scalar(parts[1].removeprefix(UNCERTAINTY), f'"{text}": ')
        return cls(text.replace(" ", ""), parts[1], parts[2], bound)

    def judged(self, states: Sequence[Mapping[str, Any]]) -> Judged | None:
        """The limit held against the worst of the `states`, rows with the columns of a summary; None where no state has the
        scalar."""
        upward = 1.0 if self.relation[0] == "<" else -1.0
        values = [float(math.nan if (value := row.get(self.scalar)) is None else value) for row in states]
        errors = [float(math.nan if (error := row.get(UNCERTAINTY + self.scalar)) is None else error) for row in states]
        found = [each for each in zip(values, errors, strict=True) if not math.isnan(each[0])]
        if not found:
            return None

        def farthest(value: float, error: float) -> float:
            return value + upward * (0.0 if math.isnan(error) else error)

        value, error = max(found, key=lambda each: upward * farthest(*each))
        return Judged(self, value, error, RELATIONS[self.relation](farthest(value, error), self.bound))


@dataclass(frozen=True)
class Judged:
    """A `limit`, the `value` that was held against it with its `error` (nan: not known), and whether it is `met`."""

    limit: Limit
    value: float
    error: float
    met: bool

    @property
    def known(self) -> bool:
        """Whether the value has an error, or needs none."""
        return self.limit.scalar.startswith(UNCERTAINTY) or not math.isnan(self.error)

    def __str__(self) -> str:
        return f"{self.limit.text}: {'met' if self.met else 'NOT MET'}, {with_error(self.value, self.error)}"

    def record(self) -> dict[str, Any]:
        """In plain JSON types."""
        return {"limit": self.limit.text, "value": self.value if math.isfinite(self.value) else None, "met": self.met}


def states_of(summary: Mapping[str, Any]) -> list[dict[str, Any]]:
    """The rows that limits are held against: a `summary` (`Result.summary()`), over time each row of its history, with the
    columns `OVER_LIMIT`."""
    history = summary.get("history")
    rows = [row_of(summary)] if history is None else [
        dict(zip(history, values, strict=True)) for values in zip(*history.values(), strict=True)]
    return [row | over_limit(row) for row in rows]


def worst_of(states: Sequence[Mapping[str, Any]]) -> list[dict[str, float]]:
    """At most four rows, made of those of `states`, that decide any limit as these do: each scalar where it, with its error, is
    largest and where it is least, and each error where it is."""
    most, least, unsure, sure = rows = [dict[str, float](), dict[str, float](), dict[str, float](), dict[str, float]()]
    names = dict.fromkeys(name for row in states for name, value in row.items() if computed(value))
    for name in (name for name in names if not name.startswith(UNCERTAINTY)):
        known = [row for row in states if computed(row.get(name))]
        margins = [error if computed(error := row.get(UNCERTAINTY + name)) else 0.0 for row in known]
        for extreme, sign in ((most, 1.0), (least, -1.0)):
            row = known[max(range(len(known)), key=lambda at: sign * known[at][name] + margins[at])]
            extreme |= {each: row[each] for each in (name, UNCERTAINTY + name) if computed(row.get(each))}
    for name in (name for name in names if name.startswith(UNCERTAINTY)):
        errors = [row[name] for row in states if computed(row.get(name))]
        unsure[name], sure[name] = max(errors), min(errors)
    return [row for row in rows if row]


def not_there(limit: Limit, row: Mapping[str, Any]) -> str:
    """Why a `limit` cannot be held against a result with this `row`."""
    other = known_as(limit.scalar, row)
    return (f"{limit.text}: this result has no {limit.scalar}"
            + (f", but {other}" if other != limit.scalar and computed(row.get(other)) else ""))
