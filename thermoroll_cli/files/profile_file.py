"""Files of transverse profiles: two columns as spreadsheets write them, Simpack's .prr and .prw, MiniProf's .ban and .whl, and
Vampire's text with profiles of both sides.

A profile of `[geometry]` is a list of points [y, height] in mm, y increasing, height positive out of the body
(`read_profile`); one of a track or a wheelset is an outline, a list of points [y, z] in order along the surface, y to the
field side, z down, into a rail and out of a wheel (`read_outline`). Simpack's files are such outlines; MiniProf's vertical
axis of rails may point either way, and the largest departure from the median height is a face, down; that of wheels points out
of them. If an outline folds back (flange back, rail foot), its profile is the widest part with y in order. Of a closed section
the outline is its running surface (`running_surface`)."""

from __future__ import annotations

import itertools
import math
import os
import re
import statistics
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from thermoroll_cli.files.case_errors import shortened
from thermoroll_cli.files.case_table import LARGEST_PROFILE
from thermoroll_cli.files.csv_table import FILE_LIMIT, TableError, text_of
from thermoroll_cli.problem.rounding import steps_of
from thermoroll_cli.tools.atomic import ReadError, read_bytes

COLUMNS = "two columns"
"""Format of files that spreadsheets write."""
LENGTHS, STANDS_OUT = (10.0, 500.0), 10.0
"""Shortest (in inches they are 4 to 9 long) and longest outline of a wheel or a rail, and least height of a flange or a face,
in mm."""
CLOSED, FOLDED, FOLDS, WAIST = 0.02, 1.5, 0.05, 0.5
"""An outline is closed if its ends are closer than the first share of its length, or than two of its points, and its way
across is as long as the second over its width; its running surface ends where y goes back by more than the third (mm); a rail
has a web narrower than the last share of its head and its foot."""
UNITS = {"m": 1e3, "mm": 1.0, "um": 1e-3, "in": 25.4}
"""Units that a profile may be given in, in mm."""
VAMPIRE = ("WHEELPROFILE", "RAILPROFILE")
"""First lines of files with profiles of both sides."""
FLANGE_BACKS = {"EUROPEAN": 70.0, "US1": 25.4 * (2.0 + 27.0 / 32.0), "US2": 25.4 * (3.0 + 1.0 / 16.0)}
"""Distance (mm) of the flange back from the datum of the tread that Vampire names."""
SLICES = (".slcs", ".slcw")
"""Endings of files with slices along the track, and around a wheel."""
MOST_SLICES = 1000
UNREAD = {".slcs": "a list of rail profiles along the track, for a rail of [track]",
          ".slcw": "a list of wheel profiles around the wheel, for a wheel of [wheelset]",
          ".mpt": "a MiniProf file of several profiles"}  # fmt: skip
"""Endings of files that are known and not read."""

Points = list[list[float]]

_FORTRAN = re.compile(r"[-+]?[\d.,]+[dD][-+]?\d+")
_QUOTED = re.compile(r"\"([^\"]*)\"|'([^']*)'|([^;,\t \"']+)")


