"""Pages of the documents, and the numbers that they print."""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[2]
NUMBER = re.compile(r"(−|-)?(\d+(?:,\d{3})*)(?:\.(\d+))?(?:e([−-]?\d+))?")


class Printed(NamedTuple):
    """A number as printed, and half a unit of its last digit."""

    value: float
    rounding: float


def page(name: str) -> str:
    """A page by its name, or the comment at the beginning of a case."""
    if name.endswith(".toml"):
        comment = (ROOT / name).read_text(encoding="utf-8").partition("\n\n")[0]
        return "\n".join(line.removeprefix("#") for line in comment.splitlines())
    return (ROOT / ("" if name == "README" else "docs") / f"{name}.md").read_text(encoding="utf-8")


def printed(name: str, text: str) -> list[Printed]:
    """The numbers of `text`, which must stand on the page, however its lines are broken. Zeros at the end of a whole number
    are no digits of it."""
    assert " ".join(text.split()) in " ".join(page(name).split()), f"{name} does not say: {text}"
    found = []
    for sign, whole, decimals, exponent in NUMBER.findall(text):
        power = int((exponent or "0").replace("−", "-"))
        digits = whole.replace(",", "")
        places = len(decimals) if decimals else len(digits.rstrip("0")) - len(digits)
        value = float(f"{digits}.{decimals or 0}e{power}")
        found.append(Printed(-value if sign else value, 0.5 * 10.0 ** (power - places)))
    return found


def cell(name: str, row: str, column: str) -> list[Printed]:
    """The numbers of a cell of a page's table: of the row whose first cell begins with `row`, below the heading `column`."""
    header: list[str] = []
    for line in page(name).splitlines():
        cells = [each.strip() for each in re.split(r"(?<!\\)\|", line)[1:-1]] if line.startswith("|") else []
        if not header:
            header = cells
        if not cells:
            header = []
        elif cells[0].startswith(row) and column in header:
            return printed(name, cells[header.index(column)])
    raise AssertionError(f"docs/{name}.md has no table with {row} and {column}")


def at_most(name: str, row: str, column: str = "difference", which: int = 0) -> float:
    """The largest difference that is still the one printed in such a cell."""
    value, rounding = cell(name, row, column)[which]
    return value + rounding
