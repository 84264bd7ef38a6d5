"""Tables as HDF5 files that open in xarray, and as CSV."""

from __future__ import annotations

import csv
import math
import os
from typing import Any

import h5py
import numpy as np

from thermoroll_cli.creep_table.point_solver import QUANTITIES
from thermoroll_cli.creep_table.scaling import LAW, directions, magnitude, plane_angle, scales, slopes, spin_angle
from thermoroll_cli.creep_table.values import Axes, Quality, TableValues
from thermoroll_cli.files.atomic import replacing
from thermoroll_cli.files.result.hdf5 import LAYOUT, ResultFileError, create, dimension_scale, label, opened, stamp

FORMAT_VERSION = 1
KIND = "creep_force_table"
RESOLUTION = 2.0**-15
"""Resolution of stored forces over μW: a twentieth of the errors of a table."""
DIMENSIONS = ("aspect_ratio", "magnitude", "direction", "spin_direction")
LONG_NAMES = {
    "force_x": "F_x/(μW)",
    "force_y": "F_y/(μW)",
    "spin_moment": "M_z/(μW sqrt(ab))",
    "stick_fraction": "stick area / contact area",
    "solver_error": "estimated error of the forces over μW",
}


def write_table(path: str | os.PathLike[str], table: TableValues, *, command_line: str) -> None:
    """Write `table` to `path`, complete or not at all. Raises WriteError."""

    with replacing(path) as temporary, h5py.File(temporary, "w", libver=LAYOUT) as file:
        stamp(file, FORMAT_VERSION, kind=KIND, scaling=LAW, command_line=command_line)
        file.attrs["poisson_ratio"] = table.poisson_ratio
        file.attrs["accuracy"] = table.accuracy
        file.attrs["holes"] = table.holes
        for name, value in vars(table.quality).items():
            file.attrs[f"quality_{name}"] = value
        axes = table.axes
        nodes = (np.array(axes.aspect_ratios), axes.u, axes.v, axes.w)
        long_names = ("a/b, a along rolling", "u of the magnitude m", "v of the angle alpha", "w of the spin angle beta")
        scales = [dimension_scale(file, name, values, units="1", long_name=long_name)
                  for name, values, long_name in zip(DIMENSIONS, nodes, long_names, strict=True)]
        columns = dict(zip(QUANTITIES, np.moveaxis(table.values, 1, 0), strict=True)) | {"solver_error": table.errors}
        for name, values in columns.items():
            # Zeros behind the digits that matter: half the size when compressed. Towards zero, so that forces keep the bound.
            stored = (np.trunc(values / RESOLUTION) * RESOLUTION).astype(np.float32)
            item = create(file, name, stored, scales, chunks=(1, *values.shape[1:]), compression="gzip", shuffle=True)
            label(item, units="1", long_name=LONG_NAMES[name])


def read_table(path: str | os.PathLike[str]) -> TableValues:
    """The table at `path`. Raises ResultFileError: missing, foreign, cut short, damaged, of another version, or with axes that
    do not increase."""

    with opened(path, KIND, FORMAT_VERSION) as file:
        return _read(path, file)


def _read(path: str | os.PathLike[str], file: h5py.File) -> TableValues:
    if (scaling := file.attrs["scaling"].decode()) != LAW:
        raise ResultFileError(f"{path}: table of scaling {scaling}; this version reads {LAW}: build it again with thermoroll "
                              "table")
    ratios, u, v, w = (file[name][()] for name in DIMENSIONS)
    axes = Axes(tuple(ratios.tolist()), len(u), len(v), len(w))
    for name, found, own in zip(DIMENSIONS[1:], (u, v, w), (axes.u, axes.v, axes.w), strict=True):
        if not np.allclose(found, own, atol=1e-12):
            raise ValueError(f"the axis {name} does not increase evenly")
    values = np.stack([file[name][()].astype(float) for name in QUANTITIES], axis=1)
    errors = file["solver_error"][()].astype(float)
    if values.shape != (len(ratios), len(QUANTITIES), *axes.shape):
        raise ValueError("values and axes have different lengths")
    quality = {name: file.attrs[f"quality_{name}"] for name in vars(Quality())}
    quality = {name: int(value) if name == "points" else float(value) for name, value in quality.items()}
    poisson_ratio, accuracy = (float(file.attrs[name]) for name in ("poisson_ratio", "accuracy"))
    return TableValues(axes, poisson_ratio, accuracy, values, errors, Quality(**quality))


def write_csv(path: str | os.PathLike[str], table: TableValues) -> None:
    """A line per point, with its scaled creepages; holes are empty. Raises WriteError."""

    axes = table.axes
    with replacing(path) as temporary, open(temporary, "w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(["aspect_ratio", "xi", "eta", "phi", "magnitude", "alpha_deg", "beta_deg", *QUANTITIES])
        for values, ratio in zip(table.values, axes.aspect_ratios, strict=True):
            per = np.array(scales(slopes(ratio, table.poisson_ratio)))
            for i, j, k in np.ndindex(*axes.shape):
                full = i == axes.magnitudes - 1
                m = math.inf if full else float(magnitude(axes.u[i]))
                unit = directions(axes.v[j], axes.w[k])
                with np.errstate(invalid="ignore"):
                    creepages = np.where(unit == 0.0, 0.0, unit * m) / per
                angles = (math.degrees(float(angle)) for angle in (plane_angle(axes.v[j]), spin_angle(axes.w[k])))
                writer.writerow([_cell(x) for x in (ratio, *creepages, m, *angles, *values[:, i, j, k])])


def _cell(value: Any) -> str:
    return "" if math.isnan(value) else f"{float(value):.7g}"