@dataclass(frozen=True)
class Reading:
    """Points of a profile or an outline in mm, and how they were read.

    Attributes:

    - `content`: points as the case has them, before its keys `mirror` and `smoothing_mm`;
    - `format`: of the file, in words;
    - `unit`, `scale`: of lengths in the file, and this unit in mm;
    - `in_file`: points of the file, of which those that fold back are left out of a profile;
    - `mirrored`, `turned`: whether the signs of y and of the other coordinate are not those of the file;
    - `wheel`: whether the file says that it is a wheel;
    - `file`: its name;
    - `upwards`: whether the second coordinate is a height out of the body, and not z, down;
    - `note`: what else is to be said of the file.
    """

    content: Points
    format: str
    unit: str = "mm"
    in_file: int = 0
    mirrored: bool = False
    turned: bool = False
    wheel: bool = False
    file: str = ""
    upwards: bool = False
    scale: float = 1.0
    note: str = ""

    def in_units(self, unit: str | None, height_unit: str | None) -> Reading:
        """The same file with lengths in `unit`, and heights in `height_unit`, of `UNITS`; None as the file says, or in mm."""
        across = self.scale if unit is None else UNITS[unit]
        up = across if height_unit is None else UNITS[height_unit]
        if (across, up) == (self.scale, self.scale):
            return self
        content = [[y * (across / self.scale), z * (up / self.scale)] for y, z in self.content]
        unit = unit or self.unit
        return replace(self, content=content, unit=unit if up == across else f"{unit}, heights in {height_unit}")

    def record(self, *, mirror: bool | None, flip: bool | None, wheel: bool = False) -> dict[str, Any]:
        """What `show` says, with `mirror` and `flip` of the case, of a `wheel` if the case says so."""
        mirror, flip = bool(mirror), bool(flip)
        oriented = np.array(self.content) * np.array([-1.0 if mirror else 1.0, -1.0 if flip else 1.0])
        surface = running_surface(oriented.tolist(), wheel=wheel or self.wheel) if not self.upwards else oriented
        y, z = np.array(surface).T
        # A flange is the part furthest out of a wheel, which z and heights of wheels agree on.
        side = flange_side(np.stack((y, z), axis=1).tolist()) if wheel or self.wheel else 0
        return {
            "file": self.file, "format": self.format, "unit": self.unit, "points": len(surface),
            "points_in_file": self.in_file, "y_mm": [float(y.min()), float(y.max())],
            ("height_mm" if self.upwards else "z_mm"): [float(z.min()), float(z.max())],
            "mirrored": self.mirrored != mirror, "turned": self.turned != flip,
            "flange": {-1: "-y", 0: None, 1: "+y"}[side], "step_mm": max(steps_of(self.content)),
            "closed": len(surface) < len(self.content), "note": self.note,
        }  # fmt: skip

    def words(self, record: dict[str, Any]) -> str:
        """A `record` as a sentence for people."""
        def parts() -> Iterator[str]:
            of = f" of {record['points_in_file']}" if record["points_in_file"] != record["points"] else ""
            yield f"{record['file']}: {record['format']}"
            yield f"{record['points']}{of} points in {re.sub('in(?=,|$)', 'inches', record['unit'])}"
            if record["closed"]:
                yield "the running surface of a closed section"
            for name in (name for name in ("y", "height", "z") if f"{name}_mm" in record):
                low, high = (round(place, 4) + 0.0 for place in record[f"{name}_mm"])
                yield f"{name} from {low:.5g} to {high:.5g} mm"
            vertical = "z" if "z_mm" in record else "height"
            turned = [name for name, is_so in (("y", record["mirrored"]), (vertical, record["turned"])) if is_so]
            yield f"sign of {' and '.join(turned)} changed" if turned else "signs as in the file"
            if record["flange"]:
                yield f"flange at {record['flange']}"
            if record["step_mm"]:
                yield f"in steps of {record['step_mm']:g} mm"
            if record["note"]:
                yield record["note"]

        return ", ".join(parts())


def read_profile(path: str | os.PathLike[str]) -> Reading:
    """The profile in the file at `path`; its name's ending says which format it has. Raises TableError."""
    reading = _read(path)
    points = reading.content
    if reading.format != COLUMNS:
        out = 1.0 if reading.wheel else -1.0
        points, reading = [[y, out * z] for y, z in points], replace(reading, turned=reading.turned == reading.wheel)
        if len(points) > 1:
            # The part that spans most of y with y in order, increasing.
            turns = (np.flatnonzero(np.diff(np.sign(np.diff([y for y, _ in points])))) + 1).tolist()
            runs: list[Points] = [points[first : last + 1] for first, last in itertools.pairwise((0, *turns, len(points) - 1))]
            widest: Points = max(runs, key=lambda run: abs(run[-1][0] - run[0][0]))
            points = sorted(widest) if widest[-1][0] != widest[0][0] else []
    return replace(reading, content=_enough(points, reading.file), upwards=True)


