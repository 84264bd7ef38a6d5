"""Files of columns that a case names: records over time, positions of a wheelset's service, and measured moduli.

**Records over time** (`read_history`), as a vehicle program or a rig exports them, have the columns `distance_mm` or `time_s`
and keys that change. A name without its unit may have another one in brackets, or in the row below: `time [ms]`,
`load.normal [kN]`, `rolling.speed [km/h]`.

**Positions** (`read_positions`) have a column `weight`, and one for each key that differs.

**Moduli** of a body that relaxes (dynamic mechanical analysis; `read_series`) have the columns `frequency_Hz`, `storage_GPa`
and `loss_GPa` (or MPa, Pa), or as instruments name them: "Frequency [Hz]", "E' (MPa)", "tan δ". With one time per half decade
from beyond the highest frequency to beyond the lowest, they are linear in the relaxed modulus and the share of each time:

    E′ = E_∞ + Σ Eᵢ (ωτᵢ)²/(1 + (ωτᵢ)²),      E″ = Σ Eᵢ ωτᵢ/(1 + (ωτᵢ)²),

fitted by non-negative least squares of relative deviations. Shares are relative to E_∞ + Σ Eᵢ; the scale of the data has no
effect.
"""

from __future__ import annotations

import difflib
import math
import os
import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import scipy

from thermoroll_cli.files.case_source import toml_value
from thermoroll_cli.files.csv_table import FILE_LIMIT, TableError, read_columns
from thermoroll_cli.files.spellings import converted, factor_of, in_own_units, meant
from thermoroll_cli.many_contacts.history.course import OF_WHEELSETS, VARIED
from thermoroll_cli.problem.names import PLACES, unit_end, unit_of

HEAD = re.compile(r"(.*?)\s*(?:[\[(]([^\])]*)[\])])?")
"""A name and its unit in brackets."""


@dataclass(frozen=True)
class FromFile:
    """What a file of columns stands for in a case, the `content` of keys, and what `show` says of it, as a record and in
    `sentence`."""

    content: Any
    shown: dict[str, Any]
    sentence: str

    def record(self) -> dict[str, Any]:
        """What `show` says."""
        return self.shown

    def words(self, record: dict[str, Any]) -> str:
        """The `record` as a sentence for people."""
        return self.sentence.format(**record)


def read_history(path: str | os.PathLike[str]) -> FromFile:
    """The tables of `[history]` in the file at `path` (`read_columns`). Raises TableError with file, line and column,
    OSError."""
    name = os.path.basename(os.fspath(path))
    heads, lines = read_columns(path, "a record over time")
    units = [""] * len(heads)
    if not any(map(_is_number, lines[0][1])):
        units, lines = lines[0][1], lines[1:]
    columns: dict[str, list[float]] = {}
    for place, (head, unit) in enumerate(zip(heads, units, strict=True)):
        key, factor = _varied(name, head, unit)
        if key in columns:
            raise TableError(f"{name}: the column {key} stands there twice")
        columns[key] = []
        for number, cells in lines:
            if not _is_number(cells[place]):
                raise TableError(f'{name}, line {number}: {head} is "{cells[place]}", not a number')
            columns[key].append(converted(float(cells[place]), factor))
    places = [each for each in PLACES if each in columns]
    if len(places) != 1:
        raise TableError(f"{name} has {'both' if places else 'neither'} distance_mm {'and' if places else 'nor'} time_s",
                         f"one of them; found: {', '.join(columns)[:200]}")
    values = columns.pop(places[0])
    if len(values) < 2 or not columns:
        raise TableError(f"{name} has {len(values)} rows, and {len(columns)} keys that change", "two rows and a key at least")
    for before, (one, other) in enumerate(pairwise(values)):
        if other < one:
            raise TableError(f"{name}, line {lines[before + 1][0]}: {places[0]} falls from {one:g} to {other:g}",
                             "rows in the order of time; the same place twice is a jump")
    return FromFile({places[0]: values, "values": columns},
                    {"file": name, "rows": len(values), "first": values[0], "last": values[-1], "place": places[0],
                     "keys": list(columns)},
                    f"{{file}}: {{rows}} rows from {{first:.6g}} to {{last:.6g}} ({{place}}), {', '.join(columns)}")


