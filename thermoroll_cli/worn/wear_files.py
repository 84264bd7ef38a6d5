"""Files of an evolution: a journal of its steps, a table, the group /wear of a result file, the worn case and its profiles."""

from __future__ import annotations

import csv
import io
import json
import pathlib
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import h5py
import numpy as np

from thermoroll_cli.arrays import Array
from thermoroll_cli.atomic import write_bytes
from thermoroll_cli.files.case import Case
from thermoroll_cli.numerics.grid import between_sides
from thermoroll_cli.problem.geometry import surfaces
from thermoroll_cli.problem.problem import BODIES, BodyName, Problem, planar
from thermoroll_cli.refinement.scalars import sliding
from thermoroll_cli.worn.evolution import STEPS_FROM_COLD, WearState, half_width, line_load, worn_geometry
from thermoroll_cli.worn.rows import FixedRows

COLUMNS = {
    "distance_km": "distance rolled", "depth_max_lower_um": "largest worn depth, lower body",
    "depth_max_upper_um": "largest worn depth, upper body", "worn_area_lower_mm2": "worn cross-section, lower body",
    "worn_area_upper_mm2": "worn cross-section, upper body", "half_width_mm": "half-width of the contact",
    "line_load_max_N_mm": "largest line load", "pressure_max_MPa": "maximum pressure", "T_gamma_N": "wear number Tγ",
    "approach_um": "rigid-body approach", "normal_N": "load",
}  # fmt: skip
"""Columns of the table, with their meanings."""
ESTIMATED = tuple(name for name in COLUMNS if not name.startswith(("distance", "half_width", "line_load")))
"""Columns with an estimated error, `error.NAME`: over the value, as everywhere."""

Record = Mapping[str, Any]


def record_of(state: WearState) -> dict[str, Any]:
    """A solved state as a line of the journal: its row of the table, the worn depths (m) on rows, and over y (m) the line load
    (N/m) and the largest T_γ/A (Pa)."""
    result = state.result
    assert result is not None
    scalars, error = result.coupled.scalars, {name: result.error.get(name) for name in ESTIMATED}
    row: dict[str, Any] = {"distance_km": state.distance * 1e-3}
    for body in BODIES:
        depth, area = state.worn_depth(body), state.worn_area(body)
        depth_error, area_error = state.errors(body)
        row |= {f"depth_max_{body}_um": depth * 1e6, f"worn_area_{body}_mm2": area * 1e6}
        error |= {f"depth_max_{body}_um": depth_error / depth if depth else 0.0,
                  f"worn_area_{body}_mm2": area_error / area if area else 0.0}
    load = line_load(result)[None]
    largest = float(between_sides(load, load, (True, True)).max())  # as the largest pressure
    row |= {"half_width_mm": half_width(result) * 1e3, "line_load_max_N_mm": largest * 1e-3,
            **{name: scalars[name] for name in ("pressure_max_MPa", "T_gamma_N", "approach_um", "normal_N")}}
    row = {name: row[name] for name in COLUMNS} | {"error": {name: error[name] for name in ESTIMATED}}
    return {
        "key": str(state.steps), "distance": state.distance, "rows": asdict(state.rows), "domain": asdict(state.domain),
        "grid": state.grid, "worn": {body: state.worn[body].tolist() for body in BODIES},
        "error_shares": {body: state.error_shares[body].tolist() for body in BODIES}, "row": row, "load_y": result.y.tolist(),
        "load": line_load(result).tolist(), "work": sliding(result.problem, result.coupled.fields)[1].max(axis=0).tolist(),
    }  # fmt: skip


def state_of(record: Record) -> WearState:
    """The state, not solved, of a line of the journal."""
    worn, error_shares = ({body: np.array(record[name][body]) for body in BODIES} for name in ("worn", "error_shares"))
    return WearState(int(record["key"]), record["distance"], FixedRows(**record["rows"]), worn, FixedRows(**record["domain"]),
                     (record["grid"][0], record["grid"][1]), error_shares)


def resumed(journal: Mapping[str, Record]) -> WearState | None:
    """The last state of a journal from which an evolution goes on as if undisturbed: before a cold start."""
    steps = max((int(key) for key in journal if int(key) % STEPS_FROM_COLD == 0), default=0)
    return state_of(journal[str(steps)]) if steps else None