def read_outline(path: str | os.PathLike[str], side: str | None = None) -> Reading:
    """The outline in the file at `path`, in the frame of railway profiles; of a `side`, "left" or "right", of a file that has
    both. Raises TableError."""
    reading = _read(path, ordered=False, side=side)
    return replace(reading, content=_enough(reading.content, reading.file))


class SliceFile(NamedTuple):
    """What a file of slices says of one: its place, in mm along the track or degrees around the wheel, the name of its file,
    and the arc lengths of features in mm (none, or negative where it has no part there)."""

    at: float
    file: str
    features: list[float]


class SliceFiles(NamedTuple):
    """The slices of a file, and whether they are control points of the surface."""

    slices: list[SliceFile]
    control: bool


def read_slices(path: str | os.PathLike[str]) -> SliceFiles:
    """The slices of a .slcs or .slcw file: offset and scale of places, counts of slices and of features, the interpolation (1:
    through the slices, 2: control points), the slices, and a row of features for each. Raises TableError."""
    name = os.path.basename(os.fspath(path))
    try:
        text = text_of(read_bytes(path, FILE_LIMIT, "a list of profiles"), name)
    except ReadError as cause:
        raise TableError(f"{os.fspath(path)}: {cause}") from None
    rows = [(number, words) for number, line in enumerate(text.splitlines(), 1)
            if (words := _QUOTED.findall(line.split("%")[0]))]
    degrees = name.lower().endswith(SLICES[1])

    def numbers(k: int, count: int) -> list[float]:
        number, words = rows[k] if k < len(rows) else (0, [])
        values = [_number(word[2]) for word in words[:count]]
        if len(values) < count or None in values:
            where = f"line {number}" if number else "its end"
            raise TableError(f"{name}, {where}: {count} numbers are missing",
                             "it has offset and scale; slices; features, kinks, accelerations; interpolation; places and "
                             "files; features of each slice")
        return [float(value or 0.0) for value in values]

    offset, scale = numbers(0, 2)
    count, features, control = int(numbers(1, 1)[0]), [int(value) for value in numbers(2, 3)], numbers(3, 1)[0] == 2.0
    if not 1 <= count <= MOST_SLICES:
        raise TableError(f"{name}: {count} slices", f"1 to {MOST_SLICES}")
    slices = []
    for k in range(4, 4 + count):
        (place,), (_, words) = numbers(k, 1), rows[k]
        if len(words) < 2:
            raise TableError(f"{name}, line {rows[k][0]}: no name of a file behind the place of a slice")
        at = scale * (offset + place)
        slices.append(SliceFile(math.degrees(at) if degrees else at, next(part for part in words[1] if part), []))
    if features[0] < 2:
        return SliceFiles(slices, control)
    # A row each for kinks and accelerations, if there are any.
    begin = 4 + count + sum(each > 0 for each in features[1:])
    marked = [each._replace(features=numbers(begin + k, features[0] + 1)[1:]) for k, each in enumerate(slices)]
    return SliceFiles(marked, control)


def _read(path: str | os.PathLike[str], *, ordered: bool = True, side: str | None = None) -> Reading:
    """All points of a file, two columns `ordered` by y, of a `side` if it has both."""
    name = os.path.basename(os.fspath(path))
    ending = os.path.splitext(name)[1].lower()
    if ending in UNREAD:
        raise TableError(f"{name}: {UNREAD[ending]} is not read", "give one profile: .prr, .prw, .ban, .whl or two columns")
    try:
        lines = text_of(read_bytes(path, FILE_LIMIT, "a profile"), name).splitlines()
    except ReadError as cause:
        raise TableError(f"{os.fspath(path)}: {cause}") from None
    if lines and (kind := lines[0].strip().upper()) in VAMPIRE:
        reading = replace(_vampire(lines, name, side, wheel=kind == VAMPIRE[0]), wheel=kind == VAMPIRE[0])
    elif side is not None:
        raise TableError(f"{name}: side = \"{side}\" is for files with profiles of both sides", "leave side out")
    elif ending in _READERS:
        reading = replace(_READERS[ending](lines, name), wheel=ending in (".prw", ".whl"))
    else:
        found = _columns(lines, name)
        places, points = list(found), list(found.values())
        if ordered and points and points[0][0] > points[-1][0]:  # whichever end the file begins with
            places.reverse()
            points.reverse()
        for k, number in enumerate(places if ordered else ()):
            if fault := point_fault(points, k):
                raise TableError(f"{name}, line {number}: {fault}")
        reading = Reading(points, COLUMNS)
    return replace(reading, file=name, in_file=len(reading.content))


