"""Differences between two results: every scalar and every field, relative to sensible scales."""

from __future__ import annotations

import math
from collections import ChainMap
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from thermoroll_cli.files.result.labelled import Labelled, Node
from thermoroll_cli.files.result.outcome import numbers_of
from thermoroll_cli.problem.columns import Columns
from thermoroll_cli.problem.names import ALL_SCALARS, FIELDS, ISOTHERMAL, STRENGTH_FIELDS, SUBSURFACE_FIELDS, UNCERTAINTY
from thermoroll_cli.problem.problem import BODIES
from thermoroll_cli.problem.scalar_errors import error_scale, mean_semi_axis


@dataclass(frozen=True)
class Pair:
    """One compared quantity. For a field `a` and `b` are its values where they differ most (`note` has the place), for the
    state the numbers of contact elements; None means it is missing there.

    `difference` is relative, inf where a field exists on one side only or a scalar was computed on one side only, and nan where
    there is nothing to compare with: another grid, a scalar that one file has no name for (`note` says why).
    """

    name: str
    kind: str
    a: float | str | None
    b: float | str | None
    difference: float
    note: str = ""

    def within(self, rtol: float) -> bool:
        return math.isnan(self.difference) or self.difference <= rtol


@dataclass(frozen=True)
class Comparison:
    """All rows and the verdict. Fields on different grids and scalars that only one file names are not compared and do not
    count (`notes` says so)."""

    rows: tuple[Pair, ...]
    rtol: float
    notes: tuple[str, ...] = ()

    @property
    def within(self) -> bool:
        return all(row.within(self.rtol) for row in self.rows)

    @property
    def outside(self) -> tuple[Pair, ...]:
        """The rows that exceed the tolerance, worst first."""
        rows = [row for row in self.rows if not row.within(self.rtol)]
        return tuple(sorted(rows, key=lambda row: -row.difference))

    @property
    def largest(self) -> float:
        """The largest relative difference of all rows that could be compared."""
        return max((row.difference for row in self.rows if not math.isnan(row.difference)), default=0.0)


def compare(a: Node, b: Node, rtol: float = 1e-6) -> Comparison:
    """Differences between the trees of two results, scalar by scalar and field by field, of both states.

    Scalars: |a − b| over the larger `error_scale` of both. Fields: max|a − b| / max|a|
    (shear and slip: of the vector; temperatures: of both bodies); `state`: the share of contact elements whose state
    differs. nan equals nan. The isothermal state is compared where it is a state of its own in either result.
    """
    rows = []
    for name in ("status", "assembly", "unbounded", "warnings"):
        texts = ["; ".join(each.json(name, ())) if name in ("unbounded", "warnings") else str(each.attributes[name])
                 for each in (a, b)]
        if name != "assembly" or texts[0] != texts[1]:
            rows.append(Pair(name, "text", texts[0], texts[1], 0.0 if texts[0] == texts[1] else math.inf))
    one, other = numbers_of(a)[0], numbers_of(b)[0]
    rows += [*_scalar_rows("", one, other, one, other), *_patch_rows(a, b)]
    notes: list[str] = []
    patches = [each.nodes.get("patches", Node()).nodes for each in (a, b)]
    for name in _union(patches[0], patches[1], ()):
        if name in patches[0] and name in patches[1]:
            inner = compare(patches[0][name], patches[1][name], rtol)
            rows += [replace(row, name=f"{name}.{row.name}") for row in inner.rows]
            notes += [f"{name}: {note}" for note in inner.notes if not note.startswith("not compared, ")]
        else:
            rows.append(Pair(name, "text", None, None, math.inf, _missing(name in patches[0])))
    cold = [each.nodes.get("isothermal") for each in (a, b)]
    states = [("", a, b)]
    if own := next(filter(None, cold), None):
        # A state that is the same as the other one has no node of its own.
        states.append(("isothermal.", cold[0] or a, cold[1] or b))
        known = numbers_of(own)[0]
        here, there = ({name: value for name, value in numbers_of(each)[0].items() if name in known} for each in states[1][1:])
        rows += _scalar_rows("isothermal.", here, there, one, other)
    for missing in (_missing(True), _missing(False)):
        names = [row.name for row in rows if row.note == missing]
        notes += [f"not compared, {missing}: {', '.join(names)}"] if names else []
    for prefix, left, right in states:
        fields = [each.nodes.get("fields", Node()).arrays for each in (left, right)]
        found = list(_field_rows(prefix, *fields))
        rows += found
        notes += dict.fromkeys(row.note for row in found if math.isnan(row.difference) and row.note not in notes)
    rows += _rows_below(a, b)
    return Comparison(tuple(rows), rtol, tuple(notes))


