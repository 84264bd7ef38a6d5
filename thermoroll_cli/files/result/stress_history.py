"""The stress history of a material point as CSV: since the state is steady, it is a line of rolling below the surface."""

from __future__ import annotations

import io
import os
from collections.abc import Mapping

import numpy as np

from thermoroll_cli.arrays import AnyArray
from thermoroll_cli.files.atomic import write_bytes
from thermoroll_cli.files.result.hdf5 import ResultFileError, read_result
from thermoroll_cli.problem.names import COLUMN_UNITS, STRESSES, SUBSURFACE_FIELDS
from thermoroll_cli.problem.result import Result
from thermoroll_cli.problem.subsurface import BodyStresses

NEIGHBOURS = 4
"""Points of the polynomials between layers and between rows."""


class OutsideError(ValueError):
    """The line asked for lies outside what was computed."""


def export_history(result_path: str | os.PathLike[str], out: str | os.PathLike[str], y: float, z: float) -> None:
    """Write a line per element along x at lateral position `y` and depth `z` (m) to `out`.

    Columns: `x_mm`; `time_s`, from entering the domain at the rolling speed; of each body stored the six stresses, the von
    Mises stress and the temperature rise, with the unit in the column's name (`lower_stress_xx_MPa`, …). Stresses are those
    of the body's own frame, z into the body; values between layers and rows are cubic interpolations.

    Raises ResultFileError where the file holds no stresses there, OutsideError for a line outside the domain, WriteError.
    """
    result = read_result(result_path)
    if not result.bodies:
        raise ResultFileError(f"{result_path}: no stresses below the surface in it; the case has no table [subsurface]")
    speed = result.problem.motion.speed
    columns: dict[str, AnyArray] = {"x_mm": result.x * 1e3, "time_s": (result.x - result.x[0]) / speed}
    for body, stresses in result.bodies.items():
        line = _line(result_path, result, stresses, y, z)
        for name in (*STRESSES, *SUBSURFACE_FIELDS):
            if name in line:
                unit, factor = COLUMN_UNITS[SUBSURFACE_FIELDS[name].unit]
                columns[f"{body}_{name}_{unit}"] = line[name] * factor
    text = io.StringIO()
    text.write(",".join(columns) + "\n")
    np.savetxt(text, np.stack(list(columns.values()), axis=1), fmt="%.9g", delimiter=",")
    write_bytes(out, text.getvalue().encode())


def _line(path: str | os.PathLike[str], result: Result, stresses: BodyStresses, y: float, z: float) -> Mapping[str, AnyArray]:
    """Every field along x, (nx,)."""
    if not 0.0 <= z <= stresses.depths[-1] * (1.0 + 1e-9):
        raise OutsideError(f"the depth {z * 1e3:g} mm is outside 0 to {stresses.depths[-1] * 1e3:.4g} mm")
    half = 0.5 * (result.y[1] - result.y[0])
    if not result.y[0] - half <= y <= result.y[-1] + half:
        raise OutsideError(f"y = {y * 1e3:g} mm is outside {result.y[0] * 1e3:.4g} to {result.y[-1] * 1e3:.4g} mm")
    if STRESSES[0] in stresses.fields:
        return {name: _between(result.y, y, np.moveaxis(_between(stresses.depths, z, values), 1, 0))
                for name, values in stresses.fields.items()}
    if abs(y - stresses.plane_y) > half * (1.0 + 1e-9):
        raise ResultFileError(f"{path}: stresses are kept on the plane y = {stresses.plane_y * 1e3:.4g} mm only; solve "
                              'the case with fields = "full" in [subsurface]')
    return {name: _between(stresses.depths, z, values) for name, values in stresses.plane.items()}


def _between(axis: AnyArray, at: float, values: AnyArray) -> AnyArray:
    """Values (…) of `values` (n, …) on `axis` (n,) at one place, by Lagrange's polynomial through the nearest points."""
    count = min(NEIGHBOURS, len(axis))
    first = int(np.clip(np.searchsorted(axis, at) - count // 2, 0, len(axis) - count))
    nodes = axis[first : first + count]
    weights = [np.prod([(at - other) / (node - other) for other in nodes if other != node]) for node in nodes]
    return np.asarray(np.tensordot(weights, values[first : first + count].astype(np.float64), axes=1))
