"""The readers of tables for vehicle programs in docs/readers, compiled and run."""

from __future__ import annotations

import csv
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from tests.support.command_line import call
from thermoroll_cli import CreepForceTable

ROOT = Path(__file__).parents[2]
CIRCLE = ROOT / "cases" / "creep_forces_circle.h5"


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
def test_the_reader_in_c_finds_the_forces_of_the_table(tmp_path: Path) -> None:
    """Linear between the nodes: within 1 % of μW of the splines, also with reversed creepages and beyond full sliding."""
    assert call("table", "query", CIRCLE, "--csv", tmp_path / "forces.csv").returncode == 0
    program = tmp_path / "creep_forces"
    subprocess.run(["cc", "-O1", "-Wall", "-Wextra", "-Werror", "-o", program, ROOT / "docs/readers/creep_forces.c", "-lm"],
                   check=True)
    table, random = CreepForceTable.read(CIRCLE), np.random.default_rng(3)
    creepages = random.normal(size=(12, 3)) * 10.0 ** random.uniform(-1.5, 1.0, (12, 1))
    for creepage in [*creepages.tolist(), [0.0, 0.0, 0.0], [1e3, 0.0, 0.0]]:
        done = subprocess.run([program, tmp_path / "forces.csv", "1", *map(repr, creepage)], capture_output=True, text=True,
                              check=True)
        exact = table.forces(*creepage, semi_axes=(1.0, 1.0), shear_modulus=1.0, friction=1.0, load=1.0)
        found = [float(word) for word in done.stdout.split()]
        assert found[:3] == pytest.approx(
            [float(part) for part in (exact.force_x, exact.force_y, exact.spin_moment)], abs=1e-2)
        assert found[3] == pytest.approx(float(exact.stick_fraction), abs=0.05)


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("gfortran") is None, reason="no Fortran compiler")
def test_the_reader_in_fortran_interpolates_the_points_of_contact(tmp_path: Path) -> None:
    case = ROOT / "cases" / "manchester.toml"
    assert call("conicity", case, "--amplitude", "1:3:3", "--no-plots", "-o", tmp_path).returncode == 0
    program = tmp_path / "contact_points"
    subprocess.run(["gfortran", "-Wall", "-Werror", "-o", program, ROOT / "docs/readers/contact_points.f90"], check=True)
    with open(tmp_path / "manchester_contacts.csv", encoding="utf-8") as table:
        rows = [row for row in csv.DictReader(table) if row["side"] == "right"]
    names = [name for name in rows[0] if name not in ("lateral_shift_mm", "side")]
    shifts = np.array([float(row["lateral_shift_mm"]) for row in rows])
    for shift in (-1.03, 0.0, 2.57):
        done = subprocess.run([program, tmp_path / "manchester_contacts.csv", "right", str(shift)], capture_output=True,
                              text=True, check=True)
        expected = [np.interp(shift, shifts, [float(row[name] or "nan") for row in rows]) for name in names]
        np.testing.assert_allclose([float(word) for word in done.stdout.split()], expected, rtol=1e-6, atol=1e-6)