def compare_tables(
    a: Columns, b: Columns, rtol: float = 1e-6, fields: Sequence[Mapping[str, Labelled]] = ({}, {})
) -> Comparison:
    """Differences between two tables, column by column but for errors and work, and between the `fields` of their states.

    The difference of a column is the largest of its rows, each over the larger `error_scale` there of both, of a history over
    the largest of all its rows, for values pass through zero; `a` and `b` are its values there. Raises ValueError for tables
    over other columns."""
    if a.label != b.label:
        raise ValueError(f"one is over {', '.join(a.label)}, the other over {', '.join(b.label)}")
    if a.count != b.count:
        return Comparison((Pair("rows", "scalar", a.count, b.count, math.inf, "another number of rows"),), rtol)
    rows = list[Pair]()
    states = [[dict(zip(table, cells, strict=True)) for cells in zip(*table.values(), strict=True)] for table in (a, b)]
    for name in dict.fromkeys((*a, *b)):
        if name.startswith((UNCERTAINTY, "work.")) or name in ("reason", "file"):
            continue
        if name not in a or name not in b:
            rows.append(Pair(name, "scalar", None, None, math.nan, _missing(name in a)))
            continue
        pairs = [*zip(a[name], b[name], strict=True)]
        words = any(isinstance(value, str) for pair in pairs for value in pair)
        scales = [0.0] * a.count if words else [*map(max, *(_scales(some, name) for some in states))]
        scales = [max(scales)] * a.count if a.of_history else scales
        apart = [0.0 if _text(one) == _text(other) else math.inf for one, other in pairs] if words else [
            _relative(one, other, scale) for (one, other), scale in zip(pairs, scales, strict=True)]
        worst = max(range(a.count), key=apart.__getitem__)
        at = ", ".join(f"{key} = {_text(a[key][worst])}" for key in a.label)
        rows.append(Pair(name, "text" if words else "scalar", *pairs[worst], apart[worst], f"at {at}" if apart[worst] else ""))
    missing = [f"not compared, {words}: {', '.join(names)}" for words in (_missing(True), _missing(False))
               if (names := [row.name for row in rows if row.note == words])]
    both = [*_field_rows("fields.", *fields)] if all(fields) else []
    notes = dict.fromkeys(row.note for row in both if math.isnan(row.difference))
    if any(fields) and not all(fields):
        notes[f"fields not compared: {_missing(bool(fields[0]))}"] = None
    return Comparison((*rows, *both), rtol, (*missing, *notes))


def _scales(states: list[dict[str, Any]], name: str) -> list[float]:
    """The scale of a scalar in each of the `states` of a table, 0 where it is not known."""
    plain = name.removeprefix(ISOTHERMAL)
    return [_finite(error_scale(plain, ChainMap({plain: state[name]}, state))) for state in states]


def _text(value: Any) -> str:
    """A cell of a table in words; an empty text of a CSV file is read as nan."""
    if isinstance(value, str):
        return value
    return "" if math.isnan(value) else f"{value:.6g}"