def table(rows: Sequence[Record]) -> bytes:
    """The rows as CSV, the errors last."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([*COLUMNS, *(f"error.{name}" for name in ESTIMATED)])
    for row in rows:
        errors = [row["error"][name] for name in ESTIMATED]
        writer.writerow([*(f"{row[name]:.7g}" for name in COLUMNS), *("nan" if e is None else f"{e:.3g}" for e in errors)])
    return text.getvalue().encode()


@dataclass(frozen=True)
class Snapshots:
    """Profiles (m, by body), `loads` (N/m) and the largest T_γ/A (Pa), `work`, each (snapshots, points), at `y` (m) after
    `distances` (m)."""

    y: Array
    distances: Array
    profiles: dict[BodyName, Array]
    loads: Array
    work: Array

    @classmethod
    def of(cls, problem: Problem, records: Sequence[Record]) -> Snapshots:
        """As many of the records as are asked for, evenly over the largest worn depth, with the first and the last one, at
        the rows of the last one."""
        assert problem.wear is not None
        depth = np.array([max(record["row"][f"depth_max_{body}_um"] for body in BODIES) for record in records])
        wanted = np.linspace(0.0, depth[-1], problem.wear.snapshots + 1)
        chosen = sorted({int(np.argmin(np.abs(depth - d))) for d in wanted} | {0, len(records) - 1})
        states = [state_of(records[i]) for i in chosen]
        y, rows = states[-1].rows.y, states[-1].rows
        profiles = {body: np.array([surface.height(y) - state.on(rows).worn[body] for state in states])
                    for body, surface in zip(BODIES, surfaces(planar(problem)), strict=True)}
        loads, work = (np.array([np.interp(y, records[i]["load_y"], records[i][name], left=0.0, right=0.0) for i in chosen])
                       for name in ("load", "work"))
        return cls(y, np.array([state.distance for state in states]), profiles, loads, work)


def write_group(file: h5py.File, rows: Sequence[Record], kept: Snapshots) -> None:
    """The group /wear: scalars over the steps; profiles, line load and T_γ/A of the snapshots over y."""
    group = file.create_group("wear")
    steps = group.create_group("steps")
    for name, meaning in COLUMNS.items():
        steps.create_dataset(name, data=[row[name] for row in rows]).attrs["long_name"] = meaning
    for name in ESTIMATED:
        errors = [np.nan if row["error"][name] is None else row["error"][name] for row in rows]
        steps.create_dataset(f"error.{name}", data=errors).attrs["long_name"] = f"estimated error: {COLUMNS[name]}"
    for name, values, unit, meaning in (
        ("y", kept.y, "m", "lateral"), ("distance", kept.distances, "m", "distance rolled"),
        *((f"profile_{body}", kept.profiles[body], "m", f"height of the {body} body") for body in BODIES),
        ("line_load", kept.loads, "N/m", "pressure integrated along rolling"),
        ("T_gamma_per_area", kept.work, "Pa", "largest frictional work per area and distance rolled"),
    ):
        group.create_dataset(name, data=values).attrs.update({"units": unit, "long_name": meaning})


def worn_points(problem: Problem, state: WearState) -> dict[BodyName, list[list[float]]]:
    """[y, height] in mm over the whole profile of each worn body."""
    geometry = worn_geometry(planar(problem), state.rows, state.worn)
    return {body: [[float(f"{1e3 * y:.9g}"), float(f"{1e3 * height:.9g}")] for y, height in
                   getattr(geometry, f"{body}_profile").points] for body in BODIES if state.worn[body].any()}


def worn_case(case: Case, state: WearState) -> Case:
    """`case` with the worn profiles in place of its own."""
    content = json.loads(case.to_json())
    for body, points in worn_points(case.problem, state).items():
        content["geometry"].pop(f"{body}_radius_y_mm", None)
        content["geometry"][f"{body}_profile"] = {"points_mm": points}
    if state.result is not None and state.result.problem.approach is not None:
        content["load"]["approach_um"] = 1e6 * state.result.problem.approach
    return Case.from_json(json.dumps(content), name=case.name)


def write_profiles(folder: pathlib.Path, name: str, problem: Problem, state: WearState) -> list[pathlib.Path]:
    """The worn profiles as CSV files that a case reads again, where they lie: without offset and tilt. Raises OSError."""
    written = []
    for body, points in worn_points(problem, state).items():
        path = folder / f"{name}_worn_{body}.csv"
        lines = "".join(f"{y!r},{height!r}\n" for y, height in points)
        write_bytes(path, ("# y in mm, height in mm; offset and tilt of the case are in it\n" + lines).encode())
        written.append(path)
    return written
