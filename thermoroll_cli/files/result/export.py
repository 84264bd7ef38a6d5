"""Results for other programs: XDMF and VTU for ParaView and VisIt, CSV for spreadsheets."""

from __future__ import annotations

import math
import os
import pathlib
from collections.abc import Iterator, Mapping
from typing import NamedTuple
from xml.etree import ElementTree

import numpy as np
from scipy.interpolate import BSpline, make_interp_spline

from thermoroll_cli.files.csv_table import write_rows
from thermoroll_cli.files.result.labelled import Labelled, Node, ResultFileError, axis, save
from thermoroll_cli.files.result.outcome import read_result
from thermoroll_cli.one_contact.refinement.subsurface_stage import body_load, stresses_by_depth
from thermoroll_cli.physics.numerics.grid import Grid
from thermoroll_cli.physics.stress.strength import von_mises
from thermoroll_cli.physics.stress.superposition import Beyond, StressTransforms
from thermoroll_cli.problem.names import COLUMN_UNITS, FIELDS, STRESSES, SUBSURFACE_FIELDS, Field
from thermoroll_cli.problem.result import BodyStresses, Result, State, within_layers
from thermoroll_cli.tools.arrays import AnyArray, Array
from thermoroll_cli.tools.atomic import replacing, write_bytes

Path = str | os.PathLike[str]
SIDES = {"lower": -1.0, "upper": 1.0}
"""Signs of the heights of layers in meshes."""


def export_xdmf(result_path: Path, out: Path) -> list[pathlib.Path]:
    """Write an XDMF file at `out` that shows the fields in the HDF5 file at `result_path`, without copying them: that file is
    referred to by a path relative to `out`, so move both together, and NAME_points.hdf5 with the places of the elements.

    The fields are stored (x, y), where y is the fastest index. XDMF's rectilinear meshes want x to be the fastest and would
    mirror them at the diagonal, so the mesh is a structured one with explicit points, the element centres.
    Tractions and slip are vectors, too, in the plane of the contact. A state without thermal deformation that has points of its
    own is a grid of its own, and so is each body with fields on all layers: the lower body at z < 0, its
    stresses in its own frame (z into the body). Contacts of an assembly are grids in axes of their own.

    Returns the files written. Raises ResultFileError if there is no result to point to, or one of a line contact, WriteError if
    `out` cannot be written.
    """
    result, out = _with_surface(result_path), pathlib.Path(out)
    hdf5 = os.path.relpath(os.path.realpath(result_path), os.path.dirname(os.path.realpath(out)))
    root, points = ElementTree.Element("Xdmf", Version="2.0"), _Points(out.with_name(f"{out.stem}_points.hdf5"), {})
    domain = ElementTree.SubElement(root, "Domain")
    for mesh in _meshes(result):
        grid = _add_grid(domain, mesh.title, mesh.shape, points.add(mesh.x, mesh.y, mesh.z))
        for field, (values, inside) in mesh.fields.items():
            _add_field(grid, field, values, f"{hdf5}:{inside}")
        for family, components in mesh.vectors():
            # Readers put components together; the third is 0.
            vector = ElementTree.SubElement(grid, "Attribute", Name=family, AttributeType="Vector", Center="Node")
            joined = ElementTree.SubElement(vector, "DataItem", ItemType="Function", Function="JOIN($0, $1, 0*$0)",
                                            Dimensions=" ".join(map(str, (*mesh.shape, 1, 3))), NumberType="Float",
                                            Precision="8")
            for _, inside in components:
                _data_item(joined, mesh.shape, np.dtype(np.float64), f"{hdf5}:{inside}")
    ElementTree.indent(root)
    save(points.path, Node(nodes=points.meshes), "points of a mesh")
    write_bytes(out, ElementTree.tostring(root, encoding="utf-8", xml_declaration=True) + b"\n")
    return [out, points.path]


class _Mesh(NamedTuple):
    """Element centres at `x`, `y`, `z` (m), and every field there, (nz, nx, ny) or on a surface (nx, ny), with its place in the
    HDF5 file; `title` for people, and `suffix` of a file of its own."""

    title: str
    suffix: str
    x: Array
    y: Array
    z: Array
    fields: dict[str, tuple[AnyArray, str]]

    @property
    def shape(self) -> tuple[int, ...]:
        return next(iter(self.fields.values()))[0].shape

    def vectors(self) -> Iterator[tuple[str, list[tuple[AnyArray, str]]]]:
        """Tractions and slip, of which both components are there."""
        for family in (f"{prefix}{name}" for prefix in ("", "isothermal_") for name in ("shear", "slip")):
            if f"{family}_x" in self.fields:
                yield family, [self.fields[f"{family}_{component}"] for component in "xy"]


