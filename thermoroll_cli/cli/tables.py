"""Tables for people, with the same words on a terminal and on a pipe: of one result, and of a sweep."""

from __future__ import annotations

import math
import re
import textwrap
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from thermoroll_cli.problem.names import (
    ALL_SCALARS,
    ALSO_LISTED,
    DIAGRAMS,
    GROUPS,
    OVER_LIMIT,
    holds,
    unit_end,
    unit_of,
)
from thermoroll_cli.problem.scalar_errors import (
    computed,
    finite,
    isothermal_text,
    meaning_in,
    number,
    repeats,
    row_of,
    scalar_text,
    with_error,
    worth_showing,
)

if TYPE_CHECKING:
    from thermoroll_cli.problem.result import Result
    from thermoroll_cli.studies.sweeps.points import Points
    from thermoroll_cli.studies.sweeps.table import Row

_NUMBER = re.compile(r"[-+−]?\d[\d.,]*(?:e[-+]?\d+)?")
_PLAIN = re.compile(r"-?\d+(\.\d+)?")
MOST_DECIMALS = 6
"""Numbers with more are not padded to have as many."""
_NARROWEST = 9
"""Headers and meanings are not cut to less."""


def scalar_table(row: Mapping[str, Any], names: Sequence[str], *, both: bool, width: int) -> list[str]:
    """Lines of a table with one scalar a line: name, value ± estimated error, the isothermal value if `both`, and the meaning:
    a brief one or its first words where `width` has little room, and on the next line where it has none.

    `row` is that of a result. Scalars that were not computed are left out.
    """
    shown = [name for name in names if computed(row.get(name)) and not repeats(name, row)]
    rows = [("", "coupled", "isothermal")] if both else []
    rows += [(name, scalar_text(name, row), isothermal_text(name, row) if both else "") for name in shown]
    room = width - max(map(len, align(rows)), default=0) - 2
    meanings = [""] if both else []
    for name in shown:
        meaning = meaning_in(row, name)
        brief = ALL_SCALARS[name].brief if meaning == ALL_SCALARS[name].meaning else ""
        shortened = textwrap.shorten(meaning, max(room, _NARROWEST), placeholder=" …")
        candidates = (meaning, brief, shortened if len(shortened) >= 20 else "")  # "maximum …" would say nothing
        fitting = (text for text in candidates if text and len(text) <= room)
        meanings.append("no limit" if name in row.get("unbounded", ()) else next(fitting, brief or meaning))
    return with_remarks([(*row, meaning) for row, meaning in zip(rows, meanings, strict=True)], width)


def assembly_rows(
    result: Result, names: Sequence[str], *, verbose: bool
) -> tuple[list[str], list[tuple[str, ...]], list[tuple[str, ...]]]:
    """Names of the scalars of the whole of an assembly, and the rows of two tables with a header: those of both sides beside
    each other, or of all contacts (`Kind.columns`), and those of its contacts that are shown (none if there are none)."""
    row = row_of(result.summary())
    names = [*names, *(name for name in ALSO_LISTED if name not in names)]
    sided = {name: name.replace("_left", "_right") for name in names if "_left" in name}
    sided |= {name.replace("_right", "_left"): name for name in names if "_right" in name}
    single = [name for name in names if not {name} & {*sided, *sided.values()}]
    text = {name: scalar_text(name, row) if computed(row.get(name)) else "" for pair in sided.items() for name in pair}
    sides: list[tuple[str, ...]] = [("", "left", "right", "")] if sided else []
    sides += [(left.replace("_left", "_SIDE"), text[left], text[right], unit_of(left)) for left, right in sided.items()]
    kind = result.kind
    if kind.answer.columns:
        columns = tuple(name for name in kind.answer.columns if any(name in each.record for each in result.contacts))
        columns = columns or kind.answer.columns
        # A row for each contact; those that are the same have one for all of them.
        same: dict[tuple[str, ...], list[str]] = {}
        for record in (contact.record for contact in result.contacts):
            texts = (_with_its_error(name, record) for name in columns[1:])
            same.setdefault(tuple(texts), []).append(str(record.get(columns[0], "")))
        shown_values = zip(*(alike(list(column)) for column in zip(*same, strict=True)), strict=True)
        sides = [columns, *((", ".join(first) if len(first) < 4 else f"{first[0]}, … {first[-1]}", *values)
                            for values, first in zip(shown_values, same.values(), strict=True))]
    shown = result.shown
    rows = [(kind.answer.one, *(patch.name.replace("_", " ") for patch in shown), "")]
    for name, scalar in kind.answer.of_contacts.items():
        if any(name in patch.record and (verbose or holds(scalar.listed, patch.problem)) for patch in shown):
            cells = (with_error(patch.record[name], patch.record["uncertainty"].get(name, math.nan))
                     if name in patch.record else "" for patch in shown)
            rows.append((name, *cells, unit_of(name)))
    return single, sides, rows if shown else []