def _patch_rows(a: Node, b: Node) -> Iterator[Pair]:
    """The patches of both contacts, one by one; each quantity over its larger magnitude, a place over the mean semi-axis and a
    force over the patch's load at least."""
    one, other = (each.json("patches", ()) for each in (a, b))
    if len(one) != len(other):
        yield Pair("patches", "scalar", len(one), len(other), math.inf, "another number of patches")
        return
    for number, (left, right) in enumerate(zip(one, other, strict=True), 1):
        arm = max(_finite(mean_semi_axis(numbers_of(each)[0])) for each in (a, b))
        for name in _union(left, right, left):
            here, there = (float(patch.get(name, math.nan)) for patch in (left, right))
            least = arm if name.endswith("_mm") else float(left["normal_N"]) if name.endswith("_N") else 0.0
            scale = max(abs(here), abs(there), least)
            yield Pair(f"patches.{number}.{name}", "scalar", here, there, _relative(here, there, scale))


def _scalar_rows(
    prefix: str, a: Mapping[str, float], b: Mapping[str, float], all_a: Mapping[str, float], all_b: Mapping[str, float]
) -> Iterator[Pair]:
    """Rows of the scalars of one state; `all_a` and `all_b` have those that scales need and the state lacks."""
    for name in _union(a, b, ALL_SCALARS):
        if name not in a or name not in b:
            # Another version of this program, or a case that asks for more: nothing here to compare it with.
            yield Pair(prefix + name, "scalar", a.get(name), b.get(name), math.nan, _missing(name in a))
        else:
            scale = max(_finite(error_scale(name, {**all_a, **a})), _finite(error_scale(name, {**all_b, **b})))
            yield Pair(prefix + name, "scalar", a[name], b[name], _relative(a[name], b[name], scale))


def _field_rows(prefix: str, a: Mapping[str, Labelled], b: Mapping[str, Labelled]) -> Iterator[Pair]:
    axes = {name: array.values for name, array in a.items() if array.axes == (name,)}
    same = all(name in b and values.shape == b[name].values.shape  # but for rounding
               and np.allclose(values, b[name].values, rtol=0.0, atol=1e-9 * np.abs(values).max())
               for name, values in axes.items())
    note = "" if same else f"fields not compared: different grids ({_grid_words(a)} and {_grid_words(b)})"
    for name in (each for each in _union(a, b, FIELDS) if each not in axes and each not in "xy"):
        one, other = (side[name].values if name in side else None for side in (a, b))
        if not same:
            yield Pair(prefix + name, "field", _magnitude(one), _magnitude(other), math.nan, note)
        elif name == "state" and one is not None and other is not None:
            contact = int(np.count_nonzero((one != 0) | (other != 0)))
            share = int(np.count_nonzero(one != other)) / max(1, contact)
            yield Pair(prefix + name, "field", int(np.count_nonzero(one)), int(np.count_nonzero(other)), share,
                       "share of the contact elements whose state differs")
        else:
            family = FIELDS[name].family if name in FIELDS else ""
            members = [each for each in a if each == name or (family and each in FIELDS and FIELDS[each].family == family)]
            scale = max((_magnitude(a[member].values) or 0.0 for member in members), default=0.0)
            yield _field_row(prefix + name, axes, a.get(name), b.get(name), scale)


def _grid_words(fields: Mapping[str, Labelled]) -> str:
    """Elements and domain in words: two grids may differ in extent or place alone."""
    axes = [fields[name].values for name in "xy" if name in fields]
    sides = [(n := axis.size, 1e3 * np.ptp(axis) * n / max(1, n - 1), 5e2 * (axis[0] + axis[-1])) for axis in axes]
    about = ", ".join(f"{name} = {middle:.4g}" for name, (_, _, middle) in zip("xy", sides, strict=False))
    off = max((abs(middle / length) for _, length, middle in sides), default=0.0) > 1e-6
    return (f"{'×'.join(str(n) for n, _, _ in sides)} over {'×'.join(f'{length:.4g}' for _, length, _ in sides)} mm"
            + (f" about {about} mm" if off else ""))


