"""CONTACT (github.com/eve70a/CONTACT) beside this program, in turn: the cost of the same error of the creep forces.

CONTACT solves with GDsteady (G = 5) in the setting that was the fastest of twelve tried on these cases. The rolling direction
is CHI = 0: with 180 degrees CONTACT silently uses another solver. Our material flows along +x, so creepages have opposite signs
there; forces then have the same.
"""

from __future__ import annotations

import pathlib
import statistics
import sys
import tempfile
from functools import partial
from typing import Any

import numpy as np

from scripts.benchmark.cases import FORCES, ROOT, errors, log, problem_of, process, references, seconds
from thermoroll_cli.problem.problem import Problem
from thermoroll_cli.python_api import solve

CASES = tuple(f"article_3_1_case_{k}" for k in (1, 2, 3, 5))
CONTACT_GRIDS = (32, 64, 128, 256)
GRIDS = (16, 32, 64, 128, 256)
EXTRAPOLATED = "64 and 128, extrapolated"

INPUT = """ 3 MODULE
 203100    P-B-T-N-F-S
 022020    L-D-C-M-Z-E
 050{matrix}111   H-G-I-A-O-W-R
 999 100 30 1 1e-5   MAXGS, MAXIN, MAXNR, MAXOUT, EPS
 1.0 0.1 1 1 0 1 3 1   F_DECAY, BETATH, KDOWFB, D_IFC, D_LIN, D_CNS, D_SLP, POW_S
 {load} {creepage_x} {creepage_y} {spin}   FN, CKSI, CETA, CPHI
 {friction} {friction}   FSTAT, FKIN
 0.0 1.0 {speed}   CHI, DQ, VELOC
 {poisson} {poisson} {shear_modulus} {shear_modulus}   POISS 1,2, GG 1,2
 -1   IPOTCN
 {grid} {grid} {curvature} {curvature} 1.1   MX, MY, A1, B1, SCALE
 0 MODULE
"""
"""Input in mm, N, MPa; `matrix` = 1 writes the fields to a file."""


def contact_input(problem: Problem, grid: int, fields: bool) -> str:
    """CONTACT's input for two equal spheres of one material, isothermal, on `grid` elements per side."""
    motion, material = problem.motion, problem.lower
    return INPUT.format(
        matrix=int(fields), load=problem.normal_force, friction=problem.friction.coefficient,
        speed=1e3 * motion.speed, grid=grid, creepage_x=-motion.creepage_x, creepage_y=-motion.creepage_y,
        spin=motion.spin * 1e-3, poisson=material.poisson_ratio,
        shear_modulus=material.youngs_modulus / (2.0 + 2.0 * material.poisson_ratio) * 1e-6,
        curvature=0.5e-3 * problem.geometry.curvature_x)


def run_contact(program: str, problem: Problem, grid: int, fields: bool = False) -> tuple[float, dict[str, float]]:
    """Processor seconds of CONTACT's process, and with `fields` its forces in N, from the tractions that it writes."""
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        (folder / "case.inp").write_text(contact_input(problem, grid, fields))
        taken = process([program, "2", "case"], folder).seconds
        if "ERROR" in (text := (folder / "case.out").read_text()):
            raise RuntimeError(f"CONTACT: {text[-500:]}")
        if not fields:
            return taken, {}
        lines = (folder / "case.0001.mat").read_text().splitlines()
        size = next(lines[k + 1].split() for k, line in enumerate(lines) if line.startswith("%   MX"))
        start = next(k for k, line in enumerate(lines) if line.startswith("%    I    IGS"))
        rows = np.array([[float(cell) for cell in line.split()[:7]] for line in lines[start + 1:]])
        area = float(size[4]) * float(size[5])
        return taken, {name: float(rows[:, 5 + k].sum()) * area for k, name in enumerate(FORCES)}


def against_contact(program: str, runs: int) -> dict[str, Any]:
    """For each case: seconds of CONTACT's process, of our solve and of our process by grid, medians over runs in turn, and
    errors of the forces over μW."""
    command = str(pathlib.Path(sys.executable).parent / "thermoroll")
    out: dict[str, Any] = {}
    for case in CASES:
        fine, limit = references()[case], problem_of(case, 16).traction_limit
        forces = {n: run_contact(program, problem_of(case, n), n, fields=True)[1] for n in CONTACT_GRIDS}
        forces[EXTRAPOLATED] = {k: 2.0 * forces[128][k] - forces[64][k] for k in FORCES}  # first order: the error halves
        found: dict[str, dict[Any, list[float]]] = {"contact": {}, "solve": {}, "process": {}}
        own_error = {n: errors(solve(problem_of(case, n)).coupled.scalars, fine, limit)["forces"] for n in GRIDS}
        with tempfile.TemporaryDirectory() as folder:
            for run in range(runs):
                for n in GRIDS:
                    problem = problem_of(case, n)
                    if n in CONTACT_GRIDS and (n < 256 or run == 0):
                        found["contact"].setdefault(n, []).append(run_contact(program, problem, n)[0])
                    found["solve"].setdefault(n, []).append(seconds(partial(solve, problem)))
                    words = [command, "run", str(ROOT / "cases" / f"{case}.toml"), "--no-plots", "--quiet", "-o", folder,
                             "--set", f"numerics.grid={n}"]
                    found["process"].setdefault(n, []).append(process(words).seconds)
        medians = {kind: {str(n): statistics.median(values) for n, values in by.items()} for kind, by in found.items()}
        medians["contact"][EXTRAPOLATED] = medians["contact"]["64"] + medians["contact"]["128"]
        out[case] = medians | {
            "contact_error": {str(n): errors(found, fine, limit)["forces"] for n, found in forces.items()},
            "error": {str(n): value for n, value in own_error.items()}}
        log(f"  {case}: {out[case]}")
    return out


def ratios(measured: dict[str, Any]) -> dict[str, list[dict[str, Any]]]:
    """By CONTACT's grid, for every case: our coarsest grid that is at least as accurate, and CONTACT's seconds over those of
    our solve and over those of our whole process there."""
    out: dict[str, list[dict[str, Any]]] = {}
    for case, values in measured.items():
        for grid, taken in values["contact"].items():
            error = values["contact_error"][grid]
            own = next((n for n, e in values["error"].items() if e <= error), None)
            if own is None:
                raise ValueError(f"{case}: no grid of ours is as accurate as CONTACT at {grid}")
            out.setdefault(grid, []).append({
                "case": case, "contact_seconds": taken, "contact_error": error, "N": int(own), "error": values["error"][own],
                "solve": taken / values["solve"][own], "process": taken / values["process"][own]})
    return out
