"""All kinds of pictures of a run, and how they get into files. Maps of fields, of line contacts curves over x, are those of
`names.QUANTITIES`; a new kind is a function and a line in `KINDS`."""

from __future__ import annotations

import pathlib
from collections.abc import Callable, Sequence
from functools import partial

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from thermoroll_cli.plots.cuts import centreline_figure, curve_figure, curves_of, draw_diagram, track_figure
from thermoroll_cli.plots.maps import field_figure, flow_label, map_on
from thermoroll_cli.plots.profile_figures import profile_figure
from thermoroll_cli.plots.run_frame import RunFrame, frame_of
from thermoroll_cli.plots.style import applied, save
from thermoroll_cli.plots.subsurface_figures import shakedown_map_figure, strength_figure, stress_map_on, subsurface_figure
from thermoroll_cli.plots.summary_sheet import summary_figure
from thermoroll_cli.plots.surface_figure import surface_figure
from thermoroll_cli.problem.names import FIELDS, QUANTITIES, Quantity
from thermoroll_cli.problem.problem import BODIES
from thermoroll_cli.problem.result import Result
from thermoroll_cli.tools.process import safe_point

Draw = Callable[[RunFrame], Figure | None]


def _of_field(frame: RunFrame, quantity: Quantity) -> Figure | None:
    """A map of a quantity; of a line contact its curve over x."""
    return (curve_figure if frame.line else field_figure)(frame, quantity)


KINDS: dict[str, Draw] = {
    **{name: partial(_of_field, quantity=quantity) for name, quantity in QUANTITIES.items()},
    "surface": lambda frame: surface_figure(frame.result),
    "profile": profile_figure,
    "centreline": centreline_figure,
    "track": track_figure,
    "summary": summary_figure,
    "subsurface_lower": partial(subsurface_figure, body="lower"),
    "subsurface_upper": partial(subsurface_figure, body="upper"),
    "strength_lower": partial(strength_figure, body="lower"),
    "strength_upper": partial(strength_figure, body="upper"),
    "shakedown_map": shakedown_map_figure,
}
"""Pictures of a run by the end of their file names (`STEM_pressure.png`, …). A function returns None where there is nothing to
show: where a stage was skipped, or a field vanishes everywhere."""


STRESS_MAPS = {f"subsurface_{body}": body for body in BODIES}
"""Pictures of several diagrams of which axes of the caller show one, the map of the von Mises stress in this body."""


def kinds_of(result: Result) -> tuple[str, ...]:
    """The pictures that a run draws."""
    return tuple(result.kind.answer.pictures or KINDS)


def figure(result: Result, kind: str = "", *, normalised: bool = False, cut_y: float | None = None) -> Figure | None:
    """The picture of this kind (`KINDS`, or any field of the result; of an assembly those of its kind); by default the
    summary, or the first of the assembly. None where there is nothing to show.

    `normalised` draws the article's dimensionless quantities: p/p0, |τ|/p0, q α l/k (l = 1 mm), x/a0, y/b0. `cut_y` (m) is the
    line of the picture "centreline". Raises ValueError for an unknown kind or a cut outside the domain.
    """
    if kinds := result.kind.answer.pictures:
        if kind and kind not in kinds:
            raise ValueError(f"the picture {kind!r} is none of {', '.join(kinds)}; its patches have those of a contact")
        with applied():
            return kinds[kind or next(iter(kinds))](result)
    draw = _kind(kind or "summary")
    with applied():
        return draw(frame_of(result, normalised, cut_y))


def draw_on(axes: Axes, result: Result, kind: str = "", *, normalised: bool = False) -> None:
    """Draw a quantity of the last state of a contact on the caller's `axes`: its map with borders and a colour bar, of the
    hotter body where they differ, of a line contact its curve over x.

    `kind` is one of the maps of `figure`, by default the pressure; "subsurface_lower" and "subsurface_upper" are the map of the
    von Mises stress alone. Raises ValueError for another picture, for an assembly, and where there is nothing to show."""
    if result.assembly:
        raise ValueError("an assembly has pictures of several diagrams: draw one of its contacts on axes of your own")
    frame = frame_of(result, normalised)
    if kind in STRESS_MAPS:
        stress_map_on(axes, frame, STRESS_MAPS[kind])
        return
    if kind in KINDS and kind not in QUANTITIES:
        raise ValueError(f"the picture {kind!r} has several diagrams: on axes of yours go "
                         f"{', '.join((*QUANTITIES, *STRESS_MAPS))}, and fields")
    quantity = _quantity(kind or "pressure")
    if frame.line and (curves := curves_of(frame, quantity)):
        draw_diagram(axes, frame, quantity, curves)
        axes.set_xlabel(flow_label(frame))
    elif frame.line or not map_on(axes, frame, quantity):
        raise ValueError(f"there is nothing to show of {quantity.name} in this result")


def draw(
    result: Result, stem: pathlib.Path, *, kinds: Sequence[str] = (), formats: Sequence[str] = ("png",),
    dpi: float | None = None, normalised: bool = False, cut_y: float | None = None,
) -> list[pathlib.Path]:
    """Write the pictures of `result` as `STEM_pressure.png`, … in each of the `formats`, and return their paths.

    `kinds` (all of them if none is given) and the other options are those of `figure`; those of contacts are drawn for each
    contact of an assembly that is shown (`STEM_left_1_pressure.png`). `dpi` is the resolution of PNG files. Raises ValueError
    for an unknown kind or format and for a cut outside the domain, OSError where a file cannot be written.
    """
    kinds = kinds or kinds_of(result)
    whole = result.kind.answer.pictures
    of_contacts = {kind: _kind(kind) for kind in kinds if kind not in whole}
    written = []
    with applied():
        for kind in (kind for kind in kinds if kind in whole):
            written += _saved(whole[kind](result), stem, kind, formats, dpi)
        for name, contact in result.by_suffix.items():
            if not any(contact is shown for shown in result.shown or (result,)):
                continue
            frame = frame_of(contact, normalised, cut_y) if of_contacts else None
            for kind, draw_kind in of_contacts.items():
                safe_point()
                assert frame is not None
                written += _saved(draw_kind(frame), stem.with_name(stem.name + name), kind, formats, dpi)
    return written


def _saved(
    picture: Figure | None, stem: pathlib.Path, kind: str, formats: Sequence[str], dpi: float | None
) -> list[pathlib.Path]:
    return [save(picture, stem.with_name(f"{stem.name}_{kind}.{ending}"), dpi) for ending in formats] if picture else []


def _kind(name: str) -> Draw:
    """How a picture is drawn: that of a kind, or a map of any field (vectors by their length). Raises ValueError."""
    return KINDS[name] if name in KINDS else partial(_of_field, quantity=_quantity(name))


def _quantity(name: str) -> Quantity:
    """The quantity of a map: one of `QUANTITIES`, or any field (vectors by their length). Raises ValueError."""
    if name in QUANTITIES:
        return QUANTITIES[name]
    parts = tuple(field for field in FIELDS if field in (name, f"{name}_x", f"{name}_y"))
    if not parts:
        vectors = dict.fromkeys(field[:-2] for field in FIELDS if field.endswith("_x"))
        raise ValueError(f"there is no picture {name!r}; there are {', '.join(KINDS)}, and maps of the fields "
                         f"{', '.join((*FIELDS, *vectors))}")
    first = FIELDS[parts[0]]
    words = first.meaning.removesuffix(" along x") if len(parts) == 2 else first.meaning
    return Quantity(name, parts, words, "", "", "viridis", "", from_zero=False)
