"""Files of transverse profiles: two columns as spreadsheets write them, Simpack's .prr and .prw, MiniProf's .ban and .whl.

A profile of `[geometry]` is a list of points [y, height] in mm, y increasing, height positive out of the body
(`read_profile`); one of a track or a wheelset is an outline, a list of points [y, z] in order along the surface, y to the
field side, z down, into a rail and out of a wheel (`read_outline`). Simpack's files are such outlines; MiniProf's vertical
axis may point either way, and the largest departure from the median height is the gauge face of a rail or the flange of a
wheel, both down. Where an outline folds back (flange back, rail foot) a profile is its widest part with y in order. """

from __future__ import annotations

import itertools
import math
import os
import re
import statistics
from collections.abc import Callable, Sequence

import numpy as np

from thermoroll_cli.atomic import ReadError, read_bytes
from thermoroll_cli.files.case_table import LARGEST_PROFILE

FILE_LIMIT = 1 << 20
"""Bytes a profile may have."""
LENGTHS = (5.0, 500.0)
"""Shortest and longest outline of a wheel or a rail in mm."""

Points = list[list[float]]

_QUOTED = re.compile(r"\"([^\"]*)\"|'([^']*)'|([^;,\t \"']+)")
_COMMENT = re.compile(r"[!#%].*")


class ProfileError(ValueError):
    """A fault of a profile file, with its place in it, and a `hint`."""

    def __init__(self, message: str, hint: str = "") -> None:
        super().__init__(message)
        self.hint = hint


def read_profile(path: str | os.PathLike[str]) -> Points:
    """The profile in the file at `path`; its name's ending says which format it has. Raises ProfileError."""
    name = os.path.basename(os.fspath(path))
    ending = os.path.splitext(name)[1].lower()
    lines = _lines(path, name)
    if ending not in _READERS:
        return _enough(_in_increasing_order(_columns(lines, name), name), name)
    out = 1.0 if ending in _WHEELS else -1.0
    return _enough(_in_order([[y, out * z] for y, z in _READERS[ending](lines, name)]), name)


def read_outline(path: str | os.PathLike[str]) -> Points:
    """The outline in the file at `path`, in the frame of railway profiles. Raises ProfileError."""
    name = os.path.basename(os.fspath(path))
    reader = _READERS.get(os.path.splitext(name)[1].lower())
    lines = _lines(path, name)
    return _enough(list(_columns(lines, name).values()) if reader is None else reader(lines, name), name)


def outline_fault(points: Sequence[Sequence[float]], *, wheel: bool) -> tuple[str, str]:
    """The fault of an outline [y, z] in mm of a wheel or a rail, and advice; both empty if there is none."""
    y, z = np.array(points).T
    length = float(np.hypot(np.diff(y), np.diff(z)).sum())
    if not LENGTHS[0] <= length <= LENGTHS[1]:
        metres = LENGTHS[0] <= 1e3 * length <= LENGTHS[1]
        return f"the profile is {length:.3g} mm long", ("its points seem to be in metres: give them in mm" if metres
                                                        else "a profile of a wheel or a rail is 5 to 500 mm long, in mm")
    # The height that half of the width lies above, wherever points are dense.
    order = np.argsort(z[1:] + z[:-1])
    width = np.cumsum(np.abs(np.diff(y))[order])
    middle = float(0.5 * (z[1:] + z[:-1])[order][np.searchsorted(width, 0.5 * width[-1])])
    if float(z.max()) - middle < middle - float(z.min()):
        return "the profile is upside down", "z points down: into a rail, and out of a wheel towards the flange"
    if wheel and flange_side(points) > 0:
        return "the flange lies on the field side", "y points to the field side: mirror = true in the profile's table"
    return "", ""


def flange_side(points: Sequence[Sequence[float]]) -> int:
    """−1 if the lowest point of a wheel lies at smaller y than the middle of its outline, as it should, else 1."""
    y, z = np.array(points).T
    return -1 if y[int(np.argmax(z))] < 0.5 * (float(y.min()) + float(y.max())) else 1