def _varied(name: str, head: str, below: str) -> tuple[str, float]:
    """The key of a column, and the size of its unit in that of the key. Raises TableError."""
    parts = HEAD.fullmatch(head)
    assert parts is not None
    own, unit = parts[1].strip(), (parts[2] or below).strip().strip("[]()")
    known: Sequence[str] = (*PLACES, *dict.fromkeys((*VARIED, *OF_WHEELSETS)))
    key = next((each for each in known if own in (each, each.removesuffix(unit_end(each)))), None)
    if key is None:
        near = [each for each in (meant(own),) if each in known] or difflib.get_close_matches(own, known, n=1)
        raise TableError(f"{name}: the column {own} is no key that changes over time",
                         f"did you mean {near[0]}?" if near else f"there are {', '.join(known)}")
    if not unit and own != key:
        raise TableError(f"{name}: {own} has no unit", f"call it {key}, or write the unit behind the name in brackets")
    factor = factor_of(unit, unit_of(key)) if unit else 1.0
    if factor is None:
        raise TableError(f"{name}: the column {own} cannot be in {unit}",
                         f"{key} is in {unit_of(key) or 'numbers without a unit'}")
    return key, factor


def _is_number(cell: str) -> bool:
    try:
        return math.isfinite(float(cell))
    except ValueError:
        return False


def read_positions(path: str) -> list[list[Any]]:
    """[weight, {key: value}] of each line of the CSV file at `path` (`read_columns`). An empty cell leaves its key as the case
    has it; units in brackets behind keys are converted. Raises ValueError, OSError."""
    names, lines = read_columns(path, "a table of positions", gaps=True, largest=FILE_LIMIT)
    keys, factors = in_own_units(path, names)
    if "weight" not in keys or "" in keys or len({*keys}) < len(keys):
        raise ValueError("needs a header line with weight and keys, each once, and a line for each position")
    found = []
    for number, cells in lines:
        values = {key: toml_value(cell) for key, cell in zip(keys, cells, strict=True) if cell}
        values |= {key: converted(values[key], factor) for key, factor in zip(keys, factors, strict=True)
                   if factor != 1.0 and type(values.get(key)) in (int, float)}
        weight = values.pop("weight", None)
        if isinstance(weight, bool) or not isinstance(weight, int | float) or not 0.0 < weight <= 1e9:
            given = cells[keys.index("weight")] or "nothing"
            raise ValueError(f"line {number}: the weight must be a number above 0, not {given}")
        for key, value in values.items():
            if not isinstance(value, bool | int | float | str):
                raise ValueError(f"line {number}: {key} must be a number or a word")
        found.append([float(weight), values])
    return found


LEAST_SHARE = 1e-5
"""Shares below it are left out."""
UNITS = {"GPa": 1e9, "MPa": 1e6, "Pa": 1.0}
MODULI = {
    "frequency": (("frequency", "freq", "f"), {"Hz": 1.0, "rad/s": 0.5 / math.pi}),
    "storage": (("storage", "storage modulus", "e'", "e′", "g'", "g′"), UNITS),
    "loss": (("loss", "loss modulus", "e''", "e″", "g''", "g″", 'e"', 'g"'), UNITS),
    "loss factor": (("tan δ", "tan delta", "tan(delta)", "tan(δ)", "tanδ", "tan d", "loss factor", "tan_delta"), {"": 1.0}),
}
"""Quantities, the names of their columns, and their units. The loss factor stands for the loss modulus."""
MODULI_HEAD = re.compile(r"(.*?)(?:[\s_]*[\[(](Hz|rad/s|GPa|MPa|Pa|[-1]?)[\])]|[\s_](Hz|rad/s|GPa|MPa|Pa))?")
"""A name and its unit, behind an underscore, in brackets or in parentheses."""


