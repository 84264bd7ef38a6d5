"""Measured moduli of a body that relaxes (dynamic mechanical analysis), and the Prony series that fits them.

The file has a header row and the columns `frequency_Hz`, `storage_GPa` and `loss_GPa` (or MPa, Pa), or as instruments name
them: "Frequency [Hz]", "E' (MPa)", "tan δ". With one time per half decade from beyond the highest frequency to beyond the
lowest, the moduli are linear in the relaxed modulus and the share of each time:

    E′ = E_∞ + Σ Eᵢ (ωτᵢ)²/(1 + (ωτᵢ)²),      E″ = Σ Eᵢ ωτᵢ/(1 + (ωτᵢ)²),

fitted by non-negative least squares of relative deviations. Shares are relative to E_∞ + Σ Eᵢ; the scale of the data has no
effect.
"""

from __future__ import annotations

import math
import os
import re

import numpy as np
import scipy

from thermoroll_cli.files.csv_table import FILE_LIMIT, FromFile, TableError, read_columns

LEAST_SHARE = 1e-5
"""Shares below it are left out."""
UNITS = {"GPa": 1e9, "MPa": 1e6, "Pa": 1.0}
COLUMNS = {
    "frequency": (("frequency", "freq", "f"), {"Hz": 1.0, "rad/s": 0.5 / math.pi}),
    "storage": (("storage", "storage modulus", "e'", "e′", "g'", "g′"), UNITS),
    "loss": (("loss", "loss modulus", "e''", "e″", "g''", "g″", 'e"', 'g"'), UNITS),
    "loss factor": (("tan δ", "tan delta", "tan(delta)", "tan(δ)", "tanδ", "tan d", "loss factor", "tan_delta"), {"": 1.0}),
}
"""Quantities, the names of their columns, and their units. The loss factor stands for the loss modulus."""
HEAD = re.compile(r"(.*?)(?:[\s_]*[\[(](Hz|rad/s|GPa|MPa|Pa|[-1]?)[\])]|[\s_](Hz|rad/s|GPa|MPa|Pa))?")
"""A name and its unit, behind an underscore, in brackets or in parentheses."""


def read_series(path: str | os.PathLike[str]) -> FromFile:
    """The series that fits the file at `path`, [share, time in s]. Raises TableError, OSError."""
    name = os.path.basename(os.fspath(path))
    frequency, storage, loss = _columns(path, name)
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
        f"{100.0 * deviation:.2g} % (rms), {{modulus_GPa:.4g}} GPa at once, {100.0 * remains:.3g} % of it remains")


def _columns(path: str | os.PathLike[str], name: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
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
            raise TableError(f"{name} has no column {wanted}_{next(iter(COLUMNS[wanted][1]))}",
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
    parts = HEAD.fullmatch(head.strip())
    assert parts is not None
    what, unit = parts[1].lower(), (parts[2] or parts[3] or "").strip("-1")
    return next(((quantity, units[unit]) for quantity, (names, units) in COLUMNS.items()
                 if what in names and unit in units), None)
