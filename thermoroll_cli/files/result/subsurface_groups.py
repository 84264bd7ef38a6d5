"""What a result file holds of the stresses inside the bodies.

    /subsurface/lower, /subsurface/upper     scales z, x, y (m; z into the body) and, in single precision and SI units,
        <field>                              (z, x, y), where they are kept; one chunk a layer
        plane_<field>                        (z, x) on the plane y = `plane_y`
        below_stressed_<field>               (z,) below the point of the largest von Mises stress
        below_hottest_<field>                (z,) below the hottest point of the surface
        attributes                           plane_y, stressed_x, _y, _z, _value, hottest_x, _y, _value (SI)
    /mesh/subsurface_lower, …                point coordinates for XDMF, lower body at z < 0
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from thermoroll_cli.files.result.hdf5_text import label
from thermoroll_cli.problem.names import SUBSURFACE_FIELDS
from thermoroll_cli.problem.subsurface import BodyStresses, Peak, Subsurface

PLANE, STRESSED, HOTTEST = "plane_", "below_stressed_", "below_hottest_"
_WHERE = {
    "": "",
    PLANE: " on the plane y = plane_y",
    STRESSED: " below the largest von Mises stress",
    HOTTEST: " below the hottest point of the surface",
}
SIDES = {"lower": -1.0, "upper": 1.0}
"""Where the bodies are for ParaView."""


def write_subsurface(file: h5py.File, subsurface: Subsurface, x: NDArray[Any], y: NDArray[Any]) -> None:
    """Write all bodies into the open `file`, which has /mesh already."""
    top = file.create_group("subsurface")
    for body, stresses in subsurface.bodies.items():
        group = top.create_group(body)
        scales = {
            "z": _scale(group, "z", stresses.depths, "depth, into the body"),
            "x": _scale(group, "x", x, "along rolling, trailing edge at +x"),
            "y": _scale(group, "y", y, "lateral"),
        }
        parts: tuple[tuple[str, str, Mapping[str, NDArray[Any]]], ...] = (
            ("", "zxy", stresses.fields), (PLANE, "zx", stresses.plane),
            (STRESSED, "z", stresses.below_stressed), (HOTTEST, "z", stresses.below_heated),
        )
        for prefix, axes, fields in parts:
            for name, values in fields.items():
                field = SUBSURFACE_FIELDS[name]
                chunks = (1, *values.shape[1:]) if values.ndim > 1 else values.shape
                dataset = group.create_dataset(prefix + name, data=values, chunks=chunks, fletcher32=True, track_times=False)
                for dimension, axis in zip(dataset.dims, axes, strict=True):
                    dimension.attach_scale(scales[axis])
                label(dataset, units=field.unit, long_name=field.meaning + _WHERE[prefix])
        _write_places(group, stresses)
        if stresses.fields:
            _write_mesh(file["mesh"], body, x, y, stresses.depths)


def read_subsurface(file: h5py.File) -> dict[str, BodyStresses]:
    """The bodies of an open result file that has some."""
    return {body: _read_body(group) for body, group in file["subsurface"].items()}


def _read_body(group: h5py.Group) -> BodyStresses:
    parts: dict[str, dict[str, NDArray[Any]]] = {prefix: {} for prefix in _WHERE}
    for name, dataset in group.items():
        if name not in ("x", "y", "z"):
            prefix = next((p for p in (PLANE, STRESSED, HOTTEST) if name.startswith(p)), "")
            parts[prefix][name.removeprefix(prefix)] = dataset[()]
    at = {name: float(value) for name, value in group.attrs.items()}
    hottest = Peak(at["hottest_value"], at["hottest_x"], at["hottest_y"], 0.0) if "hottest_value" in at else None
    stressed = Peak(at["stressed_value"], at["stressed_x"], at["stressed_y"], at["stressed_z"])
    return BodyStresses(group["z"][()], at["plane_y"], parts[PLANE], stressed, hottest, parts[STRESSED], parts[HOTTEST],
                        parts[""])


def _write_places(group: h5py.Group, stresses: BodyStresses) -> None:
    group.attrs["plane_y"] = stresses.plane_y
    stressed, hottest = stresses.most_stressed, stresses.hottest
    for name, value in (("x", stressed.x), ("y", stressed.y), ("z", stressed.z), ("value", stressed.value)):
        group.attrs[f"stressed_{name}"] = value
    if hottest is not None:
        for name, value in (("x", hottest.x), ("y", hottest.y), ("value", hottest.value)):
            group.attrs[f"hottest_{name}"] = value


def _write_mesh(mesh: h5py.Group, body: str, x: NDArray[Any], y: NDArray[Any], depths: NDArray[Any]) -> None:
    """Coordinates of every point, (nz, nx, ny, 3), compressed: see `hdf5._write_mesh`."""
    single = [np.asarray(axis, dtype=np.float32) for axis in (SIDES[body] * depths, x, y)]
    above, along, across = np.meshgrid(*single, indexing="ij")
    points = np.stack([along, across, above], axis=-1)
    dataset = mesh.create_dataset(f"subsurface_{body}", data=points, chunks=(1, *points.shape[1:]), fletcher32=True,
                                  compression="gzip", compression_opts=1, track_times=False)
    label(dataset, units="m", long_name="x, y, z of the element centres on every layer")


def _scale(group: h5py.Group, name: str, values: NDArray[Any], long_name: str) -> h5py.Dataset:
    values = np.asarray(values, dtype=np.float64)
    scale = group.create_dataset(name, data=values, chunks=values.shape, fletcher32=True, track_times=False)
    scale.make_scale(name)
    label(scale, units="m", long_name=long_name)
    return scale
