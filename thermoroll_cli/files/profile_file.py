"""Transverse profiles in the case: two columns of a text file, and the profile in SI units."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Sequence

from thermoroll_cli.files.case_model import LARGEST_PROFILE

FILE_LIMIT = 1 << 20
"""Bytes a profile may have."""

_SEPARATOR = re.compile(r"[,;\t ]+")


class ProfileError(ValueError):
    """What is wrong with a profile file, with its place in it, and a `hint`."""

    def __init__(self, message: str, hint: str = "") -> None:
        super().__init__(message)
        self.hint = hint


def read_profile(path: str | os.PathLike[str]) -> list[list[float]]:
    """Points [y, height] in mm of a text file with two columns, separated by a comma, semicolon, tab or blanks.

    Lines that begin with # and one header are skipped. Raises ProfileError."""
    name = os.path.basename(os.fspath(path))
    points: list[list[float]] = []
    header = False
    for number, line in enumerate(_lines(path, name), 1):
        text = line.strip()
        if not text or text.startswith("#"):
            continue
        columns = [part for part in _SEPARATOR.split(text) if part]
        values = [_number(column) for column in columns]
        if not points and not header and all(value is None for value in values):
            header = True
            continue
        if len(columns) != 2:
            raise ProfileError(f"{name}, line {number}: {len(columns)} columns instead of two: {_short(text)}")
        if None in values:
            raise ProfileError(f"{name}, line {number}: not a number: {_short(columns[values.index(None)])}")
        points.append([value for value in values if value is not None])
        fault = point_fault(points, len(points) - 1)
        if fault:
            raise ProfileError(f"{name}, line {number}: {fault}")
    if len(points) < 2:
        raise ProfileError(f"{name}: a profile has two points at least, here are {len(points)}")
    if len(points) > LARGEST_PROFILE:
        raise ProfileError(f"{name}: {len(points)} points are too many, at most {LARGEST_PROFILE}")
    return points


def point_fault(points: Sequence[Sequence[float]], k: int) -> str:
    """What is wrong with point `k`, as the points before it are; nothing if it is fine."""
    if not all(math.isfinite(value) for value in points[k]):
        return "nan and inf are no heights"
    if k and not points[k][0] > points[k - 1][0]:
        return f"y does not increase: {points[k][0]:g} after {points[k - 1][0]:g}"
    return ""


def _lines(path: str | os.PathLike[str], name: str) -> list[str]:
    try:
        with open(path, "rb") as stream:
            raw = stream.read(FILE_LIMIT + 1)
    except FileNotFoundError:
        raise ProfileError(f"no such file: {os.fspath(path)}") from None
    except IsADirectoryError:
        raise ProfileError(f"{name} is a folder, not a file") from None
    except (OSError, ValueError) as cause:
        raise ProfileError(f"{name} cannot be read: {getattr(cause, 'strerror', None) or cause}") from None
    if len(raw) > FILE_LIMIT:
        raise ProfileError(f"{name} is too large for a profile, which has at most {FILE_LIMIT // 1024} KiB")
    try:
        return raw.decode("utf-8-sig").splitlines()
    except UnicodeDecodeError:
        raise ProfileError(f"{name} is not text with two columns") from None


def _number(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None


def _short(text: str) -> str:
    return text if len(text) <= 40 else text[:39] + "…"
