"""Points that an earlier sweep has finished, recognised by the case in their files."""

from __future__ import annotations

import pathlib
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from thermoroll_cli.files.result.hdf5 import ResultFileError, read_result
from thermoroll_cli.interruption import safe_point
from thermoroll_cli.sweeps.points import Point, identity


def finished_points(folder: pathlib.Path, points: Sequence[Point], note: Callable[[str], None]) -> dict[int, str]:
    """Number of each point that a whole result file in `folder` holds, with the file's name without .h5. Files called
    like a point that are damaged, foreign or of another case are told to `note`."""
    wanted = {point.identity: point for point in points}
    names = {point.name for point in points}
    found: dict[int, str] = {}
    for path in sorted(folder.glob("*.h5")):
        safe_point()
        try:
            point = wanted.get(identity(read_result(path, with_fields=False).case_json))
            if point is not None and found.get(point.number) != point.name:
                # Now all of it: a damaged field shows only when it is read.
                read_result(path)
                found[point.number] = path.stem
        except (ResultFileError, ValueError) as cause:
            if path.stem in names:
                told = str(cause) if isinstance(cause, ResultFileError) else f"{path}: without a case that could be recognised"
                note(f"{told}; solved again")
            continue
        if point is None and path.stem in names:
            note(f"{path}: of another case; replaced")
    return found


def unlisted_files(folder: pathlib.Path, points: Sequence[Point]) -> list[pathlib.Path]:
    """Files in `folder` that are called like points of this sweep and are none of `points`: an earlier, larger sweep left
    them, and the table will not list them."""
    stem = points[0].name.rpartition("_")[0]
    names = {point.name for point in points}
    numbered = re.compile(re.escape(stem) + r"_\d{4,}")
    return [path for path in sorted(folder.glob("*.h5")) if numbered.fullmatch(path.stem) and path.stem not in names]


def named(points: Sequence[Point], finished: Mapping[int, str]) -> tuple[Point, ...]:
    """`points` with the names of the files that hold them. A point that is still to be solved and whose name is taken
    by another finished one gets the next free number."""
    taken = set(finished.values())
    free = len(points)
    result = []
    for point in points:
        name = finished.get(point.number, point.name)
        if point.number not in finished and name in taken:
            stem, _, digits = point.name.rpartition("_")
            while name in taken:
                free += 1
                name = f"{stem}_{free:0{len(digits)}d}"
            taken.add(name)
        result.append(replace(point, name=name))
    return tuple(result)
