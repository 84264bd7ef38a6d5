"""Files of measured surfaces: matrices of heights (.npy, .npz, text), columns x, y, height, and what instruments write.

The first index of a matrix counts along rolling, in the order in which its points come into the contact. Files of instruments
are read by SurfaceTopography (`pip install 'thermoroll[surfaces]'`), with the units and the spacing that they tell.
"""

from __future__ import annotations

import math
import os
import warnings
import zipfile
import zlib
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any, Literal

import numpy as np
import scipy

from thermoroll_cli.files.csv_table import LARGEST, TableError, text_of
from thermoroll_cli.problem.surface import Texture, length_words
from thermoroll_cli.tools.arrays import AnyArray, Array
from thermoroll_cli.tools.atomic import ReadError, read_bytes

UNITS = {"m": 1.0, "mm": 1e-3, "um": 1e-6, "nm": 1e-9}
INSTRUMENTS = (".sdf", ".xyz")
"""Endings of texts that instruments write. Their other files are no text, or XML."""
HEAD = 4096
"""Bytes at the beginning of a file that show whether it is a text."""
PLAIN = "", ".txt", ".csv", ".tsv", ".dat", ".asc"
"""Endings of texts that are no files of instruments."""
HIGHEST, WIDEST, MOST_POINTS = 10e-3, 1.0, 2**26
"""Largest range of heights and side of an instrument's field in m, and number of points: beyond, units are wrong."""
MOST_FILLED = 0.5
"""Share of the points without a height above which these are not filled in: more than half of the surface would be made up."""
IRREGULAR = 1e-3
"""Departure of the places of columns from a regular grid, in steps of it."""
MEASURED_IN = "a matrix of heights with spacing_um, columns x, y in mm and height, or an instrument's file"
SIGMA = math.sqrt(0.5 * math.log(2.0)) / math.pi
"""Standard deviation of the Gaussian that leaves half of a wave, over its length."""


@dataclass(frozen=True)
class MeasuredSurface:
    """Heights as a case wants them, (n, m) in m, points `spacing` (m) apart along and across, of a file with a `checksum`;
    `record` says how they were read."""

    heights: Array
    spacing: tuple[float, float]
    checksum: str
    shown: dict[str, Any] = field(default_factory=dict)

    def record(self) -> dict[str, Any]:
        """What `show` says."""
        return self.shown

    def words(self, record: dict[str, Any]) -> str:
        """The `record` as a sentence for people."""
        filled = f", {100.0 * record['filled_share']:.3g} % of them filled in" if record["filled_share"] else ""
        changed = " and ".join(record["signs_changed"])
        signs = f"sign of {changed} changed" if changed else "signs as in the file"
        return (f"{record['file']}: {record['format']}, {record['points'][0]} × {record['points'][1]} points "
                f"{record['spacing_um'][0]:.4g} × {record['spacing_um'][1]:.4g} µm apart in {record['unit']}{filled}, {signs}, "
                f"{record['removed']} removed; {texture_words(record)}")


def texture_words(record: dict[str, Any]) -> str:
    """The numbers of a texture in words."""
    return (f"rms {record['rms_um']:.3g} µm, rms slope {record['rms_slope']:.3g}, range {record['range_um']:.4g} µm, shortest "
            f"wavelength {length_words(1e-6 * record['shortest_wavelength_um'])}")


def texture_record(texture: Texture) -> dict[str, float]:
    """The numbers of a texture, in the units of their names."""
    return {"rms_um": 1e6 * texture.rms, "rms_slope": texture.slope, "range_um": 1e6 * texture.range,
            "shortest_wavelength_um": 1e6 * texture.shortest}


@dataclass(frozen=True)
class _Read:
    """Heights of a file in m, nan where there are none, and what the file tells: `spacing` in m, its `unit`, its `format`."""

    heights: Array
    spacing: tuple[float, float]
    unit: str
    format: str
    instrument: bool = False


