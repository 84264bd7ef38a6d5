"""What wears in a case: how a kind of problem wears, as a journal keeps it and as files have it. One contact and a wheelset are
the kinds that do (`wear_of_contact`, `wear_of_wheelset`)."""

from __future__ import annotations

import json
import pathlib
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from thermoroll_cli.files.case import Case
from thermoroll_cli.files.result.labelled import Labelled, Node, axis
from thermoroll_cli.files.table_file import columns_node
from thermoroll_cli.many_contacts.wheelset.curves import Points
from thermoroll_cli.problem.columns import Columns
from thermoroll_cli.problem.geometry import Unsolvable
from thermoroll_cli.problem.problem import BodyName, Wear
from thermoroll_cli.problem.result import Result
from thermoroll_cli.studies.worn.steps import WearState
from thermoroll_cli.tools.arrays import Array
from thermoroll_cli.tools.atomic import write_bytes
from thermoroll_cli.tools.journal import Journal
from thermoroll_cli.tools.runner import Workers

Record = Mapping[str, Any]


@dataclass(frozen=True)
class Snapshots:
    """Some steps, after `distances` (m): `profiles` (m, by body), `loads` (N/m) and the largest T_γ/A (Pa), `work`, each
    (snapshots, points), at `y` (m). Of a wheelset only the worn `depths` (m) of its outlines by name, (snapshots, rows), with
    the rows' middles along the outlines in `lengths` (m)."""

    distances: Array
    y: Array = field(default_factory=lambda: np.zeros(0))
    profiles: Mapping[BodyName, Array] = field(default_factory=dict)
    loads: Array = field(default_factory=lambda: np.zeros(0))
    work: Array = field(default_factory=lambda: np.zeros(0))
    depths: Mapping[str, Array] = field(default_factory=dict)
    lengths: Mapping[str, Array] = field(default_factory=dict)


class Wearing(ABC):
    """What wears in a `case`."""

    from_cold: ClassVar[int] = 1
    """An evolution goes on as if undisturbed from every state whose number of steps is a multiple of this."""

    def __init__(self, case: Case) -> None:
        self.case, self.task = case, case.task

    @cached_property
    def asked(self) -> Wear:
        """What is asked for. Raises Unsolvable."""
        asked: Wear | None = self.task.contact.wear
        if asked is None or asked.distance == asked.depth:
            raise Unsolvable("the case does not say how far the profiles wear", "wear", "a table with distance_km or depth_um")
        return asked

    @property
    def shares_work(self) -> bool:
        """Whether several processes can share a step. Raises CaseError, Unsolvable for positions that cannot be."""
        return False

    @abstractmethod
    def states(self, start: Any, journal: Journal, workers: Workers, threads: int) -> Iterator[WearState]:
        """The states from the unworn profiles or from `start`."""

    @abstractmethod
    def points(self, state: WearState) -> Mapping[str, Points]:
        """Points (m) over the whole profile of each worn body, or of each worn outline, by name."""

    @abstractmethod
    def content(self, state: WearState) -> dict[str, Any]:
        """The tables of the case with the worn profiles in place of its own."""

    @abstractmethod
    def result(self, state: WearState, worn: Case, threads: int) -> Result | None:
        """The result with the profiles of `state`, those of the case `worn`; None if that is none."""

    @abstractmethod
    def over(self, states: Sequence[WearState], records: Sequence[Record]) -> Snapshots:
        """The snapshots of some `states`, of which the journal has the `records`."""

    def outlines(self, state: WearState) -> Mapping[str, tuple[Points, Points]]:
        """Of a wheelset, the points (y, z) in m of the new and of the worn outline by name."""
        return {}

    def record_of(self, state: WearState) -> dict[str, Any]:
        """A solved state as a line of the journal: its row of the table and the worn depths (m) on rows."""
        return {"key": str(state.steps), "solved": not state.reason, "row": state.row, "distance": state.distance,
                "worn": {name: depth.tolist() for name, depth in state.worn.items()}, "sizes": state.sizes,
                "error_shares": {name: shares.tolist() for name, shares in state.error_shares.items()}}

    def state_of(self, record: Record) -> WearState:
        """The state, not solved, of a line of the journal."""
        return WearState(**common_of(record))

    def resumed(self, journal: Mapping[str, Record]) -> WearState | None:
        """The last state of a journal from which an evolution goes on as if undisturbed."""
        steps = (int(key) for key in journal if "/" not in key)
        last = max((step for step in steps if step % self.from_cold == 0), default=0)
        return self.state_of(journal[str(last)]) if last else None

    def snapshots(self, records: Sequence[Record]) -> Snapshots:
        """As many of the records as are asked for, evenly over the largest worn depth, with the first and the last one."""
        states = [self.state_of(record) for record in records]
        depth = np.array([state.deepest for state in states])
        wanted = np.linspace(0.0, depth[-1], self.asked.snapshots + 1)
        chosen = sorted({int(np.argmin(np.abs(depth - d))) for d in wanted} | {0, len(records) - 1})
        return self.over([states[i] for i in chosen], [records[i] for i in chosen])

    def points_mm(self, state: WearState) -> dict[str, list[list[float]]]:
        """The worn `points` in mm: [y, height] of a profile, [y, z] of an outline."""
        return {name: [[float(f"{1e3 * y:.9g}"), float(f"{1e3 * z:.9g}")] for y, z in line]
                for name, line in self.points(state).items()}

    def worn_case(self, state: WearState) -> Case:
        """The case with the worn profiles in place of its own; of a wheelset at the first of its positions."""
        return Case.from_json(json.dumps(self.content(state)), name=self.case.name)