def _meshes(result: Result) -> Iterator[_Mesh]:
    """The surface of every contact, with the state without thermal deformation on it or, if it has points of its own, on one of
    its own; then its bodies with fields on all layers."""
    for name, contact in result.by_suffix.items():
        inside, of = (f"/patches/{contact.name}", f"{contact.name}: ") if name else ("", "")
        surfaces: list[_Mesh] = []
        for group, prefix, state in _states(contact):
            if not prefix or contact.own_grids:
                title, own = ("contact without thermal deformation", "_isothermal") if prefix else ("contact", "")
                surfaces.append(_Mesh(of + title, name + own, state.x, state.y, np.zeros(1), {}))
            surfaces[-1].fields.update(
                {prefix + field: (values, f"{inside}{group}/{field}") for field, values in state.fields.items()})
        yield from surfaces
        for body, stresses in contact.bodies.items():
            if stresses.fields:
                yield _Mesh(f"{of}{body} body", f"{name}_{body}", contact.x, contact.y, SIDES[body] * stresses.depths,
                            {field: (values, f"{inside}/{body}/{field}") for field, values in stresses.fields.items()})


def export_vtu(result_path: Path, out: Path) -> list[pathlib.Path]:
    """Write the fields of a result to `out` and files beside it, as text of VTK's XML format for unstructured grids, which
    stand by themselves: NAME.vtu; NAME_isothermal.vtu where that state has points of its own; NAME_lower.vtu and NAME_upper.vtu
    of bodies with fields on all layers; NAME_left_1.vtu of the patches of an assembly.

    Points are the element centres in m, the lower body at z < 0; values are those of the result, in SI units, with 17 digits.
    Cells, quadrilaterals or hexahedra, lie between the points. Returns the files written. Raises ResultFileError where there is
    no surface, WriteError."""
    path, result = pathlib.Path(out), _with_surface(result_path)
    written = []
    for mesh in _meshes(result):
        target = path.with_name(f"{path.stem}{mesh.suffix}{path.suffix}")
        write_bytes(target, ElementTree.tostring(_unstructured(mesh), encoding="utf-8", xml_declaration=True) + b"\n")
        written.append(target)
    return written


def _unstructured(mesh: _Mesh) -> ElementTree.Element:
    depth, along, across = np.meshgrid(mesh.z, mesh.x, mesh.y, indexing="ij")
    number = np.arange(depth.size).reshape(depth.shape)
    corners: tuple[AnyArray, ...] = (number[:, :-1, :-1], number[:, 1:, :-1], number[:, 1:, 1:], number[:, :-1, 1:])
    if len(mesh.z) > 1:
        # An interface has two layers, of the values above and below it: no cell lies between them.
        thick = np.flatnonzero(np.diff(mesh.z))
        corners = (*(corner[thick] for corner in corners), *(corner[thick + 1] for corner in corners))
    cells = np.stack([corner.ravel() for corner in corners], axis=1)
    root = ElementTree.Element("VTKFile", type="UnstructuredGrid", version="0.1")
    piece = ElementTree.SubElement(ElementTree.SubElement(root, "UnstructuredGrid"), "Piece", NumberOfPoints=str(number.size),
                                   NumberOfCells=str(len(cells)))
    data = ElementTree.SubElement(piece, "PointData")
    for field, (values, _) in mesh.fields.items():
        _add_array(data, field, values.reshape(-1, 1))
    for family, components in mesh.vectors():
        x, y = (values.ravel() for values, _ in components)
        _add_array(data, family, np.stack((x, y, 0.0 * x), axis=1))
    places = np.stack([each.ravel() for each in (along, across, depth)], axis=1)
    _add_array(ElementTree.SubElement(piece, "Points"), "points", places)
    inside = ElementTree.SubElement(piece, "Cells")
    count = cells.shape[1]
    for name, values in (("connectivity", cells.reshape(-1, 1)), ("offsets", count * np.arange(1, len(cells) + 1)[:, None]),
                         ("types", np.full((len(cells), 1), 9 if count == 4 else 12, np.int8))):  # VTK_QUAD, VTK_HEXAHEDRON
        _add_array(inside, name, values)
    return root


