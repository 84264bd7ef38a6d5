"""How the profiles of one contact wear: its evolution as a journal keeps it, and as files have it."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from thermoroll_cli.files.case import Case
from thermoroll_cli.many_contacts.wheelset.curves import Points
from thermoroll_cli.one_contact.steady_state.scalars import sliding
from thermoroll_cli.problem.geometry import surfaces
from thermoroll_cli.problem.problem import BODIES, planar
from thermoroll_cli.problem.result import Result
from thermoroll_cli.studies.worn.evolution import STEPS_FROM_COLD, ContactState, evolution, line_load, worn_geometry
from thermoroll_cli.studies.worn.rows import FixedRows
from thermoroll_cli.studies.worn.steps import WearState
from thermoroll_cli.studies.worn.wearing import Record, Snapshots, Wearing, common_of
from thermoroll_cli.tools.journal import Journal
from thermoroll_cli.tools.runner import Workers


class WearOfContact(Wearing):
    """The profiles of both bodies of one contact."""

    from_cold = STEPS_FROM_COLD

    def states(self, start: ContactState | None, journal: Journal, workers: Workers, threads: int) -> Iterator[ContactState]:
        return evolution(self.case.problem, start, threads=threads)

    def points(self, state: WearState) -> dict[str, Points]:
        assert isinstance(state, ContactState)
        geometry = worn_geometry(planar(self.case.problem), state.rows, state.worn)
        return {name: getattr(geometry, f"{name}_profile").points for name, depth in state.worn.items() if depth.any()}

    def content(self, state: WearState) -> dict[str, Any]:
        assert isinstance(state, ContactState)
        content: dict[str, Any] = json.loads(self.case.to_json())
        for body, points in self.points_mm(state).items():
            content["geometry"].pop(f"{body}_radius_y_mm", None)
            content["geometry"][f"{body}_profile"] = {"points_mm": points}
        if state.result is not None and state.result.problem.approach is not None:
            content["load"]["approach_um"] = 1e6 * state.result.problem.approach
        return content

    def result(self, state: WearState, worn: Case, threads: int) -> Result:
        assert isinstance(state, ContactState) and state.result is not None
        return state.result.with_case(worn.text, worn.to_json())

    def record_of(self, state: WearState) -> dict[str, Any]:
        """Also over y (m) the line load (N/m) and the largest T_γ/A (Pa)."""
        record = super().record_of(state)
        assert isinstance(state, ContactState)
        if state.result is None:
            return record
        work = sliding(state.result.problem, state.result.coupled.fields)[1].max(axis=0)
        return record | {
            "rows": asdict(state.rows), "domain": asdict(state.domain), "grid": state.grid, "y": state.result.y.tolist(),
            "line_load": line_load(state.result).tolist(), "T_gamma_per_area": work.tolist()}

    def state_of(self, record: Record) -> ContactState:
        return ContactState(**common_of(record), rows=FixedRows(**record["rows"]), domain=FixedRows(**record["domain"]),
                            grid=(record["grid"][0], record["grid"][1]))

    def over(self, states: Sequence[WearState], records: Sequence[Record]) -> Snapshots:
        """At the rows of the last one."""
        known = [state for state in states if isinstance(state, ContactState)]
        rows = known[-1].rows
        on_rows = [state.on(rows).worn for state in known]
        profiles = {body: np.asarray(surface.height(rows.y) - np.array([worn[body] for worn in on_rows]))
                    for body, surface in zip(BODIES, surfaces(planar(self.case.problem)), strict=True)}
        loads, work = (np.array([np.interp(rows.y, record["y"], record[name], left=0.0, right=0.0) for record in records])
                       for name in ("line_load", "T_gamma_per_area"))
        return Snapshots(np.array([state.distance for state in known]), rows.y, profiles, np.asarray(loads), np.asarray(work))
