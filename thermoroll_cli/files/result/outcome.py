"""Results as trees of labelled arrays: one layout in memory, in files, and for those who compare, export and draw.

The tree of a result has the attributes `status`, `reason`, … and the nodes

- `numbers`: value, uncertainty, unit and meaning of every scalar;
- `fields`: of the state, over x and y, or over x alone;
- `lower`, `upper`: stresses inside the bodies, over z, x and y;
- `residuals`: over the iterations;
- `isothermal`, of the same layout, if heat changes the contact; and the `patches` of an assembly under their names;
- `lines`: of an assembly, outlines; `surfaces`: what a contact over time rolls over; `input`: the case and the problem.
"""

from __future__ import annotations

import dataclasses
import functools
import json
import math
import os
import re
from collections.abc import Mapping
from typing import Any

import numpy as np
from pydantic import TypeAdapter

from thermoroll_cli.files.result.labelled import Labelled, Node, ResultFileError, axis, load, of_texts, save, storable
from thermoroll_cli.problem.kinds import contact_name
from thermoroll_cli.problem.names import (
    ALL_SCALARS,
    FIELDS,
    LINE_PROBLEM_SCALARS,
    PROBLEM_SCALARS,
    STRENGTH_FIELDS,
    SUBSURFACE_FIELDS,
    SUBSURFACE_SCALARS,
    Field,
    unit_of,
)
from thermoroll_cli.problem.problem import Problem
from thermoroll_cli.problem.result import BodyStresses, Peak, Result, State, Subsurface, SurfaceMap
from thermoroll_cli.tools.arrays import Array

KIND = "result"
BODY_PARTS = {
    "below_stressed_": ("below_stressed", "z", " below the largest von Mises stress"),
    "below_hottest_": ("below_heated", "z", " below the hottest point of the surface"),
    "plane_": ("plane", "zx", " on the plane y = plane_y"),
    "": ("fields", "zxy", ""),
}
"""How the names of arrays of a body begin → part of `BodyStresses`, axes, and words added to the meaning of a field."""
BODIES = ("lower", "upper")
PLAIN: dict[str, Any] = {"warnings": tuple[str, ...], "unbounded": tuple[str, ...], "work": dict[str, Any],
                         "record": dict[str, Any], "patches": tuple[dict[str, float], ...]}  # fmt: skip
"""Parts of a result that are attributes in JSON, with their types."""


def write_result(path: str | os.PathLike[str], result: Result, command_line: str = "Python") -> None:
    """Write the file of a `result` to `path`, complete or not at all. Raises WriteError."""
    save(path, tree_of(result), KIND, command_line)


def read_result(path: str | os.PathLike[str], *, with_fields: bool = True) -> Result:
    """The result in the file that `thermoroll run` or `Result.save` wrote.

    Parameters:

    - `path`: the HDF5 file;
    - `with_fields`: False leaves fields and residuals out, if only the scalars and the case matter.

    Raises ResultFileError (an OSError), with a plain message, for a file that is missing, unreadable, foreign, truncated,
    damaged or of another version."""
    return result_of(load(path, KIND, () if with_fields else ("fields", *BODIES, "residuals", "lines", "surfaces")), path)


def read_tree(path: str | os.PathLike[str]) -> Node:
    """The tree of the result in a file, which is whole. Raises ResultFileError."""
    tree = load(path, KIND)
    result_of(tree, path)
    return tree


def tree_of(result: Result) -> Node:
    """The tree of a `result`."""
    nodes = {"numbers": _numbers(result.numbers, result.uncertainty)} | _fields(result.coupled)
    nodes |= {body: _body(stresses, result.coupled) for body, stresses in result.bodies.items()}
    if result.isothermal is not result.coupled:
        cold = result.isothermal
        nodes["isothermal"] = Node(nodes={"numbers": _numbers(cold.scalars, {})} | _fields(cold))
    if result.residuals:
        # Each has a length of its own, so each has an axis of its own.
        arrays = dict[str, Labelled]()
        for name, values in result.residuals.items():
            arrays |= axis(f"{name}_iteration", np.arange(np.size(values))) | {
                name: Labelled((f"{name}_iteration",), np.asarray(values, dtype=float))}
        nodes["residuals"] = Node(arrays)
    if result.lines:
        arrays = axis("coordinate", np.array(["y", "z", "inclination"][: len(next(iter(result.lines.values())))]))
        for name, line in result.lines.items():
            arrays |= axis(f"{name}_point", np.arange(line.shape[1])) | {
                name: Labelled(("coordinate", f"{name}_point"), np.asarray(line))}
        nodes["lines"] = Node(arrays)
    if result.surfaces:
        nodes["surfaces"] = Node(nodes={name: _surface(each) for name, each in result.surfaces.items()})
    if result.assembly:
        nodes["patches"] = Node(nodes={patch.name: tree_of(patch.with_case("", "")) for patch in result.contacts})
    problem = dataclasses.asdict(result.problem.smooth) | {"title": storable(result.problem.title)}
    texts = {"case_text": result.case_text, "case_json": result.case_json, "problem_json": json.dumps(problem)}
    nodes["input"] = of_texts(texts)
    plain = {name: getattr(result, name) for name in PLAIN} | ({"patches": ()} if result.contacts else {})
    return Node({}, {"status": result.status, "reason": result.reason, "title": result.problem.title,
                     "assembly": result.assembly, **{name: json.dumps(value) for name, value in plain.items() if value}}, nodes)