def _rows_below(a: Node, b: Node) -> Iterator[Pair]:
    """Depths and stored stresses inside the bodies, each relative to the largest von Mises stress of its body. Stresses at
    other depths are not compared."""
    for body in BODIES:
        if body not in a.nodes or body not in b.nodes:
            if body in a.nodes or body in b.nodes:
                yield Pair(f"subsurface.{body}", "field", None, None, math.inf, _missing(body in a.nodes))
            continue
        left, right = a.nodes[body].arrays, b.nodes[body].arrays
        axes = {name: left[name].values for name in "zxy" if name in left}
        depths = _field_row(f"subsurface.{body}.depths", axes, left["z"], right.get("z"), float(axes["z"][-1]))
        yield depths
        if not depths.difference <= 1e-9:  # more than rounding
            continue
        order = [f"{prefix}{name}" for prefix in ("", "plane_") for name in SUBSURFACE_FIELDS] + [*STRENGTH_FIELDS]
        for name in _union(left, right, order):
            if name in order:
                scale = _magnitude(left[name].values) if name == "temperature_rise" and name in left else (
                    a.nodes[body].attributes["stressed_value"])
                shown = f"strength_{name}" if name in STRENGTH_FIELDS else name
                yield _field_row(f"subsurface.{body}.{shown}", axes, left.get(name), right.get(name), float(scale or 0.0))


def _field_row(name: str, axes: Mapping[str, NDArray[Any]], one: Labelled | None, other: Labelled | None, scale: float) -> Pair:
    """The difference of a field, and both values where it is largest."""
    if one is None or other is None or one.values.shape != other.values.shape:
        note = _missing(one is not None) if (one is None) != (other is None) else "of another shape"
        left, right = (None if each is None else _magnitude(each.values) for each in (one, other))
        return Pair(name, "field", left, right, math.inf, note)
    a, b = one.values, other.values
    same = (a == b) | (np.isnan(a) & np.isnan(b))
    distance = np.abs(np.where(same, 0.0, a).astype(np.float64) - np.where(same, 0.0, b))
    distance[~np.isfinite(distance)] = math.inf
    index = np.unravel_index(np.argmax(distance), distance.shape)
    difference = float(distance[index])
    if difference == 0.0:
        return Pair(name, "field", _magnitude(a), _magnitude(b), 0.0, "largest magnitudes")
    relative = difference / scale if scale > 0.0 and math.isfinite(difference) else math.inf
    place = ", ".join(f"{axis} = {axes[axis][i] * (1e3 if axis in 'xyz' else 1.0):.3g}"
                      for axis, i in zip(one.axes, index, strict=True))
    return Pair(name, "field", float(a[index]), float(b[index]), relative, f"at {place} mm")


def _relative(a: float, b: float, scale: float) -> float:
    if a == b or (math.isnan(a) and math.isnan(b)):
        return 0.0
    difference = abs(a - b)
    return difference / scale if math.isfinite(difference) and scale > 0.0 else math.inf


def _finite(value: float) -> float:
    return value if math.isfinite(value) else 0.0


def _magnitude(values: NDArray[Any] | None) -> float | None:
    """Largest absolute value, nan and infinite ones left aside; None for no array."""
    if values is None:
        return None
    sizes = np.abs(np.asarray(values, dtype=np.float64))
    return float(np.max(sizes, initial=0.0, where=np.isfinite(sizes)))


def _missing(in_a: bool) -> str:
    return "missing in the second file" if in_a else "missing in the first file"


def _union(a: Mapping[str, Any], b: Mapping[str, Any], order: Iterable[str]) -> list[str]:
    """Names of either side: the known ones in their order, then the others by alphabet."""
    names = {*a, *b}
    known = [name for name in order if name in names]
    return known + sorted(names.difference(known))