def align(rows: Sequence[Sequence[str]]) -> list[str]:
    """`rows` as lines with columns below each other; columns without content are left out."""
    columns = [column for column in zip(*rows, strict=True) if any(column)]
    widths = [max(map(len, column)) for column in columns]
    return ["  " + "  ".join(map(str.ljust, row, widths)).rstrip() for row in zip(*columns, strict=True)]


def warnings_by_kind(of_points: Iterable[tuple[str, Sequence[str]]]) -> Iterator[str]:
    """The warnings of many points, by their names, with those that differ in their numbers alone as one."""
    kinds: dict[str, tuple[str, list[str]]] = {}
    for point, warnings in of_points:
        for kind, warning in {_NUMBER.sub("#", warning): warning for warning in warnings}.items():
            kinds.setdefault(kind, (warning, []))[1].append(point)
    for warning, (first, *others) in kinds.values():
        more = f" and {len(others)} more point{'s' if len(others) > 1 else ''}" if others else ""
        yield f"{warning} (at {first}{more})"


def with_remarks(rows: Sequence[Sequence[str]], width: int) -> list[str]:
    """`rows` as by `align`, but for the last cell of each, a remark: it stands behind the row, or below it where `width` has no
    room."""
    lines, remarks = align([row[:-1] for row in rows]), [row[-1] for row in rows]
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
    unit = unit_end(name)
    parts = re.findall(r"[^_.]+[_.]?", name.removesuffix(unit))
    lines = [""]
    for part in [*parts[:-1], parts[-1] + unit] if parts else []:
        if lines[-1] and len(lines[-1] + part) > max(width, _NARROWEST):
            lines.append("")
        lines[-1] += part
    return lines


SHOWN_ROWS = 40
FAILED = "NOT CONVERGED"


LEAST_SCALARS = 3
"""Scalars that a table of a sweep has at least, where there are as many, in a block of its own if need be."""