def read_surface(
    path: str, spacing: tuple[float, float] | None, unit: str | None, *, remove: str, degree: int, smoothing: float,
    along: Literal["x", "y"], flip: bool, mirror: bool | None, fill: bool, repeats: bool, from_outside: bool,
) -> MeasuredSurface:
    """The heights in the file at `path` as the keys of a case want them. Raises TableError with the file, OSError."""
    stamp = os.stat(path)
    return _prepared(path, (stamp.st_mtime_ns, stamp.st_size), spacing, unit, remove, degree, smoothing, along, flip, mirror,
                     fill, repeats, from_outside)


@lru_cache(maxsize=2)
def _prepared(
    path: str, stamp: tuple[int, int], spacing: tuple[float, float] | None, unit: str | None, remove: str, degree: int,
    smoothing: float, along: str, flip: bool, mirror: bool | None, fill: bool, repeats: bool, from_outside: bool,
) -> MeasuredSurface:
    """The surface of a file that has not changed since; a case is checked, shown and solved with one reading."""
    read, name = _read(path, spacing, unit), os.path.basename(path)
    heights, (dx, dy) = read.heights, read.spacing
    _check(heights, name)
    missing = ~np.isfinite(heights)
    share = float(missing.mean())
    if share > (MOST_FILLED if fill else 0.0):
        raise TableError(f"{name}: {100.0 * share:.3g} % of its {heights.size} points have no height",
                         'fill = "interpolate" gives them heights from those around, if they are at most '
                         f"{100.0 * MOST_FILLED:g} %")
    if share:
        heights = _filled(heights, missing)
    if along == "y":
        heights, dx, dy = heights.T, dy, dx
    mirrored = (read.instrument and from_outside) if mirror is None else mirror
    heights = heights[:, ::-1] if mirrored else heights
    heights = _levelled(-heights if flip else heights, remove, degree)
    if float(np.ptp(heights)) > HIGHEST:
        raise TableError(f"{name}: heights span {1e3 * float(np.ptp(heights)):.4g} mm", f"heights within {1e3 * HIGHEST:g} mm: "
                         "is their unit right?")
    if smoothing:
        heights = scipy.ndimage.gaussian_filter(
            heights, [SIGMA * smoothing / step for step in (dx, dy)], mode=["wrap" if repeats else "nearest", "nearest"])
    heights = np.ascontiguousarray(heights)
    heights.flags.writeable = False
    texture = Texture.of(heights, (dx, dy), repeats=repeats)
    signs = [axis for axis, changed in (("y", mirrored), ("height", flip)) if changed]
    what = {"none": "nothing", "polynomial": f"a polynomial of degree {degree}", "mean": "the mean", "plane": "a plane"}[remove]
    with open(path, "rb") as file:
        checksum = f"{zlib.crc32(file.read()):08x}"
    return MeasuredSurface(heights, (dx, dy), checksum, {
        "file": name, "format": read.format, "points": list(heights.shape), "spacing_um": [1e6 * dx, 1e6 * dy],
        "unit": read.unit, "filled_share": share, "signs_changed": signs, "removed": what, **texture_record(texture)})


def _check(heights: AnyArray, name: str) -> None:
    """Raises TableError for what is no surface."""
    if heights.ndim != 2 or heights.shape[0] < 2:
        raise TableError(f"{name}: an array of {' × '.join(map(str, heights.shape))} is no surface",
                         "a matrix with two rows or more, which come into the contact one after the other")
    if heights.size > MOST_POINTS:
        raise TableError(f"{name}: {heights.size} points are too many", f"at most {MOST_POINTS}")
    if not np.isfinite(heights).any():
        raise TableError(f"{name}: no point has a height")


def _read(path: str, spacing: tuple[float, float] | None, unit: str | None) -> _Read:
    name, ending = os.path.basename(path), os.path.splitext(path)[1].lower()
    if ending in (".npy", ".npz"):
        return _matrix(_numpy(path, name), name, spacing, unit, "NumPy")
    with open(path, "rb") as file:
        head = file.read(HEAD)
    if ending in INSTRUMENTS or (b"\0" in head and not head.startswith((b"\xff\xfe", b"\xfe\xff"))):
        return _of_instrument(path, name, spacing, unit)
    try:
        text = text_of(read_bytes(path, LARGEST, "a surface"), name)
    except ReadError as cause:
        raise TableError(f"{name}: {cause}") from None
    try:
        numbers = _numbers(text, name)
    except TableError:
        if ending in PLAIN:
            raise
        # Many instruments begin their files with lines of text.
        return _of_instrument(path, name, spacing, unit)
    if spacing is None and numbers.shape[1] == 3:
        return _columns(numbers, name, unit)
    return _matrix(numbers, name, spacing, unit, "matrix")


