"""Files of an evolution: a journal of its steps, a table, the group /wear of a result file, the worn case and its profiles."""

from __future__ import annotations

import json
import pathlib
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from thermoroll_cli.files.case import Case
from thermoroll_cli.files.result.labelled import Labelled, Node, axis
from thermoroll_cli.files.table_file import columns_node
from thermoroll_cli.many_contacts.wheelset.curves import Points
from thermoroll_cli.many_contacts.wheelset.wheelset_problem import WheelsetProblem
from thermoroll_cli.one_contact.steady_state.scalars import sliding
from thermoroll_cli.problem.columns import Columns
from thermoroll_cli.problem.geometry import surfaces
from thermoroll_cli.problem.problem import BODIES, BodyName, Problem, Wear, planar
from thermoroll_cli.studies.worn.evolution import STEPS_FROM_COLD, ContactState, line_load, worn_geometry
from thermoroll_cli.studies.worn.rows import FixedRows
from thermoroll_cli.studies.worn.service import outlines_of, wearing, worn_outlines
from thermoroll_cli.studies.worn.steps import WearState
from thermoroll_cli.tools.arrays import Array
from thermoroll_cli.tools.atomic import write_bytes

Record = Mapping[str, Any]
OUTLINE_OF = {"rail": ("track", "rail_profile"), "wheel": ("wheelset", "wheel_profile")}
"""Table and key of the outline of a case."""


def record_of(state: WearState) -> dict[str, Any]:
    """A solved state as a line of the journal: its row of the table and the worn depths (m) on rows; of a contact also over
    y (m) the line load (N/m) and the largest T_γ/A (Pa)."""
    record = {"key": str(state.steps), "solved": not state.reason, "row": state.row, "distance": state.distance,
              "worn": {name: depth.tolist() for name, depth in state.worn.items()}, "sizes": state.sizes,
              "error_shares": {name: shares.tolist() for name, shares in state.error_shares.items()}}
    if isinstance(state, ContactState) and state.result is not None:
        result = state.result
        work = sliding(result.problem, result.coupled.fields)[1].max(axis=0)
        record |= {"rows": asdict(state.rows), "domain": asdict(state.domain), "grid": state.grid, "y": result.y.tolist(),
                   "line_load": line_load(result).tolist(), "T_gamma_per_area": work.tolist()}
    return record


def state_of(record: Record) -> WearState:
    """The state, not solved, of a line of the journal."""
    worn, error_shares = ({name: np.array(values) for name, values in record[key].items()} for key in ("worn", "error_shares"))
    common = {"steps": int(record["key"]), "distance": record["distance"], "worn": worn, "sizes": record["sizes"],
              "error_shares": error_shares}
    if "rows" not in record:
        return WearState(**common)
    return ContactState(**common, rows=FixedRows(**record["rows"]), domain=FixedRows(**record["domain"]),
                        grid=(record["grid"][0], record["grid"][1]))


def resumed(journal: Mapping[str, Record]) -> WearState | None:
    """The last state of a journal from which an evolution goes on as if undisturbed: of a contact before a cold start."""
    steps = [int(key) for key in journal if "/" not in key]
    cold = STEPS_FROM_COLD if steps and "rows" in journal[str(steps[0])] else 1
    last = max((step for step in steps if step % cold == 0), default=0)
    return state_of(journal[str(last)]) if last else None


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

    @classmethod
    def of(cls, problem: Problem | WheelsetProblem, wear: Wear, records: Sequence[Record]) -> Snapshots:
        """As many of the records as are asked for, evenly over the largest worn depth, with the first and the last one; of a
        contact at the rows of the last one."""
        states = [state_of(record) for record in records]
        depth = np.array([state.deepest for state in states])
        wanted = np.linspace(0.0, depth[-1], wear.snapshots + 1)
        chosen = sorted({int(np.argmin(np.abs(depth - d))) for d in wanted} | {0, len(records) - 1})
        shown = [states[i] for i in chosen]
        distances, last = np.array([state.distance for state in shown]), shown[-1]
        if isinstance(problem, WheelsetProblem):
            lengths = {name: np.asarray((np.arange(len(last.worn[name])) + 0.5) * size) for name, size in last.sizes.items()}
            return cls(distances, depths={name: np.array([state.worn[name] for state in shown]) for name in lengths},
                       lengths=lengths)
        assert isinstance(last, ContactState)
        y = last.rows.y
        on_rows = [state.on(last.rows).worn for state in shown if isinstance(state, ContactState)]
        profiles = {body: np.asarray(surface.height(y) - np.array([worn[body] for worn in on_rows]))
                    for body, surface in zip(BODIES, surfaces(planar(problem)), strict=True)}
        loads, work = (np.array([np.interp(y, records[i]["y"], records[i][name], left=0.0, right=0.0) for i in chosen])
                       for name in ("line_load", "T_gamma_per_area"))
        return cls(distances, y, profiles, np.asarray(loads), np.asarray(work))


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


def worn_points(task: Problem | WheelsetProblem, state: WearState) -> dict[str, list[list[float]]]:
    """Points in mm over the whole profile of each worn body, [y, height], or outline of a wheelset, [y, z]."""
    worn, points = [name for name, depth in state.worn.items() if depth.any()], dict[str, Points]()
    if isinstance(task, WheelsetProblem):
        outlines = worn_outlines(outlines_of(task), state)
        points = {name: outlines[name].worn for name in worn}
    else:
        assert isinstance(state, ContactState)
        geometry = worn_geometry(planar(task), state.rows, state.worn)
        points = {body: getattr(geometry, f"{body}_profile").points for body in worn}
    return {name: [[float(f"{1e3 * y:.9g}"), float(f"{1e3 * z:.9g}")] for y, z in line] for name, line in points.items()}


def worn_case(case: Case, state: WearState) -> Case:
    """`case` with the worn profiles in place of its own; of a wheelset at the first of its positions."""
    positions = case.settings.wear and case.settings.wear.positions
    if positions:
        values = positions[0][1]
        assert isinstance(values, dict)
        case = case.with_values(values)
    content = json.loads(case.to_json())
    for name, points in worn_points(wearing(case), state).items():
        body, _, side = name.partition("_")
        if side:
            section, key = OUTLINE_OF[body]
            own = content[section].get(side) or {}
            content[section][side] = own | {key: {"points_mm": points}}
        else:
            content["geometry"].pop(f"{body}_radius_y_mm", None)
            content["geometry"][f"{body}_profile"] = {"points_mm": points}
    if isinstance(state, ContactState) and state.result is not None and state.result.problem.approach is not None:
        content["load"]["approach_um"] = 1e6 * state.result.problem.approach
    return Case.from_json(json.dumps(content), name=case.name)


def write_profiles(folder: pathlib.Path, case: Case, state: WearState) -> list[pathlib.Path]:
    """The worn profiles as CSV files that a case reads again, where they lie: without offset and tilt. Raises OSError."""
    written = []
    for name, points in worn_points(wearing(case), state).items():
        path = folder / f"{case.name}_worn_{name}.csv"
        lines = "".join(f"{y!r},{z!r}\n" for y, z in points)
        about = ("y in mm to the field side, z in mm down" if "_" in name
                 else "y in mm, height in mm; offset and tilt of the case are in it")
        write_bytes(path, (f"# {about}\n" + lines).encode())
        written.append(path)
    return written