def _add_array(parent: ElementTree.Element, name: str, values: AnyArray) -> None:
    """`values` (n, components)."""
    kind, form = {"i": (f"Int{8 * values.dtype.itemsize}", "%d")}.get(values.dtype.kind, ("Float64", "%.17g"))
    array = ElementTree.SubElement(parent, "DataArray", type=kind, Name=name, NumberOfComponents=str(values.shape[1]),
                                   format="ascii")  # fmt: skip
    array.text = "\n".join(" ".join(form % value for value in row) for row in values.tolist())


def _with_surface(result_path: Path) -> Result:
    """The result in a file, which must have a surface to show."""
    result = read_result(result_path)
    if not result.assembly and not len(result.y):
        raise ResultFileError(f"{result_path}: a line contact has no surface to show: --format csv has its curves")
    return result


class _Points(NamedTuple):
    """The meshes of a file of points, whose name does not end as those of results do: they are often meant together."""

    path: pathlib.Path
    meshes: dict[str, Node]

    def add(self, x: Array, y: Array, z: Array) -> str:
        """Put the points of a grid there, in single precision (nz, nx, ny, 3), or (nx, ny, 3) on one layer; return where."""
        depth, along, across = np.meshgrid(*(np.asarray(each, dtype=np.float32) for each in (z, x, y)), indexing="ij")
        values = np.stack([along, across, depth], axis=-1)
        values = values if len(z) > 1 else values[0]
        sides, name = (*"ijk"[: values.ndim - 1], "coordinate"), f"mesh_{len(self.meshes)}"
        indices = (axis(side, np.arange(length)) for side, length in zip(sides, values.shape, strict=True))
        self.meshes[name] = Node({key: array for each in indices for key, array in each.items()}
                                 | {"points": Labelled(sides, values, "m", "x, y, z of the element centres")})
        return f"{self.path.name}:/{name}/points"


def _add_grid(domain: ElementTree.Element, title: str, shape: tuple[int, ...], points: str) -> ElementTree.Element:
    grid = ElementTree.SubElement(domain, "Grid", Name=title, GridType="Uniform")
    # One layer in three dimensions: VTK reads vectors on a mesh of two dimensions as arrays of another length.
    layered = (*shape, 1)[:3]
    ElementTree.SubElement(grid, "Topology", TopologyType="3DSMesh", Dimensions=" ".join(map(str, layered)))
    _data_item(ElementTree.SubElement(grid, "Geometry", GeometryType="XYZ"), (*shape, 3), np.dtype(np.float32), points)
    return grid


def _add_field(grid: ElementTree.Element, name: str, values: AnyArray, where: str) -> None:
    attribute = ElementTree.SubElement(grid, "Attribute", Name=name, AttributeType="Scalar", Center="Node")
    _data_item(attribute, values.shape, values.dtype, where)


def _data_item(parent: ElementTree.Element, shape: tuple[int, ...], dtype: np.dtype, where: str) -> None:
    kind = "Char" if dtype == np.int8 else "Float"
    item = ElementTree.SubElement(parent, "DataItem", Dimensions=" ".join(map(str, shape)), NumberType=kind,
                                  Precision=str(dtype.itemsize), Format="HDF")  # fmt: skip
    item.text = where