def _matrix(numbers: AnyArray, name: str, spacing: tuple[float, float] | None, unit: str | None, kind: str) -> _Read:
    if numbers.ndim == 1:
        numbers = numbers[:, None]
    if spacing is None:
        raise TableError(f"{name}: a matrix does not tell how far apart its points are", "spacing_um in its table")
    factor = UNITS[unit or "um"]
    return _Read(np.asarray(numbers, dtype=np.float64) * factor, spacing, unit or "um", kind)


def _numpy(path: str, name: str) -> AnyArray:
    try:
        found = np.load(path, allow_pickle=False)
        if isinstance(found, np.ndarray):
            array = found
        else:
            with found:
                if len(found.files) != 1 and "heights" not in found.files:
                    raise TableError(f"{name} has the arrays {', '.join(found.files)[:200]}", "one, or one called heights")
                array = found["heights" if "heights" in found.files else found.files[0]]
    except (ValueError, EOFError, zipfile.BadZipFile, MemoryError) as cause:
        if isinstance(cause, TableError):
            raise
        raise TableError(f"{name} cannot be read as NumPy's: {cause}") from None
    if array.dtype.kind not in "fiu":
        raise TableError(f"{name} has no numbers but {array.dtype}")
    return np.asarray(array)


def _numbers(text: str, name: str) -> Array:
    """The numbers of a text in rows of equal length, after a header; missing ones are nan."""
    lines = [line for line in text.split("\n") if line.strip() and not line.lstrip().startswith(("#", "%", "//"))]
    head = lines[0] if lines else ""
    delimiter = next((mark for mark in ";\t," if mark in head), None)
    if delimiter != ",":
        lines = [line.replace(",", ".") for line in lines]
    rows: list[list[float]] = []
    for number, line in enumerate(lines, 1):
        cells = [cell.strip() for cell in line.rstrip(" \t" if delimiter != "\t" else " ").split(delimiter)]
        try:
            rows.append([float(cell) if cell and cell not in ("***", "-") else math.nan for cell in cells])
        except ValueError:
            if rows or number > 1:
                raise TableError(f"{name}, row {number}: no numbers: {line.strip()[:60]}", MEASURED_IN) from None
    if not rows:
        raise TableError(f"{name}: there are no heights in it", MEASURED_IN)
    uneven = next((number for number, row in enumerate(rows, 1) if len(row) != len(rows[0])), None)
    if uneven:
        raise TableError(f"{name}: row {uneven} of numbers has {len(rows[uneven - 1])} values, the first one {len(rows[0])}",
                         "rows of equal length")
    return np.array(rows)


def _columns(numbers: Array, name: str, unit: str | None) -> _Read:
    """Heights of a regular grid from rows x, y in mm and height, in any order; points that are not there have none."""
    places, indices = [], []
    for axis, values in zip("xy", numbers[:, :2].T, strict=True):
        if not np.isfinite(values).all():
            raise TableError(f"{name}: a point has no {axis}")
        ends = float(values.min()), float(values.max())
        steps = np.diff(np.unique(values))
        wide = steps[steps > 1e-3 * steps.max()] if steps.size else steps
        step = float(np.median(wide)) if wide.size else 0.0
        count = round((ends[1] - ends[0]) / step) + 1 if step else 1
        step = (ends[1] - ends[0]) / (count - 1) if count > 1 else 1.0
        index = (values - ends[0]) / step
        if np.abs(index - np.round(index)).max(initial=0.0) > max(IRREGULAR * count, 0.1) or count > MOST_POINTS:
            raise TableError(f"{name}: its points lie on no regular grid along {axis}", "points at equal steps")
        places.append((count, step))
        indices.append(np.round(index).astype(int))
    (nx, dx), (ny, dy) = places
    if nx * ny > MOST_POINTS:
        raise TableError(f"{name}: its points lie on no regular grid", "points at equal steps")
    heights = np.full((nx, ny), np.nan)
    heights[indices[0], indices[1]] = numbers[:, 2] * UNITS[unit or "um"]
    return _Read(heights, (1e-3 * dx, 1e-3 * dy), unit or "um", "columns x, y, height")


