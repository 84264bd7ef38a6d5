"""Measured tables put into the documents, between `<!-- table NAME -->` and `<!-- end -->`."""

from __future__ import annotations

import pathlib
import re
from typing import Any

PLACE = re.compile(r"(<!-- table (\S+) (\S+) -->\n).*?(<!-- end -->)", re.DOTALL)
MINUS = re.compile(r"(?<![\w.])-(?=\d)")
"""A sign before a number, but not that of an exponent."""


def fill(folder: pathlib.Path, numbers: dict[str, Any]) -> None:
    """Write table `numbers[FIGURE][TABLE]` at each place `<!-- table FIGURE TABLE -->` in the documents of `folder`.

    Places whose table has not been measured stay as they are."""
    for path in sorted(folder.glob("*.md")):
        text = path.read_text(encoding="utf-8")
        filled = PLACE.sub(lambda place: _filled(place, numbers), text)
        if filled != text:
            path.write_text(filled, encoding="utf-8")


def _filled(place: re.Match[str], numbers: dict[str, Any]) -> str:
    begin, figure, name, end = place.groups()
    measured = numbers.get(figure, {}).get(name)
    return place.group(0) if measured is None else f"{begin}{markdown(measured)}{end}"


def markdown(measured: dict[str, Any]) -> str:
    """A Markdown table of `measured["header"]` and `measured["rows"]`."""
    rows = [[MINUS.sub("−", cell) for cell in row] for row in measured["rows"]]
    head, *body = ("| " + " | ".join(cells) + " |\n" for cells in (measured["header"], *rows))
    return "".join([head, "|" + "---|" * len(measured["header"]) + "\n", *body])