def _numbers(values: Mapping[str, float], uncertainty: Mapping[str, float]) -> Node:
    columns: dict[str, list[Any]] = {
        "value": list(values.values()), "uncertainty": [uncertainty.get(name, math.nan) for name in values],
        "unit": list(map(unit_of, values)), "meaning": [ALL_SCALARS[name].meaning if name in ALL_SCALARS else ""
                                                        for name in values]}  # fmt: skip
    return Node(axis("scalar", np.array(list(values), dtype=str))
                | {name: Labelled(("scalar",), np.array(column)) for name, column in columns.items()})


def _fields(state: State) -> dict[str, Node]:
    if not state.fields:
        return {}
    return {"fields": Node(_plane(state) | {
        # The state is a label of three values; eight bytes for each would be a sixth of the file.
        name: _labelled(("x", "y")[: np.ndim(values)], np.asarray(values, dtype=np.int8 if name == "state" else np.float64),
                        FIELDS.get(name)) for name, values in state.fields.items()})}


def _plane(state: State) -> dict[str, Labelled]:
    return axis("x", state.x, "m", "along rolling, trailing edge at +x") | (
        axis("y", state.y, "m", "lateral") if len(state.y) else {})


def _labelled(axes: tuple[str, ...], values: Any, declared: Field | None, where: str = "") -> Labelled:
    return Labelled(axes, values, *(() if declared is None else (declared.unit, declared.meaning + where)))


def _body(stresses: BodyStresses, state: State) -> Node:
    arrays = _plane(state) | axis("z", np.asarray(stresses.depths, dtype=np.float64), "m", "depth, into the body")
    for prefix, (part, axes, where) in BODY_PARTS.items():
        arrays |= {prefix + name: _labelled(tuple(axes), values, SUBSURFACE_FIELDS[name], where)
                   for name, values in getattr(stresses, part).items()}
    arrays |= {name: _labelled(("z", "y")[: values.ndim], values, STRENGTH_FIELDS[name])
               for name, values in stresses.strength.items()}
    peaks = {"stressed": stresses.most_stressed} | ({} if stresses.hottest is None else {"hottest": stresses.hottest})
    return Node(arrays, {"plane_y": float(stresses.plane_y)} | {
        f"{kind}_{name}": float(value) for kind, peak in peaks.items() for name, value in peak._asdict().items()})


def _surface(found: SurfaceMap) -> Node:
    axes = ("along", "across")[: 2 if len(found.across) else 1]
    places = {name: 0.5 * (ends[1:] + ends[:-1]) for name, ends in (("along", found.along), ("across", found.across))}
    arrays = dict[str, Labelled]()
    for name in axes:
        arrays |= axis(name, places[name], "m", f"{name} the surface, middles of what heights are means of")
    heights = found.heights if len(axes) == 2 else found.heights[:, 0]
    return Node(arrays | {"height": Labelled(axes, heights, "m", "height over the smooth shape")}, {
        "path_begin": found.path[0], "path_end": found.path[1], "half_length": found.half[0], "half_width": found.half[1],
        "centre": found.centre})


# --- reading ---------------------------------------------------------------------------------------------------------


def result_of(tree: Node, source: str | os.PathLike[str] = "") -> Result:
    """The result of a tree, which was read from the file `source`. Raises ResultFileError where parts of it are missing."""
    try:
        case_text, case_json = (tree.nodes["input"].text(name) for name in ("case_text", "case_json"))
        result = _result(tree).with_case(case_text, case_json)
    except (KeyError, ValueError, TypeError, AttributeError, IndexError) as cause:
        detail = cause.args[0] if cause.args else type(cause).__name__
        raise ResultFileError(f"{source}: damaged result file ({detail})") from cause
    return dataclasses.replace(result, attributes=dict(tree.attributes))


def numbers_of(tree: Node) -> tuple[dict[str, float], dict[str, float]]:
    """Values of the scalars of a tree, and their uncertainties, by name."""
    table, names = tree.nodes["numbers"].arrays, tree.nodes["numbers"].texts("scalar")
    value, uncertainty = (dict(zip(names, map(float, table[column].values.tolist()), strict=True))
                          for column in ("value", "uncertainty"))
    return value, uncertainty


