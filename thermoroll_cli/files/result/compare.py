"""Differences between two results: every scalar and every field, relative to sensible scales."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from thermoroll_cli.problem.names import ALL_SCALARS, FIELDS, STRENGTH_FIELDS, SUBSURFACE_FIELDS
from thermoroll_cli.problem.problem import BODIES
from thermoroll_cli.problem.result import Result, State
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


def compare_results(a: Result, b: Result, rtol: float = 1e-6) -> Comparison:
    """Differences between two stored results, scalar by scalar and field by field, of both states.

    Scalars: |a − b| over the larger `error_scale` of both. Fields: max|a − b| / max|a|
    (shear and slip: of the vector; temperatures: of both bodies); `state`: the share of contact elements whose state
    differs. nan equals nan. The isothermal state is compared where it is a state of its own in either result.
    """
    rows = [Pair("status", "text", a.status, b.status, 0.0 if a.status == b.status else math.inf)]
    if a.assembly != b.assembly:
        rows.append(Pair("assembly", "text", a.assembly, b.assembly, math.inf))
    for name in ("unbounded", "warnings"):
        texts = ["; ".join(getattr(each, name)) for each in (a, b)]
        rows.append(Pair(name, "text", texts[0], texts[1], 0.0 if texts[0] == texts[1] else math.inf))
    one, other = a.numbers, b.numbers
    rows += _scalar_rows("", one, other, one, other)
    rows += _patch_rows(a, b)
    notes = []
    for name in _union({patch.name: patch for patch in a.contacts}, {patch.name: patch for patch in b.contacts}, ()):
        left, right = ([patch for patch in whole.contacts if patch.name == name] for whole in (a, b))
        if left and right:
            inner = compare_results(left[0], right[0], rtol)
            rows += [replace(row, name=f"{name}.{row.name}") for row in inner.rows]
            notes += [f"{name}: {note}" for note in inner.notes if not note.startswith("not compared, ")]
        else:
            rows.append(Pair(name, "text", None, None, math.inf, _missing(bool(left))))
    both = a.isothermal is not a.coupled or b.isothermal is not b.coupled
    if both:
        rows += _scalar_rows("isothermal.", a.isothermal.scalars, b.isothermal.scalars, one, other)
    for missing in (_missing(True), _missing(False)):
        names = [row.name for row in rows if row.note == missing]
        notes += [f"not compared, {missing}: {', '.join(names)}"] if names else []
    states = [("", a.coupled, b.coupled), ("isothermal.", a.isothermal, b.isothermal)]
    for prefix, here, there in () if a.assembly or b.assembly else states if both else states[:1]:
        if _same_grid(here, there):
            rows += _field_rows(prefix, here, there.fields)
            continue
        note = f"fields not compared: different grids ({_grid_words(here)} and {_grid_words(there)})"
        notes += [note] if note not in notes else []
        rows += [
            Pair(prefix + name, "field", _magnitude(here.fields.get(name)), _magnitude(there.fields.get(name)), math.nan, note)
            for name in _union(here.fields, there.fields, FIELDS)
        ]
    rows += _rows_below(a, b)
    return Comparison(tuple(rows), rtol, tuple(notes))


def _patch_rows(a: Result, b: Result) -> Iterator[Pair]:
    """The patches of both, one by one; each quantity over its larger magnitude, a place over the mean semi-axis and a
    force over the patch's load at least."""
    if a.contacts or b.contacts:
        return
    if len(a.patches) != len(b.patches):
        yield Pair("patches", "scalar", len(a.patches), len(b.patches), math.inf, "another number of patches")
        return
    arm = max(_finite(mean_semi_axis(each.numbers)) for each in (a, b))
    for number, (left, right) in enumerate(zip(a.records, b.records, strict=True), 1):
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


def _same_grid(one: State, other: State) -> bool:
    """Whether both grids are the same but for rounding."""
    return all(left.shape == right.shape and bool(np.allclose(left, right, rtol=0.0, atol=1e-9 * np.abs(left).max()))
               for left, right in ((one.x, other.x), (one.y, other.y)))