def read_series(path: str | os.PathLike[str]) -> FromFile:
    """The series that fits the file at `path`, [share, time in s]. Raises TableError, OSError."""
    name = os.path.basename(os.fspath(path))
    frequency, storage, loss = _moduli(path, name)
    omega = 2.0 * math.pi * frequency
    ends = -math.log10(omega.max()) - 0.5, -math.log10(omega.min()) + 0.5
    count = max(2, round(2.0 * (ends[1] - ends[0])) + 1)
    product = omega[:, None] * np.logspace(*ends, count)
    weight = 1.0 / np.hypot(storage, loss)
    matrix = np.vstack([np.column_stack([np.ones(omega.size), product**2 / (1.0 + product**2)]) * weight[:, None],
                        np.column_stack([np.zeros(omega.size), product / (1.0 + product**2)]) * weight[:, None]])
    wanted = np.concatenate([storage, loss]) * np.tile(weight, 2)
    moduli, misfit = scipy.optimize.nnls(matrix, wanted)
    modulus = float(moduli.sum())
    shares = moduli[1:] / modulus
    if moduli[0] < LEAST_SHARE * modulus:
        raise TableError(f"{name}: at {frequency.min():g} Hz the body still relaxes, and no modulus is seen to remain",
                         "measure lower frequencies, or give relaxation = [[share, time], …]")
    series = [[float(share), float(time)] for share, time in zip(shares, np.logspace(*ends, count), strict=True)
              if share > LEAST_SHARE]
    if not series:
        raise TableError(f"{name}: nothing relaxes between {frequency.min():g} and {frequency.max():g} Hz",
                         "leave relaxation_file out")
    remains, deviation = float(moduli[0] / modulus), float(misfit) / math.sqrt(omega.size)
    return FromFile(series, {
        "file": name, "frequencies": omega.size, "lowest_Hz": float(frequency.min()), "highest_Hz": float(frequency.max()),
        "times": len(series), "modulus_GPa": 1e-9 * modulus, "relaxed_share": remains, "rms_deviation": deviation},
        "{file}: {frequencies} frequencies from {lowest_Hz:.3g} to {highest_Hz:.3g} Hz, {times} times that deviate by "
        f"{100.0 * deviation:.2g} % (rms), {{modulus_GPa:.4g}} GPa at once, which youngs_modulus_GPa "
        f"is for the moduli of the file, {100.0 * remains:.3g} % of it remains")


def _moduli(path: str | os.PathLike[str], name: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Frequencies in Hz, and storage and loss moduli in Pa."""
    header, rows = read_columns(path, "a table of measured moduli", largest=FILE_LIMIT)
    heads = [_named(head) for head in header]
    has_factor = any(head and head[0] == "loss factor" for head in heads)
    found = []
    for wanted in ("frequency", "storage", "loss"):
        if wanted == "loss" and has_factor and not any(head and head[0] == "loss" for head in heads):
            wanted = "loss factor"
        column, factor = next(((k, head[1]) for k, head in enumerate(heads) if head and head[0] == wanted), (-1, 0.0))
        if column < 0:
            raise TableError(f"{name} has no column {wanted}_{next(iter(MODULI[wanted][1]))}",
                             f"its first row names the columns; found: {', '.join(header)[:200]}")
        values = []
        for number, cells in rows:
            try:
                values.append(float(cells[column]) * factor)
            except ValueError:
                raise TableError(f"{name}, line {number}: {wanted} is no number") from None
            if not (math.isfinite(values[-1]) and values[-1] > 0.0):
                raise TableError(f"{name}, line {number}: {wanted} must be positive and finite, got {values[-1]:g}")
        found.append(np.array(values))
    if found[0].size < 3:
        raise TableError(f"{name} has {found[0].size} frequencies", "at least 3")
    frequency, storage, loss = found
    return frequency, storage, storage * loss if wanted == "loss factor" else loss


def _named(head: str) -> tuple[str, float] | None:
    """The quantity of a column and the factor of its unit, where its name says both."""
    parts = MODULI_HEAD.fullmatch(head.strip())
    assert parts is not None
    what, unit = parts[1].lower(), (parts[2] or parts[3] or "").strip("-1")
    return next(((quantity, units[unit]) for quantity, (names, units) in MODULI.items()
                 if what in names and unit in units), None)