def sweep_table(rows: Sequence[Row], points: Points, width: int, asked: Sequence[str] = ()) -> Iterator[str]:
    """The table that `thermoroll sweep` prints at the end, in lines of at most `width` characters: a row per point with the
    swept values, the scalars that are `asked` for, by name or by group, in further blocks if there is no room, and as many
    others that are worth showing as have room, those that change most. A scalar that is the same at all points is shown once.
    """
    cells, swept = [row.cells() for row in rows], [axis.key for axis in points.axes]
    problems = [points.case(row.number).task.contact for row in rows]
    drawn = (*(name for names in DIAGRAMS.values() for name in names), *OVER_LIMIT)
    given = {name for name, scalar in ALL_SCALARS.items() if all(holds(scalar.given, problem) for problem in problems)}
    values = {name: finite(name, cells) for name in drawn if name not in given and worth_showing(name, cells, swept)}
    # A group stands for those of its scalars that are worth showing.
    wanted = [name for each in asked for name in ((each,) if each not in GROUPS else (n for n in GROUPS[each] if n in values))]
    values |= {name: known for name in wanted if (known := finite(name, cells))}
    wanted = [name for name in dict.fromkeys(wanted) if name in values]
    constant = [name for name, known in values.items()
                if len(known) == len(rows) > 1 and len(set(map(number, known))) == 1 and name not in wanted]

    texts = {name: [_with_error(name, row) for row in cells] for name in values if name not in constant}
    first_of = {tuple(column): name for name, column in reversed(texts.items())}

    def rank(name: str) -> tuple[int, bool, float]:
        """First what is asked for; last what says the same as another column, or nearly: as that of the lower body, or the
        force; else by how much it changes."""
        known = values[name]
        alike = "_upper_" in name or name in OVER_LIMIT or first_of[tuple(texts[name])] != name
        return (wanted.index(name) if name in wanted else len(wanted), alike,
                -(max(known) - min(known)) / (max(map(abs, known)) or 1.0))

    first = _column("", [row.name + ("" if row.converged else f"  {FAILED}") for row in rows])
    left = {name: _column(name, texts[name]) for name in sorted(texts, key=rank)}
    block = [first, *(_column(key, alike([swept_text(row.over[key]) for row in rows])) for key in swept)]
    least = max(len(wanted), min(LEAST_SCALARS, len(left)))
    shown = 0
    while block:
        room, beside = width - sum(map(_width, block)), list[str]()
        for name, column in left.items():
            # What is asked for keeps its order.
            if _width(column) <= room or (len(block) == 1 and not beside):
                room -= _width(column)
                beside.append(name)
            elif shown + len(beside) < len(wanted):
                break
        order = [name for name in values if name in beside and name not in wanted]
        block += [left.pop(name) for name in [*(name for name in beside if name in wanted), *order]]
        yield from _beside(block)
        shown += len(beside)
        block = [first] if shown < least and left else []
    endless = sorted({name for row in cells for name in row["unbounded"].split()})
    for words, names in (("at all points", [f"{name} = {_with_error(name, cells[0])}" for name in constant]),
                         ("no limit (an end or a kink of a profile)", endless),
                         ("more in the file", [name for name in values if name in left])):
        if names:
            yield from folded(f"{words}: {', '.join(names)}", width)


def alike(texts: list[str]) -> list[str]:
    """Plain numbers of a column with their points one below the other, without digits of their own; other texts as they are."""
    behind = [len("".join(text.partition(".")[1:])) for text in texts]
    if not all(_PLAIN.fullmatch(text) for text in texts) or max(behind, default=0) > MOST_DECIMALS + 1:
        return texts
    padded = [text + " " * (max(behind) - own) for text, own in zip(texts, behind, strict=True)]
    return [text.rjust(max(map(len, padded))) for text in padded]


def headed(rows: Sequence[Sequence[str]]) -> list[str]:
    """`rows` as by `align`, the first of them a header that is broken where it is wider than what is below it."""
    return _beside([_column(name, cells) for name, *cells in zip(*rows, strict=True)]) if rows else []


def _beside(columns: Sequence[list[str]]) -> list[str]:
    """Columns beside each other, which end in the same line."""
    height = max(map(len, columns))
    return align(list(zip(*([""] * (height - len(column)) + column for column in columns), strict=True)))


def _column(name: str, cells: list[str]) -> list[str]:
    """The lines of a header, and the `cells` below it."""
    return wrapped(name, max(map(len, cells))) + cells


def _width(column: list[str]) -> int:
    return 2 + max(map(len, column))


def _with_its_error(name: str, record: Mapping[str, Any]) -> str:
    """A value of a contact with its error, if it has one, without spaces."""
    value, error = record.get(name, ""), record["uncertainty"].get(name, math.nan)
    if isinstance(value, str):
        return value
    return with_error(value, error).replace(" ", "") if computed(error) and error else number(value, 4)


def _with_error(name: str, row: Mapping[str, Any]) -> str:
    """A scalar with its error, without spaces: a table of many columns is wide."""
    value = row.get(name, math.nan)
    return scalar_text(name, {**row, name: value}).replace(" ", "")


def swept_text(value: Any) -> str:
    """A swept value, as tables show it."""
    return number(value) if isinstance(value, int | float) and not isinstance(value, bool) else str(value)
