"""Columns of a sweep's table as numbers and words for its figures."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from thermoroll_cli.exact.kalker import CreepageCoefficients, fastsim, linear_creep_forces, polach
from thermoroll_cli.plots import style
from thermoroll_cli.problem.names import UNITS
from thermoroll_cli.problem.scalar_errors import absolute_error

Column = NDArray[np.float64]
Table = Mapping[str, Sequence[Any]]

ISOTHERMAL = ("isothermal.", "isothermal_")
"""How the columns of the state without thermal deformation may begin."""
ERROR = "error."
"""How the columns of estimated errors begin."""

THEORIES = {"linear": "Kalker's linear theory", "fastsim": "FASTSIM", "polach": "Polach"}
"""Theories that creep forces can be compared with, and their words."""
THEORY_COLUMNS = ("hertz_a_mm", "hertz_b_mm", "shear_modulus_GPa", "friction_limit_N", "kalker_C11", "kalker_C22", "kalker_C23",
                  "creepage_longitudinal", "creepage_lateral", "creepage_spin_rad_mm")  # fmt: skip
"""Columns that the creep forces of these theories depend on."""


def numbers(values: Sequence[Any]) -> Column:
    """The column as numbers, nan for all else."""
    result = np.full(len(values), math.nan)
    for row, value in enumerate(values):
        try:
            result[row] = float(value)
        except (TypeError, ValueError):
            continue
    result[~np.isfinite(result)] = math.nan
    return result


def places(values: Sequence[Any]) -> tuple[Column, list[str]]:
    """Swept values as places on an axis: the numbers, or for words 0, 1, … and the words there."""
    found = numbers(values)
    if np.isfinite(found).any() or not values:
        return found, []
    words = list(dict.fromkeys(str(value) for value in values))
    return np.array([float(words.index(str(value))) for value in values]), words


def failed_points(table: Table) -> NDArray[np.bool_]:
    """Points that did not converge: they have no scalars, or those of another state than the one asked for."""
    rows = len(next(iter(table.values()), ()))
    return np.array([status != "converged" for status in table.get("status", ["converged"] * rows)], dtype=bool)


def unbounded_points(table: Table, names: Sequence[str]) -> NDArray[np.bool_]:
    """Points where any of the named columns has no limit: it grows with every refinement."""
    rows = len(next(iter(table.values()), ()))
    return np.array([not set(names).isdisjoint(str(cell).split()) for cell in table.get("unbounded", [""] * rows)], dtype=bool)


def merged(table: Table, names: Sequence[str]) -> Column | None:
    """The largest of the named columns point by point; None where none of them holds a number."""
    found = [numbers(table[name]) for name in names if name in table]
    found = [values for values in found if np.any(np.isfinite(values))]
    return np.fmax.reduce(found) if found else None


def summaries(table: Table) -> list[dict[str, Any]]:
    """Each row as the summary of a result: its scalars, with their errors by name."""
    columns = {name: numbers(column) for name, column in table.items() if not name.startswith(ISOTHERMAL)}
    columns = {name: column for name, column in columns.items() if np.isfinite(column).any()}
    scalars = [name for name in columns if not name.startswith(ERROR)]
    wrong = [name for name in columns if name.startswith(ERROR)]
    return [{name: float(columns[name][row]) for name in scalars}
            | {"error": {name.removeprefix(ERROR): float(columns[name][row]) for name in wrong}}
            for row in range(len(next(iter(table.values()), ())))]


def errors(rows: Sequence[Mapping[str, Any]], names: Sequence[str]) -> Column:
    """Estimated errors of the named scalars in their own unit, the largest at each point; 0 where there is none."""
    return np.array([max(absolute_error(name, row) if name in row["error"] else 0.0 for name in names) for row in rows])


def isothermal(table: Table, names: Sequence[str]) -> Column | None:
    """The named columns of the state without thermal deformation."""
    found = (merged(table, [prefix + name for name in names]) for prefix in ISOTHERMAL)
    return next((values for values in found if values is not None), None)


def theory_forces(table: Table, theory: str) -> dict[str, Column]:
    """Creep forces of one of `THEORIES` at every point, by column. Raises ValueError for another one, and where the table lacks
    what it needs."""
    if theory not in THEORIES:
        raise ValueError(f"creep forces can be compared with {', '.join(THEORIES)}, not {theory!r}")
    columns = [numbers(table.get(name, ())) for name in THEORY_COLUMNS]
    if any(not np.isfinite(column).any() for column in columns):
        missing = next(name for name, column in zip(THEORY_COLUMNS, columns, strict=True) if not np.isfinite(column).any())
        raise ValueError(f"{THEORIES[theory]} needs an elliptic contact with friction: the table has no numbers in {missing}")
    forces = {"force_x_N": [], "force_y_N": []}  # type: dict[str, list[float]]
    for a, b, modulus, limit, c11, c22, c23, along, lateral, spin in zip(*columns, strict=True):
        if not np.isfinite([a, b, modulus, limit, c11, along, lateral, spin]).all():
            found = (math.nan, math.nan)
        else:
            contact = (CreepageCoefficients(c11, c22, c23, math.nan), a * 1e-3, b * 1e-3, modulus * 1e9)
            creepage = (along, lateral, spin * 1e3)
            made = (linear_creep_forces(*contact, *creepage) if theory == "linear"
                    else {"fastsim": fastsim, "polach": polach}[theory](*contact, limit, *creepage))
            found = (made.force_x, made.force_y)
        for name, value in zip(forces, found, strict=True):
            forces[name].append(value)
    return {name: np.array(values) for name, values in forces.items()}


def cell_text(value: Any) -> str:
    """A swept value in few digits."""
    try:
        return style.readable(f"{float(value):.{6 if abs(float(value)) >= 1.0 else 4}g}")
    except (TypeError, ValueError):
        return str(value)


def with_value(key: str, value: Any) -> str:
    """A case key with its value: `rolling.speed_m_s` and 5 become "rolling speed = 5 m/s"."""
    words, _, unit = words_of(key).partition(" (")
    return f"{words} = {cell_text(value)} {unit.removesuffix(')')}".rstrip()


def words_of(key: str) -> str:
    """A case key as an axis label: `rolling.speed_m_s` becomes "rolling speed (m/s)"."""
    section, _, name = key.rpartition(".")
    suffix = next((suffix for suffix in UNITS if name.endswith(suffix)), "")
    words = name.removesuffix(suffix).replace("_", " ")
    if (section in ("creepage", "force") and words != "spin") or words == "normal":
        words = f"{words} {section}"
    elif section == "rolling":
        words = f"{section} {words}"
    return f"{words} ({UNITS[suffix]})" if suffix else words