def export_csv(result_path: Path, out: Path) -> list[pathlib.Path]:
    """Write one line per grid point to `out`, along y first: x_mm, y_mm (of a line contact x_mm alone) and every field, with
    the unit in the column's name and 10 significant digits; a value that was not computed is `nan`.

    An assembly becomes a table of its patches, with their errors in columns `uncertainty.NAME`, and such a file for each of
    them, NAME_left_1.csv.

    Columns of the isothermal state start with `isothermal_`; they are left out where both states are the same, and stand in a
    file of their own beside `out`, NAME_isothermal.csv, where that state has points of its own.

    Returns the files written. Raises ResultFileError, WriteError.
    """
    result, path = read_result(result_path), pathlib.Path(out)
    if result.assembly:
        rows = [patch | {f"uncertainty.{name}": error for name, error in patch["uncertainty"].items() if not math.isnan(error)}
                for patch in map(dict, result.records)]
        names = [name for name in dict.fromkeys(name for row in rows for name in row) if name != "uncertainty"]
        write_rows(path, names or [*result.kind.answer.contact_keys], ([row.get(name, "") for name in names] for row in rows))
    tables: dict[pathlib.Path, dict[str, AnyArray]] = {}
    for name, contact in result.by_suffix.items():
        for _, prefix, state in _states(contact):
            own = "_isothermal" if prefix and contact.own_grids else ""
            sides = {axis: places * 1e3 for axis, places in (("x_mm", state.x), ("y_mm", state.y)) if len(places)}
            columns = tables.setdefault(path.with_name(f"{path.stem}{name}{own}{path.suffix}"),
                                        dict(zip(sides, np.meshgrid(*sides.values(), indexing="ij"), strict=True)))
            columns |= dict(_column(FIELDS[field], values, prefix) for field, values in state.fields.items())
    for target, columns in tables.items():
        _write_csv(target, columns)
    return [*([path] if result.assembly else []), *tables]


def export_stress_path(result_path: Path, out: Path, y: float, z: float) -> list[pathlib.Path]:
    """Write the stresses that a material point meets to `out`: since the state is steady, a line of rolling at lateral position
    `y` and depth `z` (m), with a line per element along x, and of ever longer elements outside the domain until it is unloaded
    (`FAR`; the wake of heat may be longer).

    Columns: `x_mm`; `time_s`, from the first line at the rolling speed; the six stresses, the von Mises stress and the
    temperature rise of each body stored, with the unit in the column's name (`lower_stress_xx_MPa`, …). Stresses are in the
    body's own frame, z into the body; values between depths and rows are of cubic splines, at an interface those above it.

    Contacts of an assembly have a file each, NAME_left_1_stress_path.csv.

    Raises ResultFileError where the file holds no stresses there, ValueError for a line outside the domain, WriteError.
    """
    path = pathlib.Path(out)
    end = "_stress_path.csv" if path.name.endswith("_stress_path.csv") else path.suffix
    tables: dict[pathlib.Path, dict[str, AnyArray]] = {}
    for name, result in read_result(result_path).by_suffix.items():
        if not result.bodies:
            raise ResultFileError(f"{result_path}: no stresses below the surface in it; the case has no table [subsurface]")
        columns = tables[path.with_name(f"{path.name.removesuffix(end)}{name}{end}")] = {}
        for body, stresses in result.bodies.items():
            line = _line(result, stresses, y, z)
            if line is None:
                raise ResultFileError(f"{result_path}: stresses are kept on the plane y = {stresses.plane_y * 1e3:.4g} mm "
                                      'only; solve the case with fields = "full" in [subsurface]')
            # On the only plane that is kept its values stand for those of its row.
            place = y if STRESSES[0] in stresses.fields else stresses.plane_y
            x, outside = _outside(result, body, place, z, thermal="temperature_rise" in line)
            order = np.argsort(x)
            x, line = x[order], {name: np.append(values, outside[name])[order] for name, values in line.items()}
            columns |= {"x_mm": x * 1e3, "time_s": (x - x[0]) / result.problem.motion.speed}
            ordered = (SUBSURFACE_FIELDS[name] for name in dict.fromkeys((*STRESSES, *SUBSURFACE_FIELDS)) if name in line)
            columns |= dict(_column(field, line[field.name], f"{body}_") for field in ordered)
    for target, columns in tables.items():
        _write_csv(target, columns)
    return list(tables)


def _line(result: Result, stresses: BodyStresses, y: float, z: float) -> Mapping[str, AnyArray] | None:
    """Every field of a body along x, (nx,); None beside the only plane that is kept."""
    if not 0.0 <= z <= stresses.depths[-1] * (1.0 + 1e-9):
        raise ValueError(f"the depth {z * 1e3:g} mm is outside 0 to {stresses.depths[-1] * 1e3:.4g} mm")
    line = not len(result.y)
    half = math.inf if line else 0.5 * (result.y[1] - result.y[0])
    if not line and not result.y[0] - half <= y <= result.y[-1] + half:
        raise ValueError(f"y = {y * 1e3:g} mm is outside {result.y[0] * 1e3:.4g} to {result.y[-1] * 1e3:.4g} mm")
    fields, on_plane = (stresses.fields, False) if STRESSES[0] in stresses.fields else (stresses.plane, True)
    if on_plane and abs(y - stresses.plane_y) > half * (1.0 + 1e-9):
        return None
    part = next((part for part in within_layers(stresses.depths) if z <= stresses.depths[part][-1]), slice(0, None))
    at_depth = {name: _spline(stresses.depths[part], values[part])(z) for name, values in fields.items()}
    return at_depth if on_plane else {name: _spline(result.y, values.T)(y) for name, values in at_depth.items()}