def _enough(points: Points, name: str) -> Points:
    if len(points) < 2:
        raise ProfileError(f"{name}: a profile has two points at least, here are {len(points)}",
                           "give a text file with two columns, y and height in mm, or a .prr, .prw, .ban or .whl file")
    if len(points) > LARGEST_PROFILE:
        raise ProfileError(f"{name}: {len(points)} points are too many, at most {LARGEST_PROFILE}", "leave some of them out")
    return points


LARGEST_MM = 1e6
"""Largest coordinate of a profile."""


def point_fault(points: Sequence[Sequence[float]], k: int) -> str:
    """The fault of point `k`, given the points before it; empty if it is fine."""
    if not all(math.isfinite(value) for value in points[k]):
        return "nan and inf are no heights"
    if any(abs(value) > LARGEST_MM for value in points[k]):
        return f"{max(points[k], key=abs):g} is beyond {LARGEST_MM:g} mm"
    if k and not points[k][0] > points[k - 1][0]:
        return f"y does not increase: {points[k][0]:g} after {points[k - 1][0]:g}"
    return ""


# --- two columns ------------------------------------------------------------------------------------------------------


def _columns(lines: list[str], name: str) -> dict[int, list[float]]:
    """Points by the number of their line: two columns separated by semicolons, tabs, commas or blanks, with a point or a
    comma in the numbers; lines of which the first entry is no number may precede them."""
    points: dict[int, list[float]] = {}
    for number, line in enumerate(lines, 1):
        text = line.strip()
        if not text or text.startswith("#"):
            continue
        entries = _entries(text)
        values = [_number(entry) for entry in entries]
        if not points and (not values or values[0] is None):
            continue  # a header
        if len(entries) != 2:
            commas = len(entries) == 4 and ";" not in text
            hint = "where numbers have a comma, separate the columns by semicolons" if commas else "keep y and height only"
            raise ProfileError(f"{name}, line {number}: {len(entries)} columns instead of two: {_short(text)}", hint)
        y, height = values
        if y is None or height is None:
            raise ProfileError(f"{name}, line {number}: not a number: {_short(entries[values.index(None)])}",
                               "a number has a point or a comma before its decimals, and nothing between thousands")
        points[number] = [y, height]
    return points


def _in_increasing_order(points: dict[int, list[float]], name: str) -> Points:
    """Points by the number of their line, y increasing, whichever end the file begins with."""
    places, ordered = list(points), list(points.values())
    if ordered and ordered[0][0] > ordered[-1][0]:
        places.reverse()
        ordered.reverse()
    for k, number in enumerate(places):
        if fault := point_fault(ordered, k):
            raise ProfileError(f"{name}, line {number}: {fault}")
    return ordered


def _entries(text: str) -> list[str]:
    if '"' in text or "'" in text:
        return [next((part for part in parts if part), "") for parts in _QUOTED.findall(text)]
    for separator in ";\t":
        if separator in text:
            return [entry.strip() for entry in text.split(separator) if entry.strip()]
    words = [word for word in (word.strip(",") for word in text.split()) if word]
    return words if len(words) > 1 else text.split(",")


def _number(text: str) -> float | None:
    try:
        return float(text.replace(",", ".") if "." not in text else text)
    except ValueError:
        return None


# --- formats of railways ------------------------------------------------------------------------------------------------


def _simpack(lines: list[str], name: str) -> Points:
    """Outlines of Simpack: `key = value` in a section `spline`, and points [y, z] in a section `point` within it."""
    keys: dict[str, float] = {}
    points: Points = []
    section = ""
    for number, line in enumerate(lines, 1):
        text = _COMMENT.sub("", line).strip()
        key, equals, value = (part.strip() for part in text.partition("="))
        if text.endswith((".begin", ".end")):
            section = text.removesuffix(".begin") if text.endswith(".begin") else ""
        elif section == "point" and text:
            points.append(_pair(text, 0, 1, name, number))
        elif equals and (scalar := _number(value)) is not None:
            keys[key] = scalar
    if keys.get("rotate"):
        raise ProfileError(f"{name}: a rotated profile (rotate = {keys['rotate']:g}) is not supported",
                           "rotate = 0, and tilt_mrad in the case")
    low, high = keys.get("bound.y.min", 0.0), keys.get("bound.y.max", 0.0)
    side = -1.0 if keys.get("mirror.y") else 1.0
    down = -1.0 if keys.get("mirror.z") else 1.0
    scale = 1e3 / keys.get("units.len.f", 1e3)
    moved = [[y + keys.get("shift.y", 0.0), z + keys.get("shift.z", 0.0)] for y, z in points]
    return [[side * scale * y, down * scale * z] for y, z in moved if not low < high or low <= y <= high]


