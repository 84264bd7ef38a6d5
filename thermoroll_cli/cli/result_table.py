"""Tables for people, aligned by rich, with the same words on a terminal and on a pipe."""

from __future__ import annotations

import io
import re
import textwrap
from collections.abc import Mapping, Sequence
from typing import Any

from thermoroll_cli.problem.names import ALL_SCALARS, UNITS
from thermoroll_cli.problem.scalar_errors import computed, isothermal_text, scalar_text

UNBOUNDED = "no limit: a free end"
"""Beside values that grow with every refinement, because the contact reaches the end of a profile."""

_NARROWEST = 9
"""A header is not broken into less."""


def scalar_table(summary: Mapping[str, Any], names: Sequence[str], *, both: bool, width: int) -> list[str]:
    """Lines of a table with one scalar a line: name, value ± estimated error, the isothermal value if `both`, and the meaning,
    a brief one or none where `width` has no room for it.

    `summary` has the shape of `Result.summary()`. Scalars that were not computed are left out.
    """
    shown = [name for name in names if computed(summary.get(name))]
    rows = [("", "coupled", "isothermal")] if both else []
    rows += [(name, scalar_text(name, summary), isothermal_text(name, summary) if both else "") for name in shown]
    room = width - max(map(len, align(rows)), default=0) - 2
    meanings = [""] if both else []
    for name in shown:
        meaning = ALL_SCALARS[name].meaning_of(hertz=computed(summary.get("hertz_a_mm", 0.0)))
        brief = ALL_SCALARS[name].brief if meaning == ALL_SCALARS[name].meaning else ""
        fitting = (text for text in (meaning, brief) if len(text) <= room)
        meanings.append(UNBOUNDED if name in summary.get("unbounded", ()) else next(fitting, ""))
    return align([(*row, meaning) for row, meaning in zip(rows, meanings, strict=True)])


def align(rows: Sequence[Sequence[str]]) -> list[str]:
    """`rows` as lines with columns below each other; columns without content are left out."""
    from rich.console import Console
    from rich.table import Table

    table = Table.grid(padding=(0, 2, 0, 0))
    columns = [column for column in zip(*rows, strict=True) if any(column)]
    for _ in columns:
        table.add_column(no_wrap=True)
    for row in zip(*columns, strict=True):
        table.add_row(*row)
    # Wide enough for any table: callers decide what fits the terminal.
    text = io.StringIO()
    Console(file=text, width=10_000, markup=False, highlight=False, emoji=False).print(table)
    return [f"  {line}".rstrip() for line in text.getvalue().splitlines() if columns]


def with_remarks(rows: Sequence[Sequence[str]], remarks: Sequence[str], width: int) -> list[str]:
    """`rows` as by `align`, each with its remark behind it, or below it where `width` has no room."""
    lines = align(rows)
    start = max(map(len, lines), default=0) + 2
    shown = []
    for line, remark in zip(lines, remarks, strict=True):
        if start + len(remark) <= width or not remark:
            shown.append((line.ljust(start) + remark).rstrip())
        else:
            shown += [line, *folded(remark, width, indent="      ")]
    return shown


def folded(text: str, width: int, indent: str = "  ") -> list[str]:
    """`text` as lines of at most `width` characters (but not less than 40), indented, and further from the second on."""
    return textwrap.wrap(text, max(width, 40), initial_indent=indent, subsequent_indent=indent + "  ", break_on_hyphens=False)


def wrapped(name: str, width: int) -> list[str]:
    """The lines of `name` as a header above a column `width` wide: broken behind `_` and `.`, where a part does not fit."""
    unit = next((end for end in UNITS if name.endswith(end)), "")
    parts = re.findall(r"[^_.]+[_.]?", name.removesuffix(unit))
    lines = [""]
    for part in [*parts[:-1], parts[-1] + unit] if parts else []:
        if lines[-1] and len(lines[-1] + part) > max(width, _NARROWEST):
            lines.append("")
        lines[-1] += part
    return lines