def outline_fault(
    points: Sequence[Sequence[float]], *, wheel: bool, mirror: bool | None = None, flip: bool | None = None
) -> tuple[str, str]:
    """The fault of an outline [y, z] in mm of a wheel or a rail, and advice; both empty if there is none.

    Only what stands out tells top from bottom: the flange of a wheel, at one end of it, or the faces of a rail. A `flip` or
    `mirror` that the case gives, either way, overrules what the outline looks like."""
    size = f"a profile of a wheel or a rail is {LENGTHS[0]:g} to {LENGTHS[1]:g} mm long, in mm"
    if not (farthest := float(np.abs(np.array(points)).max())) <= 1e6:
        return f"{farthest:g} is beyond 1e+06 mm", size
    surface = running_surface(points, wheel=wheel)
    y, z = np.array(surface).T
    length = float(np.hypot(np.diff(y), np.diff(z)).sum())
    if not LENGTHS[0] <= length <= LENGTHS[1]:
        known = {"m": "metres", "in": "inches", "um": "µm"}
        key = next((key for key in known if LENGTHS[0] <= UNITS[key] * length <= LENGTHS[1]), "")
        return f"the profile is {length:.3g} mm long", (
            f"its points seem to be in {known[key]}: give them in mm, or a file with unit = \"{key}\"" if key else size)
    # The height that half of the width lies above, wherever points are dense.
    order = np.argsort(z[1:] + z[:-1])
    width = np.cumsum(np.abs(np.diff(y))[order])
    middle = float(0.5 * (z[1:] + z[:-1])[order][np.searchsorted(width, 0.5 * width[-1])])
    down, up = float(z.max()) - middle, middle - float(z.min())
    lower, higher = sorted(middle - z[[0, -1]])
    # The faces of a rail on its head end highest; the nose of a crossing is highest between its faces.
    stands_on_its_head = down < STANDS_OUT <= up and (lower < 0.5 * up if wheel else higher > 0.5 * up)
    if flip is None and (stands_on_its_head or (not wheel and _foot_above(points))):
        return "the profile is upside down", (
            "z points down: into a rail, and out of a wheel towards the flange; flip = true in the profile's table turns it, "
            "flip = false leaves it as it is, mirror = true exchanges its sides")
    if wheel and mirror is None and down >= STANDS_OUT and flange_side(surface) > 0:
        return "the flange lies on the field side", (
            "y points to the field side: mirror = true in the profile's table, or mirror = false if it does lie there; if that "
            "is no flange, z is: flip = true")
    return "", ""


def _closed(points: Sequence[Sequence[float]]) -> bool:
    """Whether `points` in mm are those of a closed section, as drawings of rails and CAD have them."""
    if len(points) < 4:
        return False
    places = np.array(points)
    chords = np.hypot(*np.diff(places, axis=0).T)
    # There and back across; its last point may be left out.
    folds = float(np.abs(np.diff(places[:, 0])).sum()) >= FOLDED * float(np.ptp(places[:, 0]))
    return folds and math.dist(places[0], places[-1]) <= max(CLOSED * float(chords.sum()), 1.01 * float(chords.max()))


