"""Files of an evolution: a journal of its steps, a table, a result file with the group /wear, and the worn profiles."""

from __future__ import annotations

import csv
import io
import math
import pathlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import h5py
import numpy as np

from thermoroll_cli.arrays import Array
from thermoroll_cli.atomic import write_bytes
from thermoroll_cli.problem.problem import BODIES, Problem
from thermoroll_cli.problem.surface import surfaces
from thermoroll_cli.wear.evolution import STRETCH, WearState, half_width, line_load

COLUMNS = {
    "distance_km": "distance rolled", "depth_max_lower_um": "largest worn depth, lower body",
    "depth_max_upper_um": "largest worn depth, upper body", "worn_area_lower_mm2": "worn cross-section, lower body",
    "worn_area_upper_mm2": "worn cross-section, upper body", "half_width_mm": "half-width of the contact",
    "line_load_max_N_mm": "largest line load", "pressure_max_MPa": "maximum pressure", "T_gamma_N": "wear number Tγ",
    "approach_um": "rigid-body approach",
}  # fmt: skip
"""Columns of the table, with their meanings."""

Record = Mapping[str, Any]


def record_of(state: WearState) -> dict[str, Any]:
    """A solved state as a line of the journal: its row of the table, the worn depths (m) and the line load (N/m) over y (m)."""
    result = state.result
    assert result is not None
    scalars = result.coupled.scalars
    row = {
        "distance_km": state.distance * 1e-3,
        **{f"depth_max_{body}_um": float(state.worn[body].max()) * 1e6 for body in BODIES},
        **{f"worn_area_{body}_mm2": state.worn_area(body) * 1e6 for body in BODIES},
        "half_width_mm": half_width(result) * 1e3,
        "line_load_max_N_mm": float(line_load(result).max()) * 1e-3,
        **{name: scalars[name] for name in ("pressure_max_MPa", "T_gamma_N", "approach_um")},
    }
    return {
        "key": str(state.steps), "distance": state.distance, "y": state.y.tolist(), "row": row,
        "worn": {body: state.worn[body].tolist() for body in BODIES},
        "load_y": result.y.tolist(), "load": line_load(result).tolist(), "converged": result.converged,
    }  # fmt: skip


def resumed(journal: Mapping[str, Record]) -> WearState | None:
    """The last state of a journal from which an evolution goes on as if undisturbed: at the end of a stretch of steps."""
    steps = max((int(key) for key in journal if int(key) % STRETCH == 0), default=0)
    if not steps:
        return None
    record = journal[str(steps)]
    return WearState(steps, record["distance"], np.array(record["y"]),
                     {body: np.array(record["worn"][body]) for body in BODIES})


def table(records: Sequence[Record]) -> bytes:
    """The rows as CSV."""
    text = io.StringIO()
    writer = csv.DictWriter(text, list(COLUMNS), lineterminator="\n")
    writer.writeheader()
    writer.writerows({name: f"{record['row'][name]:.7g}" for name in COLUMNS} for record in records)
    return text.getvalue().encode()


def heights(problem: Problem, y: Array, worn: Mapping[str, Sequence[float]]) -> dict[str, Array]:
    """Heights (m) of both bodies' surfaces at `y` (m) less the `worn` depths."""
    return {body: surface.height(y) - np.array(worn[body])
            for body, surface in zip(BODIES, surfaces(problem.geometry), strict=True)}


@dataclass(frozen=True)
class Snapshots:
    """Profiles (m, by body) and `loads` (N/m), each (snapshots, points), at `y` (m) after `distances` (m)."""

    y: Array
    distances: Array
    profiles: dict[str, Array]
    loads: Array

    @classmethod
    def of(cls, problem: Problem, records: Sequence[Record]) -> Snapshots:
        """As many of the records as are asked for, evenly over the largest worn depth, with the first and the last one."""
        assert problem.wear is not None
        depth = np.array([max(record["row"][f"depth_max_{body}_um"] for body in BODIES) for record in records])
        wanted = np.linspace(0.0, depth[-1], problem.wear.snapshots + 1)
        chosen = sorted({int(np.argmin(np.abs(depth - d))) for d in wanted} | {0, len(records) - 1})
        kept, y = [records[i] for i in chosen], np.array(records[0]["y"])
        shapes = [heights(problem, y, record["worn"]) for record in kept]
        return cls(y, np.array([record["distance"] for record in kept]),
                   {body: np.array([shape[body] for shape in shapes]) for body in BODIES},
                   np.array([np.interp(y, record["load_y"], record["load"], left=0.0, right=0.0) for record in kept]))


def write_group(file: h5py.File, problem: Problem, records: Sequence[Record]) -> None:
    """The group /wear: scalars over the steps; profiles and line load of the snapshots over y."""
    group = file.create_group("wear")
    steps = group.create_group("steps")
    for name, meaning in COLUMNS.items():
        steps.create_dataset(name, data=[record["row"][name] for record in records]).attrs["long_name"] = meaning
    kept = Snapshots.of(problem, records)
    for name, values, unit, meaning in (
        ("y", kept.y, "m", "lateral"), ("distance", kept.distances, "m", "distance rolled"),
        *((f"profile_{body}", kept.profiles[body], "m", f"height of the {body} body") for body in BODIES),
        ("line_load", kept.loads, "N/m", "pressure integrated along rolling"),
    ):
        group.create_dataset(name, data=values).attrs.update({"units": unit, "long_name": meaning})


def write_profiles(folder: pathlib.Path, name: str, problem: Problem, last: Record) -> list[pathlib.Path]:
    """The worn profiles as CSV files that a case reads again, of the bodies that wear. Raises OSError."""
    assert problem.wear is not None
    y = np.array(last["y"])
    written = []
    for body, shape in heights(problem, y, last["worn"]).items():
        if getattr(problem.wear, body).rate > 0.0 and all(map(math.isfinite, shape)):
            path = folder / f"{name}_worn_{body}.csv"
            lines = "".join(f"{1e3 * place:.9g},{1e3 * height:.9g}\n" for place, height in zip(y, shape, strict=True))
            write_bytes(path, ("# y in mm, height in mm\n" + lines).encode())
            written.append(path)
    return written
