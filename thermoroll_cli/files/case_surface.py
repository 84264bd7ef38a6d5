"""Tables of surfaces, such as [surface.lower] and [track.surface]: heights of a body over its smooth shape, made ones and those
of files."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from pydantic import BeforeValidator, Field

from thermoroll_cli.files.case_errors import Fault, KeyPath
from thermoroll_cli.files.case_line import is_line
from thermoroll_cli.files.case_table import Allowed, Table, quantity
from thermoroll_cli.files.surface_file import MeasuredSurface, read_surface, texture_record, texture_words
from thermoroll_cli.problem.problem import BODIES, BodyName
from thermoroll_cli.problem.surface import Dent, Flat, Heights, MeasuredHeights, Sum, Wave

MOST_POINTS = 2**24
"""Points of a surface."""
PER_WAVELENGTH, PERIODS = 8, 4
"""Points per shortest wavelength of a rough surface that is made, and longest wavelengths after which it repeats."""
NEEDED: dict[str, tuple[str, ...]] = {
    "wave": ("amplitude_um", "wavelength_mm"), "dent": ("depth_um", "radius_mm"), "flat": ("length_mm",),
    "rough": ("rms_um", "shortest_mm", "longest_mm")}  # fmt: skip
"""Keys that each kind needs."""
OTHERS: dict[str, tuple[str, ...]] = {
    "wave": ("angle_deg",), "dent": ("shoulder_um", "repeat"), "flat": ("rounding_mm", "repeat"),
    "rough": ("hurst", "lay_angle_deg", "lay_ratio", "seed"),
    "file": ("spacing_um", "unit", "remove", "degree", "smoothing_mm", "along", "flip", "mirror", "fill", "repeat", "checksum"),
}  # fmt: skip
"""Keys that each kind may have besides `start_mm` and `offset_mm`."""


class SurfaceTable(Table):
    """Heights of one body, positive out of it."""

    kind: Literal["wave", "dent", "flat", "rough"] | None = Field(default=None, description="A made surface")
    file: str | None = Field(default=None, max_length=1000, description=(
        "Heights in a .npy or .npz file, a text file with a matrix (rows come into the contact one after the other) or with "
        "the columns x, y in mm and height, or the file of an instrument"))
    spacing_um: Annotated[
        Annotated[float, Field(ge=1e-6, le=1e6)]
        | Annotated[list[Annotated[float, Field(ge=1e-6, le=1e6)]], Field(min_length=2, max_length=2)] | None,
        Allowed("a number from 1e-6 to 1e6, in µm, or two of them: [along, across]"),
    ] = Field(default=None, description="Distance between the points of a matrix")
    unit: Literal["m", "mm", "um", "nm"] | None = Field(
        default=None, description="Unit of the heights of a matrix or of columns; default um")
    remove: Literal["plane", "mean", "polynomial", "none"] | None = Field(
        default=None, description="What is taken out of the heights of a file; default plane")
    degree: int | None = Field(default=None, ge=1, le=8, description="Of that polynomial")
    smoothing_mm: float | None = quantity("Wavelength of which smoothing leaves half, of heights of a file", None,
                                          ge=1e-9, le=1e6)  # fmt: skip
    along: Literal["x", "y"] | None = Field(default=None, description="Direction in the file that is along rolling; default x")
    flip: bool | None = Field(default=None, description="Heights of the file change their sign")
    mirror: bool | None = Field(default=None, description=(
        "y of the file changes its sign; default false, of instruments' files of the upper body true: they look at it from "
        "outside"))
    fill: Literal["interpolate"] | None = Field(default=None, description="How points without a height get one")
    checksum: str | None = Field(default=None, max_length=8, description=(
        "CRC-32 of the file, as a case that was read has it; another file is refused, also by --resume"))
    amplitude_um: float | None = quantity("Amplitude of a wave", None, ge=-1e6, le=1e6)
    wavelength_mm: float | None = quantity("Its length", None, ge=1e-6, le=1e6)
    angle_deg: float | None = quantity("Its direction, from that of coming in towards +y; default 0", None, ge=-360, le=360)
    depth_um: float | None = quantity("Depth of a dent; negative: a bump", None, ge=-1e6, le=1e6)
    radius_mm: float | None = quantity("Radius at which its depth is 1/e", None, ge=1e-6, le=1e6)
    shoulder_um: float | None = quantity("Height of the material around it; default 0", None, ge=0, le=1e6)
    length_mm: float | None = quantity("Length of a flat", None, ge=1e-6, le=1e6)
    rounding_mm: float | None = quantity("Length over which its ends are rounded; default a tenth of it", None, ge=0, le=1e6)
    rms_um: float | None = quantity("Root mean square of the heights of a rough surface", None, ge=1e-9, le=1e6)
    hurst: float | None = quantity("Its Hurst exponent; default 0.8", None, ge=0, le=1)
    shortest_mm: float | None = quantity("Its shortest wavelength", None, ge=1e-6, le=1e6)
    longest_mm: float | None = quantity("Its longest wavelength", None, ge=1e-6, le=1e6)
    lay_angle_deg: float | None = quantity("Direction of its lay, from that of coming in towards +y; default 0", None,
                                           ge=-360, le=360)  # fmt: skip
    lay_ratio: float | None = quantity("Wavelengths along its lay over those across it; default 1", None, ge=1, le=1000)
    seed: int | None = Field(default=None, ge=0, le=2**31 - 1, description="Number from which it is made; default 1")
    start_mm: float = quantity("Distance rolled before its first point, or the centre of a dent or a flat, is in the middle",
                               0.0, ge=-1e9, le=1e9)  # fmt: skip
    offset_mm: float = quantity("Place of its middle towards +y", 0.0, ge=-1e6, le=1e6)
    repeat: bool | None = Field(default=None, description=(
        "A file comes again and again along rolling, a dent or a flat with each turn of its body"))

    @property
    def name(self) -> str:
        """Its kind; "file" of heights in a file."""
        return self.kind or "file"


def _listed(value: Any) -> Any:
    return [value] if isinstance(value, dict) else value


Parts = Annotated[list[SurfaceTable], BeforeValidator(_listed), Allowed("a table, or a list of tables whose heights are added")]


class SurfacesTable(Table):
    """Surfaces that roll through a contact over time."""

    lower: Parts | None = Field(default=None, description="Heights of the lower body", min_length=1, max_length=20)
    upper: Parts | None = Field(default=None, description="Heights of the upper body", min_length=1, max_length=20)


class GivenSurface(NamedTuple):
    """The tables of a surface of a body, with their place in a case, and the radius (mm) of the body along rolling with the key
    that has it."""

    path: KeyPath
    body: BodyName
    parts: list[SurfaceTable]
    radius: float
    radius_key: str


OF_ASSEMBLIES: dict[str, tuple[BodyName, str]] = {"track": (BODIES[0], "roller_radius_mm"),
                                                  "wheelset": (BODIES[1], "nominal_radius_mm")}
"""Tables with surfaces of their own: the body that they are of in each contact, and the key of its radius along rolling."""


def body_at(path: KeyPath) -> BodyName:
    """The body that has the surface at a place of a case."""
    table, own = map(str, path[:2])
    return OF_ASSEMBLIES[table][0] if table in OF_ASSEMBLIES else next(body for body in BODIES if body == own)


def given_surfaces(sections: Mapping[str, Any]) -> Iterator[GivenSurface]:
    """All surfaces in the tables of a case: of both bodies, of rails and rollers, of wheels."""
    surface, geometry = sections.get("surface"), sections.get("geometry")
    for body in BODIES:
        parts, key = getattr(surface, body, None), f"{body}_radius_x_mm"
        if parts is not None:
            yield GivenSurface(("surface", body), body, parts, getattr(geometry, key, 1.0), f"geometry.{key}")
    for table, (body, key) in OF_ASSEMBLIES.items():
        both = sections.get(table)
        for path, own in ((table,), both), *(((table, side), getattr(both, side, None)) for side in ("left", "right")):
            if own is not None and own.surface is not None:
                radius = getattr(own, key) or getattr(both, key) or math.inf
                yield GivenSurface((*path, "surface"), body, own.surface, radius, f"{table}.{key}")


def surface_faults(sections: Mapping[str, Any]) -> Iterator[Fault]:
    """What is wrong with surfaces, and what they do not go with."""
    geometry, surfaces = sections.get("geometry"), [*given_surfaces(sections)]
    for place in dict.fromkeys(given.path[: given.path.index("surface") + 1] for given in surfaces):
        if sections.get("history") is None:
            yield place, "is not computed in a steady state: surfaces roll through a contact over time", "with [history]"
        if geometry is not None and geometry.conformal:
            yield place, "is not computed with a conformal contact", "geometry.conformal = false"
    for given in surfaces:
        for number, part in enumerate(given.parts):
            path: KeyPath = (*given.path, number)
            yield from (((*path, *own), why, allowed) for own, why, allowed in _faults_of(part))
            if (part.name == "flat" or (part.repeat and part.kind)) and (math.isinf(given.radius) or given.radius < 0.0):
                convex = f"a {part.kind} needs a convex body: {given.radius_key} is {given.radius:g}"
                yield (*path, "kind"), convex, "a radius above 0"
            if is_line(sections):
                yield from (((*path, *own), why, allowed) for own, why, allowed in _faults_of_line(part))


def _faults_of(part: SurfaceTable) -> Iterator[tuple[tuple[str, ...], str, str]]:
    """What is wrong within one table."""
    if (part.kind is None) == (part.file is None):
        yield (), "needs a file or a kind", "one of both"
        return
    yield from (((key,), "is missing", f"a {part.name} needs {', '.join(NEEDED[part.name])}")
                for key in NEEDED.get(part.name, ()) if getattr(part, key) is None)
    known = {"kind", "file", "start_mm", "offset_mm", *NEEDED.get(part.name, ()), *OTHERS[part.name]}
    yield from (((key,), f"is no key of a {part.name}", ", ".join(sorted(known - {"kind", "file"})))
                for key in sorted(part.model_fields_set - known) if getattr(part, key) is not None)
    if (part.remove == "polynomial") != (part.degree is not None):
        yield ("degree",), "belongs to remove = \"polynomial\"", "both, or neither"
    if part.kind == "rough" and part.shortest_mm is not None and part.longest_mm is not None:
        if part.longest_mm < part.shortest_mm:
            yield ("longest_mm",), f"{part.longest_mm:g} is below shortest_mm", f"{part.shortest_mm:g} or more"
        elif math.prod(_points(part)[0]) > MOST_POINTS:
            counts = " × ".join(map(str, _points(part)[0]))
            yield (("longest_mm",), f"{part.longest_mm:g} takes {counts} points with shortest_mm",
                   f"a product of at most {MOST_POINTS}")


def _faults_of_line(part: SurfaceTable) -> Iterator[tuple[tuple[str, ...], str, str]]:
    """What a line contact does not have."""
    if part.kind == "dent":
        yield ("kind",), "a dent varies across rolling, a line contact does not", "wave, flat, rough, or heights of one column"
    if (part.angle_deg or 0.0) % 180.0:
        yield ("angle_deg",), f"{part.angle_deg:g}° turn the wave across rolling, where a line contact does not vary", "0"
    if (part.lay_ratio or 1.0) != 1.0:
        yield ("lay_ratio",), f"{part.lay_ratio:g} varies across rolling, which a line contact does not", "1"


def surface_of(parts: list[SurfaceTable] | None, body: BodyName, radius_mm: float, *, line: bool = False) -> Heights | None:
    """The surface of a `body` with a radius along rolling, of a `line` contact without any change across; None: smooth."""
    heights = tuple(heights_of(part, body, 1e-3 * abs(radius_mm), line=line) for part in parts or ())
    return Sum(heights) if len(heights) > 1 else heights[0] if heights else None


def heights_of(part: SurfaceTable, body: BodyName, radius: float, *, line: bool) -> Heights:
    """The heights of one table, of a body of a `radius` (m) along rolling."""
    start, side = part.si("start_mm"), part.si("offset_mm")
    turn = 2.0 * math.pi * radius if part.repeat else math.inf
    if part.kind == "wave":
        return Wave(part.si("amplitude_um"), part.si("wavelength_mm"), math.radians(part.angle_deg or 0.0), start, side)
    if part.kind == "dent":
        return Dent(part.si("depth_um"), part.si("radius_mm"), part.si("shoulder_um") or 0.0, start, side, turn)
    if part.kind == "flat":
        length = part.si("length_mm")
        return Flat(length, radius, 0.1 * length if part.rounding_mm is None else part.si("rounding_mm"), start, turn)
    if part.kind == "rough":
        return _rough(part, start, side, line=line)
    measured = reading_of(part, body)
    across = (measured.heights.shape[1] - 1) * measured.spacing[1]
    return MeasuredHeights(measured.heights, measured.spacing, start, side - 0.5 * across, (bool(part.repeat), False),
                           measured.shown["filled_share"])


def reading_of(part: SurfaceTable, body: BodyName) -> MeasuredSurface:
    """The heights in the file of a table, as it wants them. Raises TableError, OSError."""
    assert part.file is not None
    given = part.spacing_um
    spacing = None if given is None else (given, given) if isinstance(given, float | int) else (given[0], given[1])
    return read_surface(
        part.file, None if spacing is None else (spacing[0] / 1e6, spacing[1] / 1e6), part.unit, remove=part.remove or "plane",
        degree=part.degree or 1, smoothing=part.si("smoothing_mm") or 0.0, along=part.along or "x", flip=bool(part.flip),
        mirror=part.mirror, fill=part.fill is not None, repeats=bool(part.repeat), from_outside=body == "upper")


def _points(part: SurfaceTable) -> tuple[tuple[int, int], tuple[float, float]]:
    """Numbers of points along and across of a rough surface, and their spacing in m."""
    shortest, longest, angle = part.si("shortest_mm"), part.si("longest_mm"), math.radians(part.lay_angle_deg or 0.0)
    counts, spacings, ratio = [], [], part.lay_ratio or 1.0
    for along in (abs(math.cos(angle)), abs(math.sin(angle))):
        spacing = shortest / math.hypot(along / ratio, math.sqrt(1.0 - along**2)) / PER_WAVELENGTH
        length = PERIODS * longest * max(1.0, ratio * along)
        counts.append(math.ceil(length / spacing))
        spacings.append(length / counts[-1])
    return (counts[0], counts[1]), (spacings[0], spacings[1])


def _rough(part: SurfaceTable, start: float, side: float, *, line: bool) -> MeasuredHeights:
    """A self-affine surface: waves between both lengths with random phases, whose power falls like k^(−2−2H), of a profile like
    k^(−1−2H). Along its lay waves are longer."""
    counts, spacing = _points(part)
    if line:
        counts = counts[0], 1
    along, across = (2.0 * math.pi * np.fft.fftfreq(count, step) for count, step in zip(counts, spacing, strict=True))
    angle, hurst = math.radians(part.lay_angle_deg or 0.0), 0.8 if part.hurst is None else part.hurst
    cosine, sine = math.cos(angle), math.sin(angle)
    with_lay, against = along[:, None] * cosine + across * sine, across * cosine - along[:, None] * sine
    wave = np.hypot((part.lay_ratio or 1.0) * with_lay, against)
    inside = (wave >= 2.0 * math.pi / part.si("longest_mm") * (1.0 - 1e-9)) & (
        wave <= 2.0 * math.pi / part.si("shortest_mm") * (1.0 + 1e-9))
    exponent = -0.5 - hurst if line else -1.0 - hurst
    size = np.where(inside, np.where(inside, wave, 1.0) ** exponent, 0.0)
    random = np.random.default_rng(1 if part.seed is None else part.seed).random(counts)
    heights = np.fft.ifft2(size * np.exp(2j * math.pi * random)).real
    heights *= part.si("rms_um") / heights.std()
    return MeasuredHeights(heights, spacing, start, side, (True, not line))


@dataclass(frozen=True)
class MadeSurface:
    """A made surface for `show`, as `MeasuredSurface` is one of a file."""

    shown: dict[str, Any]

    def record(self) -> dict[str, Any]:
        """What `show` says."""
        return self.shown

    def words(self, record: dict[str, Any]) -> str:
        """The `record` as a sentence for people."""
        return f"a {record['kind']}: {texture_words(record)}"


def shown_surfaces(sections: Mapping[str, Any]) -> dict[str, MadeSurface | MeasuredSurface]:
    """How each surface was made or read, by the key of its table."""
    found: dict[str, MadeSurface | MeasuredSurface] = {}
    for given in given_surfaces(sections):
        for number, part in enumerate(given.parts):
            key = ".".join(map(str, (*given.path, *((number,) if len(given.parts) > 1 else ()))))
            if part.file is not None:
                found[key] = reading_of(part, given.body)
            else:
                texture = heights_of(part, given.body, 1e-3 * abs(given.radius), line=is_line(sections)).texture
                found[key] = MadeSurface({"kind": part.name, **texture_record(texture)})
    return found