def running_surface(points: Sequence[Sequence[float]], *, wheel: bool) -> Points:
    """The part of a closed section [y, z] in mm around its top, of a `wheel` around the tip of its flange, on which y goes one
    way; an outline that is open, as it is."""
    if not _closed(points):
        return [list(point) for point in points]
    places = np.array(points)
    places = places[:-1] if (places[0] == places[-1]).all() else places
    places = np.roll(places, -int(np.argmax(places[:, 1] if wheel else -places[:, 1])), axis=0)
    ways = places, np.concatenate((places[:1], places[:0:-1]))
    way = math.copysign(1.0, float(places[1, 0] - places[-1, 0]))
    parts = []
    for sign, each in zip((way, -way), ways, strict=True):
        along = sign * each[:, 0]
        folds = np.flatnonzero(np.maximum.accumulate(along) - along > FOLDS)
        parts.append(each[: int(np.argmax(along[: folds[0] if len(folds) else None])) + 1])
    return np.concatenate((parts[1][:0:-1], parts[0])).tolist()


def _foot_above(points: Sequence[Sequence[float]]) -> bool:
    """Whether a closed section [y, z] is a rail with its foot, the wider end beyond a narrow web, on top."""
    if not _closed(points):
        return False
    y, z = np.array([*points, points[0]]).T
    widths = []
    for height in float(z.min()) + float(np.ptp(z)) * np.linspace(0.03, 0.97, 32):
        crossing = np.flatnonzero((z[:-1] - height) * (z[1:] - height) < 0.0)
        share = (height - z[crossing]) / (z[crossing + 1] - z[crossing])
        at = (1.0 - share) * y[crossing] + share * y[crossing + 1]
        widths.append(float(np.ptp(at)) if len(at) else 0.0)
    top, bottom = max(widths[:8]), max(widths[-8:])
    return min(widths[8:-8]) < WAIST * min(top, bottom) and top > bottom


def flange_side(points: Sequence[Sequence[float]]) -> int:
    """−1 if the lowest point of a wheel lies at smaller y than the middle of its outline, as it should, else 1."""
    y, z = np.array(points).T
    return -1 if y[int(np.argmax(z))] < 0.5 * (float(y.min()) + float(y.max())) else 1


def _enough(points: Points, name: str) -> Points:
    """`points`, thinned evenly where there are too many."""
    if len(points) < 2:
        raise TableError(f"{name}: a profile has two points at least, here are {len(points)}",
                         "give a text file with two columns, y and height in mm, or a .prr, .prw, .ban or .whl file")
    every = math.ceil((len(points) - 1) / (LARGEST_PROFILE - 1))
    return points if every == 1 else [*points[:-1:every], points[-1]]


def point_fault(points: Sequence[Sequence[float]], k: int) -> str:
    """The fault of point `k`, given the points before it; empty if it is fine."""
    if not all(math.isfinite(value) for value in points[k]):
        return "nan and inf are no heights"
    if abs(largest := max(points[k], key=abs)) > 1e6:
        return f"{largest:g} is beyond 1e+06 mm"
    if k and not 1e-3 * points[k][0] > 1e-3 * points[k - 1][0]:  # in m, too
        return f"y does not increase: {points[k][0]:g} after {points[k - 1][0]:g}"
    return ""


def _columns(lines: list[str], name: str) -> dict[int, list[float]]:
    """Points by the number of their line: two columns separated by semicolons, tabs, commas or blanks, with a point or a
    comma in the numbers; lines of which the first entry is no number may precede them, and rows without entries follow."""
    points: dict[int, list[float]] = {}
    blank = 0
    for number, line in enumerate(lines, 1):
        text = line.strip()
        if not text or text.startswith("#"):
            continue
        entries = _entries(text)
        if not any(entries):
            blank = blank or number
            continue
        values = [_number(entry) for entry in entries]
        if not points and values[0] is None and (entries[0] or not any(value is not None for value in values)):
            continue  # a header
        if points and blank:
            raise TableError(f"{name}, line {blank}: a blank row between points", "fill it in or delete it")
        blank = 0
        if len(entries) == 1 or "" in entries:
            raise TableError(f"{name}, line {number}: one number instead of two: {shortened(text)}",
                             "a row has y and height: fill it in or delete it")
        if len(entries) != 2:
            commas = len(entries) == 4 and ";" not in text and "," in text
            hint = ("where numbers have a comma, separate the columns by semicolons" if commas else
                    f"keep y and height only, or begin a file of both sides as Vampire does: {' or '.join(VAMPIRE)}"
                    if len(entries) == 4 else "keep y and height only")
            raise TableError(f"{name}, line {number}: {len(entries)} columns instead of two: {shortened(text)}", hint)
        y, height = values
        if y is None or height is None:
            raise TableError(f"{name}, line {number}: not a number: {shortened(entries[values.index(None)])}",
                             "a number has a point or a comma before its decimals, and nothing between thousands")
        points[number] = [y, height]
    return points