def _of_instrument(path: str, name: str, spacing: tuple[float, float] | None, unit: str | None) -> _Read:
    """The first channel of heights in the file of an instrument."""
    try:
        # Its import takes longer than a run: only here. It warns of libraries that are not there.
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            from SurfaceTopography import open_topography
    except ImportError:
        raise TableError(f"{name} is the file of an instrument, which SurfaceTopography reads, and that is not installed",
                         "pip install 'thermoroll[surfaces]', or export a matrix of heights") from None
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            with open_topography(path) as reader:
                topography = reader.topography(**({} if spacing is None else {
                    "physical_sizes": tuple(n * step for n, step in zip(reader.default_channel.nb_grid_pts, spacing,
                                                                        strict=False))}))
                written = topography.unit
                if written is None:
                    if unit is None:
                        raise TableError(f"{name}: the file tells no unit of lengths", "unit in its table")
                    factor = UNITS[unit]
                else:
                    factor = 1.0
                    topography = topography.to_unit("m")
                heights = np.ma.filled(np.ma.asarray(topography.heights(), dtype=np.float64), np.nan) * factor
                sizes = topography.physical_sizes
                kind = reader.name()
    except TableError:
        raise
    except Exception as cause:  # of 42 readers of files that may be damaged
        said = (str(cause).strip().splitlines() or [type(cause).__name__])[0]
        raise TableError(f"{name} cannot be read as the file of an instrument: {said[:200]}") from None
    if sizes is None or any(size is None for size in sizes):
        raise TableError(f"{name}: the file tells no size of its surface", "spacing_um in its table")
    counts = heights.shape if heights.ndim == 2 else (heights.size, 1)
    heights = heights.reshape(counts)
    step = spacing or [factor * size / count for size, count in zip((*sizes, 1.0 * counts[1])[:2], counts, strict=True)]
    if (side := step[0] * counts[0]) > WIDEST:
        raise TableError(f"{name}: the file tells a length of {side:.4g} m, which no instrument sees",
                         "a file with the right unit, or a matrix of heights with spacing_um")
    return _Read(heights, (float(step[0]), float(step[1])), str(written or unit), str(kind), instrument=True)


def _filled(heights: Array, missing: AnyArray) -> Array:
    """`heights` with those `missing` between the points around them: linear, beyond them the nearest."""
    around = ~missing & scipy.ndimage.binary_dilation(missing)
    points, places = np.argwhere(around), np.argwhere(missing)
    filled = heights.copy()
    nearest = scipy.interpolate.griddata(points, heights[around], places, method="nearest")
    if min(np.ptp(points, axis=0)) > 0:
        between = scipy.interpolate.griddata(points, heights[around], places, method="linear")
        nearest = np.where(np.isfinite(between), between, nearest)
    filled[missing] = nearest
    return filled


def _levelled(heights: Array, remove: str, degree: int) -> Array:
    """`heights` without the polynomial in both directions that fits them best."""
    if remove == "none":
        return heights
    order = {"mean": 0, "plane": 1}.get(remove, degree)
    along, across = (np.linspace(-1.0, 1.0, count) if count > 1 else np.zeros(1) for count in heights.shape)
    one, other = (np.polynomial.legendre.legvander(places, min(order, places.size - 1)) for places in (along, across))
    terms = [(i, j) for i in range(one.shape[1]) for j in range(other.shape[1]) if i + j <= order]
    # Products of polynomials: normal equations of sums along each direction, without a matrix of all points.
    grams = one.T @ one, other.T @ other
    matrix = np.array([[grams[0][i, k] * grams[1][j, m] for k, m in terms] for i, j in terms])
    moments = one.T @ heights @ other
    found = np.linalg.solve(matrix, np.array([moments[i, j] for i, j in terms]))
    table = np.zeros((one.shape[1], other.shape[1]))
    for (i, j), value in zip(terms, found, strict=True):
        table[i, j] = value
    return np.asarray(heights - one @ table @ other.T)