def _miniprof(lines: list[str], name: str) -> Points:
    """Outlines of MiniProf: `key=value`, an empty line, then columns as ColumnDef says (X and Y of X,Y,A,C,…)."""
    keys: dict[str, str] = {}
    points: Points = []
    for number, line in enumerate(lines, 1):
        key, equals, value = (part.strip() for part in line.partition("="))
        if equals:
            keys[key.lower()] = value.strip('"')
        elif line.strip() and _number(re.split(r"[;,\s]+", line.strip())[0]) is not None:
            columns = keys.get("columndef", "X,Y").upper().split(",")
            if "X" not in columns or "Y" not in columns:
                raise ProfileError(f"{name}: ColumnDef={keys['columndef']} names no X and Y")
            points.append(_pair(line, columns.index("X"), columns.index("Y"), name, number))
    if not points:
        return points
    shift_y, shift_z = (_number(keys.get(key, "0")) or 0.0 for key in ("xoffset", "yoffset"))
    middle = statistics.median(z for _, z in points)
    departure = max((z - middle for _, z in points), key=abs)
    down = math.copysign(1.0, departure)
    return [[y + shift_y, down * (z + shift_z)] for y, z in points]


_READERS: dict[str, Callable[[list[str], str], Points]] = {
    ".prr": _simpack, ".prw": _simpack, ".ban": _miniprof, ".whl": _miniprof,
}  # fmt: skip
_WHEELS = (".prw", ".whl")


def _pair(text: str, first: int, second: int, name: str, number: int) -> list[float]:
    values = [_number(entry) for entry in re.split(r"[;,\s]+", text.strip()) if entry]
    if len(values) <= max(first, second) or (y := values[first]) is None or (z := values[second]) is None:
        raise ProfileError(f"{name}, line {number}: no point with two numbers: {_short(text.strip())}")
    return [y, z]


def _in_order(points: Points) -> Points:
    """The part of `points` that spans most of y with y in order, increasing."""
    if len(points) < 2:
        return points
    directions = np.sign(np.diff([y for y, _ in points]))
    turns = (np.flatnonzero(np.diff(directions)) + 1).tolist()
    runs: list[Points] = [points[first : last + 1] for first, last in itertools.pairwise((0, *turns, len(points) - 1))]
    lengths = [abs(run[-1][0] - run[0][0]) for run in runs]
    rising = sorted(runs[int(np.argmax(lengths))])
    return rising if rising[-1][0] > rising[0][0] else []


def _lines(path: str | os.PathLike[str], name: str) -> list[str]:
    try:
        raw = read_bytes(path, FILE_LIMIT, "a profile")
    except ReadError as cause:
        raise ProfileError(f"{os.fspath(path)}: {cause}") from None
    if raw.startswith((b"PK\x03\x04", b"\xd0\xcf\x11\xe0")):
        raise ProfileError(f"{name} is a workbook, not text", "save its sheet as CSV")
    return _text(raw).splitlines()


def _text(raw: bytes) -> str:
    """Text as Excel saves it: UTF-8 or UTF-16 with a mark in front, or Windows' own encoding."""
    if raw.startswith((b"\xff\xfe", b"\xfe\xff")):
        return raw.decode("utf-16", "replace")
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        return raw.decode("cp1252", "replace")


def _short(text: str) -> str:
    return text if len(text) <= 40 else text[:39] + "…"