def _entries(text: str) -> list[str]:
    if '"' in text or "'" in text:
        return [next((part for part in parts if part), "") for parts in _QUOTED.findall(text)]
    for separator in ";\t":
        if separator in text:
            return [entry.strip() for entry in text.split(separator) if entry.strip()]
    # A comma may end a column, or a row that a spreadsheet fills up.
    text = text.rstrip(", ")
    words = [word for word in (word.strip(",") for word in text.split()) if word]
    return words if len(words) > 1 else [entry.strip() for entry in text.split(",")]


def _number(text: str) -> float | None:
    if _FORTRAN.fullmatch(text):
        text = text.lower().replace("d", "e")
    try:
        return float(text.replace(",", ".") if "." not in text else text)
    except ValueError:
        return None


def _simpack(lines: list[str], name: str) -> Reading:
    """Outlines of Simpack: `key = value` in a section `spline`, and points [y, z] in a section `point` within it."""
    keys: dict[str, float] = {}
    points: Points = []
    section = ""
    for number, line in enumerate(lines, 1):
        text = re.sub(r"[!#%].*", "", line).strip()
        key, equals, value = (part.strip() for part in text.partition("="))
        if text.endswith((".begin", ".end")):
            section = text.removesuffix(".begin") if text.endswith(".begin") else ""
            if section == "point" and points:
                raise TableError(f"{name}, line {number}: a second spline", "a file has one profile: write each into its own")
        elif section == "point" and text:
            points.append(_pair(text, 0, 1, name, number))
        elif equals and (scalar := _number(value)) is not None:
            keys[key] = scalar
    if keys.get("rotate"):
        raise TableError(f"{name}: a rotated profile (rotate = {keys['rotate']:g}) is not supported",
                         "rotate = 0, and tilt_mrad in the case")
    side = -1.0 if keys.get("mirror.y") else 1.0
    down = -1.0 if keys.get("mirror.z") else 1.0
    scale = 1e3 / keys.get("units.len.f", 1e3)
    moved = [[y + keys.get("shift.y", 0.0), z + keys.get("shift.z", 0.0)] for y, z in points]
    for column, axis in enumerate("yz"):
        low, high = keys.get(f"bound.{axis}.min", 0.0), keys.get(f"bound.{axis}.max", 0.0)
        moved = [point for point in moved if not low < high or low <= point[column] <= high]
    shown = [[side * scale * y, down * scale * z] for y, z in moved]
    unit = {1.0: "mm", 1e3: "m"}.get(scale, f"{scale:g} mm")
    return Reading(shown, "Simpack", unit, mirrored=side < 0.0, turned=down < 0.0, scale=scale)


