"""Results for other programs: XDMF for ParaView and VisIt, CSV for spreadsheets."""

from __future__ import annotations

import io
import os
import pathlib
from collections.abc import Mapping, Sequence
from typing import Any
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from thermoroll_cli.files.atomic import write_bytes
from thermoroll_cli.files.result.hdf5 import read_result
from thermoroll_cli.problem.names import COLUMN_UNITS, FIELDS
from thermoroll_cli.problem.result import Result
from thermoroll_cli.problem.subsurface import BodyStresses

Fields = Mapping[str, NDArray[Any]]
"""Fields of a state by name."""


def export_xdmf(result_path: str | os.PathLike[str], out: str | os.PathLike[str]) -> list[pathlib.Path]:
    """Write an XDMF file at `out` that shows the fields inside the HDF5 file at `result_path`, without copying them.

    XDMF names a mesh's dimensions slowest first, and its rectilinear meshes are bound to x being the fastest index.
    The fields are stored (x, y), where y is the fastest, so a rectilinear mesh would show them mirrored at the
    diagonal. A structured mesh with explicit points has no such binding: it takes the points of `/mesh` in the order of
    the fields. The values belong to these points, the element centres. A state without thermal deformation that has points of
    its own (`/mesh_isothermal`) is a grid of its own. Bodies that were looked into, with fields on all
    layers, are grids of their own: the lower body at z < 0, its stresses in its own frame (z into the body).

    The HDF5 file is referred to by a path relative to `out`: move both together.

    Returns the files written. Raises ResultFileError if there is no result to point to, WriteError if `out` cannot be written.
    """
    result = read_result(result_path)
    hdf5 = os.path.relpath(os.path.realpath(result_path), os.path.dirname(os.path.realpath(out)))
    root = ElementTree.Element("Xdmf", Version="2.0")
    domain = ElementTree.SubElement(root, "Domain")
    parts = [("contact", "/mesh", _states(result))]
    if result.own_grids:
        parts = [(name, mesh, [state]) for (name, mesh), state in zip(
            (("contact", "/mesh"), ("contact without thermal deformation", "/mesh_isothermal")), _states(result), strict=True)]
    for title, mesh, states in parts:
        grid = ElementTree.SubElement(domain, "Grid", Name=title, GridType="Uniform")
        shape = " ".join(map(str, next(iter(states[0][2].values())).shape))
        ElementTree.SubElement(grid, "Topology", TopologyType="2DSMesh", Dimensions=shape)
        geometry = ElementTree.SubElement(grid, "Geometry", GeometryType="XYZ")
        _data_item(geometry, f"{shape} 3", "Float", 4, f"{hdf5}:{mesh}/points")
        for prefix, group, fields in states:
            for name, values in fields.items():
                attribute = ElementTree.SubElement(grid, "Attribute", Name=prefix + name, AttributeType="Scalar", Center="Node")
                kind = "Char" if values.dtype == np.int8 else "Float"
                _data_item(attribute, shape, kind, values.dtype.itemsize, f"{hdf5}:{group}/{name}")
    for body, stresses in result.bodies.items():
        _add_body(domain, body, stresses, hdf5)
    ElementTree.indent(root)
    write_bytes(out, ElementTree.tostring(root, encoding="utf-8", xml_declaration=True) + b"\n")
    return [pathlib.Path(out)]


def export_csv(result_path: str | os.PathLike[str], out: str | os.PathLike[str]) -> list[pathlib.Path]:
    """Write one line per grid point to `out`: x_mm, y_mm and every field, with the unit in the column's name.

    Columns of the isothermal state start with `isothermal_`; they are left out where both states are the same, and stand in a
    file of their own beside `out`, NAME_isothermal.csv, where that state has points of its own. Numbers have 10
    significant digits; a value that was not computed is `nan`. Lines run along y first.

    Returns the files written. Raises ResultFileError, WriteError.
    """
    result, path = read_result(result_path), pathlib.Path(out)
    states = _states(result)
    if not result.own_grids:
        _write_csv(path, result.x, result.y, states)
        return [path]
    beside = path.with_name(f"{path.stem}_isothermal{path.suffix}")
    _write_csv(path, result.x, result.y, states[:1])
    _write_csv(beside, result.isothermal.x, result.isothermal.y, states[1:])
    return [path, beside]


def _write_csv(
    out: pathlib.Path, x: NDArray[np.float64], y: NDArray[np.float64], states: Sequence[tuple[str, str, Fields]]
) -> None:
    """The fields of `states`, which share the points of `x` and `y` (m)."""
    along, across = np.meshgrid(x * 1e3, y * 1e3, indexing="ij")
    columns: dict[str, NDArray[Any]] = {"x_mm": along, "y_mm": across}
    for prefix, _, fields in states:
        for name, values in fields.items():
            unit, factor = COLUMN_UNITS.get(FIELDS[name].unit, ("", 1.0))
            columns[f"{prefix}{name}_{unit}" if unit else prefix + name] = values * factor
    table = np.stack([column.ravel() for column in columns.values()], axis=1)
    text = io.StringIO()
    text.write(",".join(columns) + "\n")
    line = ",".join(["%.10g"] * len(columns)) + "\n"
    # One long format string a block: four times as fast as numpy.savetxt, and blocks bound the memory.
    for block in np.array_split(table, max(1, len(table) // 4096)):
        text.write(line * len(block) % tuple(block.ravel().tolist()))
    write_bytes(out, text.getvalue().encode())


def _add_body(domain: ElementTree.Element, body: str, stresses: BodyStresses, hdf5: str) -> None:
    """A grid for the fields of one body, if any are kept on all layers."""
    if not stresses.fields:
        return
    shape = " ".join(str(side) for side in next(iter(stresses.fields.values())).shape)
    grid = ElementTree.SubElement(domain, "Grid", Name=f"{body} body", GridType="Uniform")
    ElementTree.SubElement(grid, "Topology", TopologyType="3DSMesh", Dimensions=shape)
    geometry = ElementTree.SubElement(grid, "Geometry", GeometryType="XYZ")
    _data_item(geometry, f"{shape} 3", "Float", 4, f"{hdf5}:/mesh/subsurface_{body}")
    for name, values in stresses.fields.items():
        attribute = ElementTree.SubElement(grid, "Attribute", Name=name, AttributeType="Scalar", Center="Node")
        _data_item(attribute, shape, "Float", values.dtype.itemsize, f"{hdf5}:/subsurface/{body}/{name}")


def _states(result: Result) -> list[tuple[str, str, Fields]]:
    """Prefix of the names, HDF5 group and fields of each state; only one where nothing feeds back."""
    states: list[tuple[str, str, Fields]] = [("", "/fields", result.coupled.fields)]
    if result.isothermal is not result.coupled:
        states.append(("isothermal_", "/isothermal", result.isothermal.fields))
    return states


def _data_item(parent: ElementTree.Element, shape: str, kind: str, precision: int, where: str) -> None:
    item = ElementTree.SubElement(parent, "DataItem", Dimensions=shape, NumberType=kind, Precision=str(precision), Format="HDF")
    item.text = where
