"""What is swept: `KEY=START:STOP:COUNT[:log]` or `KEY=v1,v2,…`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

Number = int | float

MOST_POINTS = 100_000
"""Far beyond what anybody waits for; a COUNT with too many zeros should not fill the memory first."""
MOST_ROWS = 2_000_000
"""The same where points become rows of one file."""

FORMS = "KEY=START:STOP:COUNT, KEY=START:STOP:COUNT:log or KEY=v1,v2,…"

_DIGITS = 12
"""Significant digits of computed values: 0.3, not 0.30000000000000004."""


@dataclass(frozen=True)
class Axis:
    """A dotted key of the case and the values it takes, in their order."""

    key: str
    values: tuple[Number, ...]

    @classmethod
    def parse(cls, text: str) -> Axis:
        """The axis that `text` describes. Raises ValueError with what is wrong."""
        key, equals, written = (part.strip() for part in text.partition("="))
        if not (key and equals and written):
            raise ValueError(f'"{text}" is not of the form {FORMS}')
        values = _range(text, written.split(":")) if ":" in written else tuple(_number(text, v) for v in written.split(","))
        if len(set(values)) < len(values):
            raise ValueError(f'"{text}" has the same value more than once')
        return cls(key, values)

    @property
    def path(self) -> tuple[str, ...]:
        return tuple(part.strip() for part in self.key.split("."))


def parse_axes(texts: Sequence[str], most: int = MOST_POINTS) -> tuple[Axis, ...]:
    """The axes of a sweep. Raises ValueError: wrong form, the same key twice, more than `most` points."""
    axes = tuple(Axis.parse(text) for text in texts)
    keys = [axis.key for axis in axes]
    twice = next((key for key in keys if keys.count(key) > 1), None)
    if twice is not None:
        raise ValueError(f"{twice} is swept twice")
    count = math.prod(len(axis.values) for axis in axes)
    if count > most:
        hint = ", or 2000000 with --scalars-only" if most < MOST_ROWS else ""
        raise ValueError(f"{count} points are too many: at most {most}{hint}")
    return axes


def _range(text: str, parts: list[str]) -> tuple[Number, ...]:
    logarithmic = len(parts) == 4 and parts[3].strip() == "log"
    if len(parts) != 3 and not logarithmic:
        raise ValueError(f'"{text}" is not of the form {FORMS}')
    start, stop = _number(text, parts[0]), _number(text, parts[1])
    try:
        count = int(parts[2])
    except ValueError:
        count = 0
    if not 2 <= count <= MOST_POINTS:
        raise ValueError(f'"{text}": COUNT must be a whole number from 2 to {MOST_POINTS}, not {parts[2].strip() or "nothing"}')
    if not (math.isfinite(start) and math.isfinite(stop)):
        raise ValueError(f'"{text}": START and STOP must be finite')
    if logarithmic and start * stop <= 0:
        raise ValueError(f'"{text}": START and STOP of a logarithmic range must have the same sign and not be zero')
    inner = (_between(start, stop, step / (count - 1), logarithmic) for step in range(1, count - 1))
    whole = isinstance(start, int) and isinstance(stop, int)
    # A whole-number key such as numerics.grid takes no 64.0.
    return (start, *(int(value) if whole and value.is_integer() else value for value in inner), stop)


def _between(start: Number, stop: Number, share: float, logarithmic: bool) -> float:
    if logarithmic:
        ends = math.log(abs(start)), math.log(abs(stop))
        value = math.copysign(math.exp(ends[0] + share * (ends[1] - ends[0])), start)
    else:
        value = start + share * (stop - start)
    return float(f"{value:.{_DIGITS}g}")


def _number(text: str, written: str) -> Number:
    written = written.strip()
    try:
        return int(written)
    except ValueError:
        pass
    try:
        value = float(written)
    except ValueError:
        value = math.nan
    if math.isnan(value):
        raise ValueError(f'"{text}": "{written}" is not a number')
    return value