def _vampire(lines: list[str], name: str, side: str | None, *, wheel: bool) -> Reading:
    """Profiles of both sides as Vampire has them: a word, a title, lines with the datum and the distance of the flange backs or
    the gauge, and rows of left y, z and right y, z from the middle of the track, z of rails up, of wheels down. Their y becomes
    that from the datum of wheels or from half of the gauge; the right side is read, unless `side` is "left"."""
    words = {(fields := line.upper().split())[0]: fields[1:] for line in lines[2:4] if line.split()}
    try:
        if wheel:
            datum, *given = words["TREADDATUM"]
            back = float(given[0]) if datum == "CUSTOM" else FLANGE_BACKS[datum]
            middle = 0.5 * float(words["FLANGEBACK"][0]) + back
        else:
            middle = 0.5 * float(words["GAUGE"][0])
    except (KeyError, ValueError, IndexError):
        datums = f"TREADDATUM ({', '.join(FLANGE_BACKS)}, or CUSTOM and mm) and FLANGEBACK" if wheel else "GAUGEPOINT and GAUGE"
        raise TableError(f"{name}: lines 3 and 4 of a profile of Vampire have {datums}", "complete them") from None
    rows = []
    for number, line in enumerate(lines[4:], 5):
        text = re.split(r"[\"!%]", line)[0].strip()
        values = [_number(entry) for entry in _entries(text)] if text else []
        if values and (len(values) != 4 or None in values):
            raise TableError(f"{name}, line {number}: no left y, z and right y, z: {shortened(text)}")
        if values:
            rows.append(values)
    table = np.array(rows, dtype=float).reshape(-1, 4)
    down = 1.0 if wheel else -1.0
    left, right = (np.stack((sign * y - middle, down * z), axis=1)
                   for sign, (y, z) in ((-1.0, table.T[:2]), (1.0, table.T[2:])))
    differ = float(np.abs(left - right).max(initial=0.0))
    note = f"the {side or 'right'} side" + (f", from which the other differs by {differ:.2g} mm" if differ > 1e-3 else "")
    shown = left if side == "left" else right
    return Reading(shown.tolist(), "Vampire", turned=not wheel, mirrored=side == "left", note=note)


def _miniprof(lines: list[str], name: str) -> Reading:
    """Outlines of MiniProf: a header of `key=value` or, in old files, of words, then rows of numbers, with columns as
    ColumnDef says (X and Y of X,Y,A,C,…). Of wheels Y points out of the wheel."""
    keys: dict[str, str] = {}
    points: Points = []
    # An empty line may end the header, in which may be rows of numbers.
    header = next((number for number, line in enumerate(lines) if number and not line.strip()), 0)
    ended, header = 0, header if any(line.strip() for line in lines[header + 1 :]) else 0
    for number, line in enumerate(lines, 1):
        text = line.strip().strip('"')
        key, equals, value = (part.strip() for part in text.partition("="))
        entries = [_number(entry) for entry in _entries(text)] if text else []
        if equals:
            keys[key.lower()] = value
        # Behind two numbers may stand a remark, but not where nothing else tells rows from a header.
        elif number > header and len(entries) > 1 and None not in (entries[:2] if header or points else entries):
            if ended:
                raise TableError(f"{name}, line {number}: points after line {ended}, which has none",
                                 "a file has one profile: write each into its own")
            columns = keys.get("columndef", "X,Y").upper().split(",")
            if "X" not in columns or "Y" not in columns:
                raise TableError(f"{name}: ColumnDef={keys['columndef']} names no X and Y")
            points.append(_pair(text, columns.index("X"), columns.index("Y"), name, number))
            continue
        if points and text:
            ended = number
    if not points:
        return Reading(points, "MiniProf")
    shift_y, shift_z = (_number(keys.get(key, "0")) or 0.0 for key in ("xoffset", "yoffset"))
    down = 1.0
    if not name.lower().endswith(".whl"):
        middle = statistics.median(z for _, z in points)
        down = math.copysign(1.0, max((z - middle for _, z in points), key=abs))
    return Reading([[y + shift_y, down * (z + shift_z)] for y, z in points], "MiniProf", turned=down < 0.0)


_READERS: dict[str, Callable[[list[str], str], Reading]] = {
    ".prr": _simpack, ".prw": _simpack, ".ban": _miniprof, ".whl": _miniprof,
}  # fmt: skip


def _pair(text: str, first: int, second: int, name: str, number: int) -> list[float]:
    values = [_number(entry) for entry in _entries(text)]
    if len(values) <= max(first, second) or (y := values[first]) is None or (z := values[second]) is None:
        raise TableError(f"{name}, line {number}: no point with two numbers: {shortened(text.strip())}")
    return [y, z]