def _grid_words(state: State) -> str:
    """Elements and domain in words: two grids may differ in extent or place alone."""
    (nx, width, east), (ny, height, north) = (
        (n := axis.size, 1e3 * np.ptp(axis) * n / max(1, n - 1), 5e2 * (axis[0] + axis[-1])) for axis in (state.x, state.y))
    about = f" about x = {east:.4g}, y = {north:.4g} mm" if max(abs(east / width), abs(north / height)) > 1e-6 else ""
    return f"{nx}×{ny} over {width:.4g}×{height:.4g} mm{about}"


def _field_rows(prefix: str, on: State, b: Mapping[str, NDArray[Any]]) -> Iterator[Pair]:
    a = on.fields
    for name in _union(a, b, FIELDS):
        if name == "state" and name in a and name in b:
            left, right = (int(np.count_nonzero(fields[name])) for fields in (a, b))
            contact = int(np.count_nonzero((a[name] != 0) | (b[name] != 0)))
            share = int(np.count_nonzero(a[name] != b[name])) / max(1, contact)
            yield Pair(prefix + name, "field", left, right, share, "share of the contact elements whose state differs")
        else:
            family = FIELDS[name].family if name in FIELDS else ""
            members = [other for other in a if other == name or (family and other in FIELDS and FIELDS[other].family == family)]
            scale = max((_magnitude(a[member]) or 0.0 for member in members), default=0.0)
            yield _field_row(prefix + name, {"x": on.x, "y": on.y}, a.get(name), b.get(name), scale)


def _rows_below(a: Result, b: Result) -> Iterator[Pair]:
    """Depths and stored stresses inside the bodies, each relative to the largest von Mises stress of its body. Stresses at
    other depths are not compared."""
    for body in _union(a.bodies, b.bodies, BODIES):
        if body not in a.bodies or body not in b.bodies:
            yield Pair(f"subsurface.{body}", "field", None, None, math.inf, _missing(body in a.bodies))
            continue
        left, right = a.bodies[body], b.bodies[body]
        axes = {"z": left.depths, "x": a.x, "y": a.y}
        below, deepest = {"z": left.depths}, float(left.depths[-1])
        depths = _field_row(f"subsurface.{body}.depths", below, left.depths, right.depths, deepest)
        yield depths
        if not depths.difference <= 1e-9:  # more than rounding
            continue
        for prefix, fields, others in (("", left.fields, right.fields), ("plane_", left.plane, right.plane),
                                       ("strength_", left.strength, right.strength)):
            for name in _union(fields, others, (*SUBSURFACE_FIELDS, *STRENGTH_FIELDS)):
                scale = _magnitude(fields.get(name)) if name == "temperature_rise" else left.most_stressed.value
                along = {"z": left.depths, "y": a.y} if prefix == "strength_" else axes
                yield _field_row(f"subsurface.{body}.{prefix}{name}", along, fields.get(name), others.get(name), scale or 0.0)


def _field_row(
    name: str, axes: Mapping[str, NDArray[Any]], a: NDArray[Any] | None, b: NDArray[Any] | None, scale: float
) -> Pair:
    """The difference of a field, and both values where it is largest; `axes` are those of the array."""
    if a is None or b is None or a.shape != b.shape:
        note = _missing(a is not None) if (a is None) != (b is None) else "of another shape"
        return Pair(name, "field", _magnitude(a), _magnitude(b), math.inf, note)
    same = (a == b) | (np.isnan(a) & np.isnan(b))
    distance = np.abs(np.where(same, 0.0, a).astype(np.float64) - np.where(same, 0.0, b))
    distance[~np.isfinite(distance)] = math.inf
    index = np.unravel_index(np.argmax(distance), distance.shape)
    difference = float(distance[index])
    if difference == 0.0:
        return Pair(name, "field", _magnitude(a), _magnitude(b), 0.0, "largest magnitudes")
    relative = difference / scale if scale > 0.0 and math.isfinite(difference) else math.inf
    place = ", ".join(f"{axis} = {1e3 * values[i]:.3g}" for (axis, values), i in zip(axes.items(), index, strict=False))
    return Pair(name, "field", float(a[index]), float(b[index]), relative, f"at {place} mm")


def _relative(a: float, b: float, scale: float) -> float:
    if a == b or (math.isnan(a) and math.isnan(b)):
        return 0.0
    difference = abs(a - b)
    return difference / scale if math.isfinite(difference) and scale > 0.0 else math.inf


def _finite(value: Any) -> float:
    number = float(value) if isinstance(value, (int, float)) else 0.0
    return number if math.isfinite(number) else 0.0


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