def _result(tree: Node) -> Result:
    numbers, uncertainty = numbers_of(tree)
    assembly = str(tree.attributes["assembly"])
    of_problem = {name: numbers.pop(name) for name in PROBLEM_SCALARS | LINE_PROBLEM_SCALARS
                  if name in numbers and not assembly}
    below = {name: numbers.pop(name) for name in SUBSURFACE_SCALARS if name in numbers and not assembly}
    coupled = isothermal = _state(tree, numbers)
    if "isothermal" in tree.nodes:
        isothermal = _state(tree.nodes["isothermal"], numbers_of(tree.nodes["isothermal"])[0])
    bodies = {body: _stresses(tree.nodes[body]) for body in BODIES if body in tree.nodes and tree.nodes[body].arrays}
    patched = tree.nodes.get("patches", Node()).nodes
    # HDF5 lists ball_10_inner before ball_2_inner.
    ordered = sorted(patched, key=lambda name: [int(part) if part.isdigit() else part for part in re.split(r"(\d+)", name)])
    contacts = {name: _result(patched[name]) for name in ordered}
    residuals, lines = (tree.nodes.get(name, Node()).arrays for name in ("residuals", "lines"))
    plain = {name: _reader(kind).validate_json(str(tree.attributes[name])) if name in tree.attributes else kind()
             for name, kind in PLAIN.items()}
    patches = plain.pop("patches")
    if (assembly and patches) or any(
            "uncertainty" not in each.record or not contact_name(each.record) for each in contacts.values()):
        raise ValueError("its patches are not those of an assembly")
    if bodies and "pressure" not in coupled.fields:
        raise ValueError("it has stresses without the pressure that causes them")
    return Result(
        problem=_reader(Problem).validate_json(tree.nodes["input"].text("problem_json")),
        coupled=coupled,
        isothermal=isothermal,
        of_problem=of_problem,
        converged={"converged": True, "not_converged": False}[str(tree.attributes["status"])],
        reason=str(tree.attributes["reason"]),
        uncertainty=uncertainty,
        residuals={name: array.values for name, array in residuals.items() if array.axes != (name,)},
        patches=tuple(dataclasses.replace(contact, name=name) for name, contact in contacts.items()) or patches,
        subsurface=Subsurface(bodies, below) if below else None,
        assembly=assembly,
        lines={name: array.values for name, array in lines.items() if array.axes != (name,)},
        surfaces={name: _map_of(node) for name, node in tree.nodes.get("surfaces", Node()).nodes.items()},
        **plain,
    )


@functools.cache
def _reader(kind: Any) -> TypeAdapter[Any]:
    """Reads JSON; made once, which takes a third of the time of reading a file."""
    return TypeAdapter(kind)


def _state(tree: Node, scalars: Mapping[str, float]) -> State:
    arrays = tree.nodes.get("fields", Node()).arrays
    x, y = (_coordinates(arrays[name]) if name in arrays else np.zeros(0) for name in "xy")
    fields = {name: _over(array, ("x", "y")[: array.values.ndim], name) for name, array in arrays.items() if name not in "xy"}
    return State(fields, scalars, x, y)


def _map_of(node: Node) -> SurfaceMap:
    axes = ("along", "across")[: node.arrays["height"].values.ndim]
    ends = []
    for name in axes:
        middles = _coordinates(node.arrays[name])
        step = middles[1] - middles[0]
        ends.append(np.append(middles - 0.5 * step, middles[-1] + 0.5 * step))
    heights = _over(node.arrays["height"], axes, "height")
    at = {name: float(value) for name, value in node.attributes.items()}
    return SurfaceMap(ends[0], ends[1] if len(axes) == 2 else np.zeros(0), heights if len(axes) == 2 else heights[:, None],
                      (at["path_begin"], at["path_end"]), (at["half_length"], at["half_width"]), at["centre"])


def _coordinates(array: Labelled) -> Array:
    values = np.asarray(array.values, dtype=np.float64)
    if not (np.isfinite(values).all() and (np.diff(values) > 0.0).all()):
        raise ValueError("its coordinates do not increase")
    return values


def _over(array: Labelled, axes: tuple[str, ...], name: str) -> Any:
    """The numbers of a field. Raises ValueError for a field over other axes, or of texts."""
    if array.axes != axes or array.values.dtype.kind not in "fiu":
        raise ValueError(f"{name} holds no numbers over {' and '.join(axes)}")
    return array.values


def _stresses(node: Node) -> BodyStresses:
    parts: dict[str, dict[str, Any]] = {part: {} for part, _, _ in BODY_PARTS.values()}
    strength: dict[str, Any] = {}
    for name, array in node.arrays.items():
        if name in STRENGTH_FIELDS:
            strength[name] = _over(array, ("z", "y")[: array.values.ndim], name)
        elif name not in "xyz":
            prefix = next(prefix for prefix in BODY_PARTS if name.startswith(prefix))
            part, axes, _ = BODY_PARTS[prefix]
            parts[part][name.removeprefix(prefix)] = _over(array, tuple(axes), name)
    at = {name: float(value) for name, value in node.attributes.items()}
    stressed, hottest = (Peak(**{name: at[f"{kind}_{name}"] for name in ("value", "x", "y", "z")})
                         if f"{kind}_value" in at else None for kind in ("stressed", "hottest"))
    assert stressed is not None
    return BodyStresses(_coordinates(node.arrays["z"]), at["plane_y"], most_stressed=stressed, hottest=hottest,
                        strength=strength, **parts)