FAR = (4, 16, 64)
"""Lengths of the domains on which a line goes on, over that of the domain: stresses fall to 1e-3 or less of the largest."""


def _outside(result: Result, body: str, y: float, z: float, *, thermal: bool) -> tuple[Array, dict[str, Array]]:
    """The x (m) inside and outside the domain, and every field of a body at those outside."""
    fields, problem, scalars = result.coupled.fields, result.problem, result.coupled.scalars
    flux, share = fields["heat_flux"], problem.heating.partition
    lower = share * flux if isinstance(share, float) and "heat_flux_lower" not in fields else fields["heat_flux_lower"]
    shape, heat = (len(result.x), max(len(result.y), 1)), lower if body == "lower" else flux - lower
    load = body_load(problem, body, fields["pressure"].reshape(shape),
                     np.stack([fields["shear_x"].reshape(shape), fields["shear_y"].reshape(shape)]),
                     heat.reshape(shape) if thermal else None,
                     (scalars["creepage_longitudinal"], scalars["creepage_lateral"]))
    (nx, dx, middle), (ny, dy, centre) = (
        (len(axis), float(np.ptp(axis)) / (len(axis) - 1), 0.5 * float(axis[0] + axis[-1])) if len(axis) else (1, math.inf, 0.0)
        for axis in (result.x, result.y))
    places, stresses, rises, inside = [result.x], [], [], 1.0
    for times in FAR:
        part = Beyond.of(Grid(nx, ny, dx, dy, centre, middle), load, times, inside)
        here, depth = {body: (StressTransforms(part.grid, False), part.load)}, {body: np.array([z])}
        (_, _, elastic, heated), = stresses_by_depth(here, depth)
        both = np.concatenate([elastic, np.zeros((7, *elastic.shape[1:])) if heated is None else [*heated[0], heated[1]]])
        rows = np.moveaxis(both[:, part.outside], 2, 0)
        at = _spline(result.y, rows)(y) if len(result.y) else rows[0]
        places.append(part.grid.x[part.outside])
        stresses.append(np.stack([at[:6], at[:6] + at[6:12]]))
        rises.append(at[12])
        inside = part.grid.nx * part.grid.dx / (nx * dx)
    elastic, total = np.concatenate(stresses, axis=2)
    values = dict(zip(STRESSES, total, strict=True)) | {
        "von_mises": von_mises(total), "von_mises_elastic": von_mises(elastic), "temperature_rise": np.concatenate(rises)}
    return np.concatenate(places), values


def _spline(axis: Array, values: AnyArray) -> BSpline:
    """The spline through `values` (n, …) on `axis` (n,), cubic where there are points enough."""
    return make_interp_spline(axis, values.astype(np.float64), k=min(3, len(axis) - 1))


def _column(field: Field, values: AnyArray, prefix: str) -> tuple[str, AnyArray]:
    """Name with unit, and values in that unit."""
    unit, factor = COLUMN_UNITS.get(field.unit, ("", 1.0))
    return f"{prefix}{field.name}_{unit}".removesuffix("_"), values * factor


def _write_csv(out: pathlib.Path, columns: Mapping[str, AnyArray]) -> None:
    table = np.stack([column.ravel() for column in columns.values()], axis=1)
    with replacing(out) as temporary:
        np.savetxt(temporary, table, fmt="%.10g", delimiter=",", header=",".join(columns), comments="")


def _states(result: Result) -> list[tuple[str, str, State]]:
    """HDF5 group, prefix of the names and fields of each state; only one where nothing feeds back."""
    states = [("/fields", "", result.coupled)]
    return states + ([("/isothermal/fields", "isothermal_", result.isothermal)]
                     if result.isothermal is not result.coupled else [])
