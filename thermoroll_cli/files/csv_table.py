"""Tables as spreadsheets write and read them: text in whatever encoding, columns with names, decimal commas."""

from __future__ import annotations

import csv
import io
import os
import re
from collections.abc import Iterable

from thermoroll_cli.tools.atomic import ReadError, read_bytes, write_bytes

LARGEST, FILE_LIMIT = 2**29, 1 << 20
"""Bytes that a table may have, and a file that a case names."""


class TableError(ValueError):
    """A fault of a file of numbers, with its place in it, and a `hint`."""

    def __init__(self, message: str, hint: str = "") -> None:
        super().__init__(message)
        self.hint = hint


def read_columns(
    path: str | os.PathLike[str], kind: str, *, gaps: bool = False, largest: int = LARGEST
) -> tuple[list[str], list[tuple[int, list[str]]]]:
    """The names in the header line of the CSV file at `path`, which should be `kind`, and the number and the cells of each line
    below it. Commas, semicolons or tabs separate; but for commas, numbers may have a decimal comma, which becomes a point. Rows
    and columns that are empty at the end are none; other cells are empty only where there may be `gaps`.

    Raises ValueError (not such a file), OSError."""
    try:
        text = text_of(read_bytes(path, largest, kind), str(path))
    except ReadError as cause:
        raise ReadError(f"{path}: {cause}") from None
    head = text.partition("\n")[0]
    delimiter = next((mark for mark in ";\t," if mark in head), ";")
    reader = csv.reader(io.StringIO(text), delimiter=delimiter, skipinitialspace=True)
    try:
        lines = [(reader.line_num, [cell.strip() for cell in line]) for line in reader if line]
    except csv.Error as cause:
        raise ValueError(f"{path}, line {reader.line_num}: {kind} cannot have this: {cause}") from None
    while lines and not any(lines[-1][1]):
        lines.pop()  # a spreadsheet fills up rows, and columns
    keys, rows = _filled(lines[0][1]) if lines else [], lines[1:]
    if not keys or not rows:
        raise ValueError(f"{path}: {kind} needs a header line with the names of its columns, and lines of values below it")
    read = []
    for number, cells in rows:
        place, cells = f"{path}, line {number}", _filled(cells, len(keys))
        if not any(cells):
            raise ValueError(f"{place}: a blank row between others: fill it in or delete it")
        if len(cells) != len(keys):
            commas = delimiter == "," and len(cells) > len(keys)
            hint = "; where numbers have a comma, separate them by semicolons, and the names" if commas else (
                "; the first line names the columns: take out what stands above it" if len(cells) > len(keys) else "")
            raise ValueError(f"{place}: {len(cells)} values for {len(keys)} columns{hint}")
        if "" in cells and not gaps:
            raise ValueError(f"{place}: {keys[cells.index('')]} has no value")
        if delimiter != ",":
            cells = [re.sub(r"^([-+]?\d+),(\d+(?:[eE][-+]?\d+)?)$", r"\1.\2", cell) for cell in cells]
        read.append((number, cells))
    return keys, read


def text_of(raw: bytes, name: str) -> str:
    """The text of a file called `name` as Excel saves it: UTF-8 or UTF-16 with a mark in front, or Windows' own encoding. Its
    lines end as they do here, not as on Windows or on old Macs. Raises TableError for a workbook."""
    if raw.startswith((b"PK\x03\x04", b"\xd0\xcf\x11\xe0")):
        raise TableError(f"{name} is a workbook, not text", "save its sheet as CSV")
    if raw.startswith((b"\xff\xfe", b"\xfe\xff")):
        text = raw.decode("utf-16", "replace")
    else:
        try:
            text = raw.decode("utf-8-sig")
        except UnicodeDecodeError:
            text = raw.decode("cp1252", "replace")
    return text.replace("\r\n", "\n").replace("\r", "\n")


def _filled(cells: list[str], least: int = 0) -> list[str]:
    """`cells` without empty ones at their end, but `least` of them."""
    while len(cells) > least and not cells[-1]:
        cells = cells[:-1]
    return cells


def image_of_rows(header: Iterable[str], rows: Iterable[Iterable[object]]) -> bytes:
    """The content of a CSV file; what is no Unicode, as bytes in a name of a file, is written as an escape."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header)
    writer.writerows(rows)
    return text.getvalue().encode("utf-8", "backslashreplace")


def write_rows(path: str | os.PathLike[str], header: Iterable[str], rows: Iterable[Iterable[object]]) -> None:
    """Write a table as CSV to `path`, complete or not at all. Raises WriteError."""
    write_bytes(path, image_of_rows(header, rows))
