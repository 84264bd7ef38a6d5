"""What a contact over time rolls over: maps of its surfaces, or their heights along rolling, that a result keeps."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from thermoroll_cli.many_contacts.history.course import History
from thermoroll_cli.many_contacts.wheelset.patch_problem import SolvedPatch
from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.problem.problem import BODIES
from thermoroll_cli.problem.result import SurfaceMap
from thermoroll_cli.problem.surface import Heights

AROUND = 1.6
"""Half the width that is kept, in half-widths of the contact."""
ALONG, ACROSS = 800, 120
"""Points of a map."""


def maps_of_contact(history: History) -> dict[str, SurfaceMap]:
    """Maps of the surfaces of both bodies of a contact, by "lower" and "upper", with the contact of the largest load."""
    if not any(history.surfaces):
        return {}
    scales, distances = DerivedQuantities(history.largest).scales, history.clock(history.course.rows)[1]
    starts, half = history.begins_at(float(distances[0])), (scales.semi_axis_x, scales.semi_axis_y)
    rolled = float(np.ptp(distances))
    return {body: _map(surface, (first, first + rolled), half, None if history.problem.line else scales.centre)
            for body, surface, (first, _) in zip(BODIES, history.surfaces, starts, strict=True) if surface is not None}


def maps_of_wheelset(first: Iterable[SolvedPatch], last: Iterable[SolvedPatch]) -> dict[str, SurfaceMap]:
    """Maps of the surfaces below the patches with the largest loads, by "left rail", …, from the first to the last row."""
    found = {}
    begins, ends = ({patch.side: patch for patch in sorted(row, key=lambda each: each.carrying.load)} for row in (first, last))
    for side in begins.keys() & ends.keys():
        one, other = (row[side].carrying.patch for row in (begins, ends))
        loaded = np.asarray(ends[side].result.coupled.fields["pressure"]) > 0.0
        state = ends[side].result.coupled
        half = tuple(0.5 * float(np.ptp(places[loaded.any(axis=axis)])) for axis, places in ((1, state.x), (0, state.y)))
        for body, (surface, end, y) in other.surfaces.items():
            found[f"{side} {body}"] = _map(surface, (one.surfaces[body][1], end), (half[0], half[1]), y)
    return dict(sorted(found.items()))


def _map(surface: Heights, path: tuple[float, float], half: tuple[float, float], centre: float | None) -> SurfaceMap:
    """The map along a `path` (m) of the middle of a contact with half-lengths `half`, about y = `centre` (None: of a line)."""
    around = AROUND * half[0]
    along = np.linspace(path[0] - around, path[1] + around, ALONG + 1)
    if centre is None:
        return SurfaceMap(along, np.zeros(0), surface.over(along, np.array([-np.inf, np.inf])), path, half, 0.0)
    across = centre + AROUND * half[1] * np.linspace(-1.0, 1.0, ACROSS + 1)
    return SurfaceMap(along, across, surface.over(along, across).astype(np.float32), path, half, centre)
