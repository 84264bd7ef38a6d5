"""Positions of the Manchester benchmark, one wheel whose roll and angular velocity are given: CONTACT (module 1) beside this
program, in turn. Both solve all positions one after the other in one process, without heat, each patch in its plane."""

from __future__ import annotations

import pathlib
import statistics
import tempfile
from functools import partial
from typing import Any

import numpy as np

from scripts import manchester
from scripts.benchmark.cases import ROOT, log, process, seconds
from thermoroll_cli.files.case import Case
from thermoroll_cli.many_contacts.wheelset.wheelset_problem import WheelsetProblem
from thermoroll_cli.many_contacts.wheelset.wheelset_result import WheelsetSolver
from thermoroll_cli.physics.contact.contact_scales import contact_scales
from thermoroll_cli.problem.result import Result

SHIFTS = tuple(shift for shift in manchester.SHIFTS if shift != 5.0)
"""At 5 mm CONTACT puts two patches into one plane, another model."""
STEPS = (0.4, 0.2, 0.1)
"""Sides of CONTACT's elements in mm; its own example has 0.2 mm."""
GRIDS = (16, 32, 64)
FINE = 128
"""Our grid from which all forces are counted."""

FIRST = """ 1 MODULE
 1203100    C-P-B-T-N-F-S
 0022033    V-L-D-C-M-Z-E
 0000321    H-G-I-A-O-W-R
 999 100 30 1 1e-5   MAXGS, MAXIN, MAXNR, MAXOUT, EPS
 0.3 0.3   FSTAT, FKIN
 0.28 0.28 82000. 82000.   POISS 1,2, GG 1,2
 {step} {step} 1.0 90d 8.0 4.0   DX, DS, DQREL, A_SEP, D_SEP, D_COMB
 14.0 0 1435.0 0.0   GAUGHT, GAUGSQ, GAUGWD, CANT
 'MBench_UIC60_v3.prr' 0 1.0 0.0   RFNAME, MIRRORY, SCALE, SMOOTH
 0.0 0.0 0.0 0.0 0.0 0.0   DY, DZ, ROLL, VY, VZ, VROLL
 1360.0 -70.0 460.0   FBDIST, FBPOS, NOMRAD
 'MBench_S1002_v3.prw' 0 1.0 0.0   WFNAME, MIRRORY, SCALE, SMOOTH
"""
NEXT = """ 1 MODULE
 1203100    C-P-B-T-N-F-S
 0111002    V-L-D-C-M-Z-E
 0100321    H-G-I-A-O-W-R
"""
POSITION = """ 0.0 {y} 10000. {roll} {yaw} 0.0   S, Y, FZ, ROLL, YAW, PITCH
 2000. 0.0 0.0 0.0 0.0 {omega}   VS, VY, VZ, VROLL, VYAW, VPITCH
"""


def positions() -> list[dict[str, Any]]:
    """CONTACT's inputs of the right wheel at each displacement."""
    return [manchester.contact_results()["right", shift]["input"] for shift in SHIFTS]


def run_contact(program: str, step: float) -> tuple[float, Any]:
    """Processor seconds of CONTACT's process, and the forces on the rail in N, (positions, 3), in track axes."""
    text = "".join((NEXT if k else FIRST.format(step=step)) + POSITION.format(**given) for k, given in enumerate(positions()))
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for profile in ("MBench_UIC60_v3.prr", "MBench_S1002_v3.prw"):
            (folder / profile).write_bytes((ROOT / "cases" / profile).read_bytes())
        (folder / "case.inp").write_text(text + " 0 MODULE\n")
        taken = process([program, "2", "case"], folder).seconds
        lines = (folder / "case.out").read_text().splitlines()
    found = [[float(word) for word in lines[k + 1].split()[:3]] for k, line in enumerate(lines) if "FX(TR)" in line]
    if len(found) != len(SHIFTS):
        raise RuntimeError(f"CONTACT: {len(found)} of {len(SHIFTS)} positions: {lines[-5:]}")
    return taken, np.array(found)


def problems(grid: int) -> list[WheelsetProblem]:
    """The same positions here."""
    case = Case.read(ROOT / "cases" / "manchester.toml").with_values({
        "wheelset.wheels": "right", "wheelset.vertical_N": 10e3, "wheelset.patches": "planar", "thermal.heat": False,
        "numerics.grid": [grid, grid]})
    return [case.with_values({
        "wheelset.lateral_shift_mm": given["y"], "wheelset.roll_mrad": 1e3 * given["roll"],
        "wheelset.yaw_mrad": 1e3 * given["yaw"], "wheelset.angular_velocity_rad_s": -given["omega"]}).task
        for given in positions()]


def in_order(wheelsets: list[WheelsetProblem]) -> list[Result]:
    contact_scales.cache_clear()
    solver = WheelsetSolver()
    return [solver.solve(wheelset) for wheelset in wheelsets]


def against_contact(program: str, runs: int) -> list[dict[str, Any]]:
    """Milliseconds of a position by program and grid, medians over runs in turn, and the largest difference of a force from
    ours on the fine grid, over the load."""
    def forces(results: list[Result]) -> Any:
        return np.array([[result.scalars[f"track_force_{axis}_N"] for axis in "xyz"] for result in results])

    fine, ours = forces(in_order(problems(FINE))), {grid: problems(grid) for grid in GRIDS}
    found = {f"CONTACT, {step} mm": run_contact(program, step)[1] for step in STEPS}
    found |= {f"thermoroll, N = {grid}": forces(in_order(each)) for grid, each in ours.items()}
    taken: dict[str, list[float]] = {name: [] for name in found}
    for _ in range(runs):
        for step in STEPS:
            taken[f"CONTACT, {step} mm"].append(run_contact(program, step)[0])
        for grid, each in ours.items():
            taken[f"thermoroll, N = {grid}"].append(seconds(partial(in_order, each)))
    out = [{"name": name, "ms": 1e3 * statistics.median(taken[name]) / len(SHIFTS),
            "difference": float(np.abs(found[name] - fine).max()) / 10e3} for name in found]
    log(f"  {out}")
    return out