def write_profiles(folder: pathlib.Path, what: Wearing, state: WearState) -> list[pathlib.Path]:
    """The worn profiles as CSV files that a case reads again, where they lie: without offset and tilt. Raises OSError."""
    written = []
    for name, points in what.points_mm(state).items():
        path = folder / f"{what.case.name}_worn_{name}.csv"
        lines = "".join(f"{y!r},{z!r}\n" for y, z in points)
        about = ("y in mm to the field side, z in mm down" if "_" in name
                 else "y in mm, height in mm; offset and tilt of the case are in it")
        write_bytes(path, (f"# {about}\n" + lines).encode())
        written.append(path)
    return written


def common_of(record: Record) -> dict[str, Any]:
    """What every line of a journal says of its state."""
    worn, error_shares = ({name: np.array(values) for name, values in record[key].items()} for key in ("worn", "error_shares"))
    return {"steps": int(record["key"]), "distance": record["distance"], "worn": worn, "sizes": record["sizes"],
            "error_shares": error_shares}


def wear_node(table: Columns, kept: Snapshots) -> Node:
    """The node `wear` of a result: columns over the `steps`, and the snapshots."""
    arrays = axis("distance", kept.distances, "m", "distance rolled")
    for name, depth in kept.depths.items():
        where = " ".join(reversed(name.split("_")))
        arrays |= axis(f"length_{name}", kept.lengths[name], "m", f"middle of a row along the new outline of the {where}")
        arrays[f"depth_{name}"] = Labelled(("distance", f"length_{name}"), depth, "m", f"depth worn off the {where}")
    if kept.profiles:
        over = ("distance", "y")
        arrays |= axis("y", kept.y, "m", "lateral") | {
            **{f"profile_{body}": Labelled(over, heights, "m", f"height of the {body} body")
               for body, heights in kept.profiles.items()},
            "line_load": Labelled(over, kept.loads, "N/m", "pressure integrated along rolling"),
            "T_gamma_per_area": Labelled(over, kept.work, "Pa", "largest frictional work per area and distance rolled")}
    return Node(arrays, nodes={"steps": columns_node(table)})
