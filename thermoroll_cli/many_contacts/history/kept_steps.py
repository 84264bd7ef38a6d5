"""Steps that are kept in a journal as soon as they are solved, from which a history that was stopped goes on.

A record has what later steps and the table need of a step: its pressure and tractions with the displacement by them, the fields
that act back, its heat, its scalars, and its fields where they are asked for. Everything else is computed again:
a history that goes on is, to the last bit, the one that was not stopped. Arrays are compressed .npy files in base64.
"""

from __future__ import annotations

import base64
import binascii
import io
import json
import pathlib
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from thermoroll_cli.many_contacts.history.course import History
from thermoroll_cli.one_contact.steady_state.fixed_point import SteadyState, unknowns_of
from thermoroll_cli.physics.heat.heat_response import DividedHeat
from thermoroll_cli.physics.numerics.grid import Grid
from thermoroll_cli.problem.contact import Contact, Pressure, Traction
from thermoroll_cli.problem.result import Result, State
from thermoroll_cli.tools.arrays import AnyArray
from thermoroll_cli.tools.journal import Journal, JournalError

LAYOUT = 2
"""Raised whenever records change."""


class Step(NamedTuple):
    """A step that is solved: the solver's `state`, the `heat` that it releases (None: none), and its `scalars` and `fields` as
    far as they are reported."""

    state: SteadyState
    heat: DividedHeat | None
    scalars: Mapping[str, float]
    fields: Mapping[str, AnyArray]


@dataclass(frozen=True)
class KeptSteps:
    """The steps of one `run` over the course in a `journal` (None: nothing is kept)."""

    journal: Journal | None = None
    run: str = ""

    def find(self, number: int, grid: Grid) -> Step | None:
        """The step with this `number`, if it was kept. Raises JournalError for one that cannot be read."""
        key = f"{self.run}/{number}"
        if self.journal is None or key not in self.journal:
            return None
        try:
            return _step(self.journal[key], grid)
        except (KeyError, TypeError, ValueError, EOFError, zlib.error, binascii.Error) as cause:
            raise JournalError(f"{self.journal.path}: the step {key} cannot be read; leave --resume out") from cause

    def keep(self, number: int, state: SteadyState, heat: DividedHeat | None, reported: State | None, *, whole: bool) -> None:
        """Keep a step with its number; the `whole` of what is reported, or its scalars alone. Raises WriteError."""
        if self.journal is None:
            return
        contact, tangential = state.contact, state.contact.tangential
        arrays = {"pressure": contact.normal.pressure, "whole_elements": contact.normal.whole_elements,
                  "traction": tangential.traction, "displacement": tangential.displacement,
                  "slip_friction": tangential.friction, "hardening": tangential.hardening, **unknowns_of(contact)}
        if heat is not None:
            arrays |= {"heat": heat.total, "heat_slope": heat.slope, "exchanged": heat.exchanged}
        self.journal.keep({
            "key": f"{self.run}/{number}", "converged": state.converged, "applications": state.applications,
            "touches_rim": state.touches_rim, "creepage": tangential.creepage, "power": tangential.work,
            "share": None if heat is None else heat.share,
            "arrays": {name: _text(array) for name, array in arrays.items() if array is not None},
            "scalars": {} if reported is None else dict(reported.scalars),
            "fields": {name: _text(field) for name, field in reported.fields.items()} if whole and reported else {}})


NOTHING_KEPT = KeptSteps()


def journal_of(path: pathlib.Path, history: History, case: str, *, resume: bool) -> Journal:
    """The journal at `path` of a `history`, which the text of a `case` (JSON) describes. Raises JournalError, WriteError."""
    begin = history.course.begin
    given = [begin.fields[name].tobytes() for name in ("shear_x", "shear_y")] if isinstance(begin, Result) else []
    identity = {"case": json.loads(case), "begin": list(map(zlib.crc32, given))}
    return Journal(path, {"kind": "history", "layout": LAYOUT, **identity}, resume=resume)


def _step(record: Mapping[str, Any], grid: Grid) -> Step:
    arrays = {name: _array(text) for name, text in record["arrays"].items()}
    pressure, nothing = arrays.pop("pressure"), np.zeros(grid.shape)
    heat = None if record["share"] is None else DividedHeat(
        arrays.pop("heat"), record["share"], arrays.pop("exchanged", None), arrays.pop("heat_slope"))
    traction = Traction(
        arrays.pop("traction"), np.zeros((2, *grid.shape)), pressure > 0.0, tuple(record["creepage"]), nothing, nothing,
        record["power"], converged=record["converged"], friction=arrays.pop("slip_friction", None),
        hardening=arrays.pop("hardening", None), displacement=arrays.pop("displacement", None))
    normal = Pressure(pressure, (pressure > 0.0).astype(float), nothing, nothing, approach=0.0, peak=float(pressure.max()),
                      whole_elements=arrays.pop("whole_elements", None))
    state = SteadyState(Contact(normal, traction, **arrays), 0, 0.0, record["converged"], 0, record["applications"], 0,
                        record["touches_rim"], ())
    return Step(state, heat, record["scalars"], {name: _array(text) for name, text in record["fields"].items()})


def _text(array: AnyArray) -> str:
    file = io.BytesIO()
    np.save(file, array, allow_pickle=False)
    return base64.b64encode(zlib.compress(file.getvalue(), 1)).decode("ascii")


def _array(text: str) -> AnyArray:
    return np.asarray(np.load(io.BytesIO(zlib.decompress(base64.b64decode(text))), allow_pickle=False))
