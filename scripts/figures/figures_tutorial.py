"""The creep curve of docs/tutorial.md, and the output of its commands."""

from __future__ import annotations

import os
import pathlib
import re
import subprocess
import sys
import tempfile

import numpy as np

from scripts.figures.figures_drawing import COUPLED, DASHED, ISOTHERMAL, Numbers, diagrams, letter, rounded, write
from scripts.figures.figures_numerics import problem_of
from thermoroll_cli.exact.kalker import creepage_coefficients
from thermoroll_cli.plots.style import few_ticks
from thermoroll_cli.problem.problem import Problem
from thermoroll_cli.refinement.solve import Solver

CREEPAGES = np.geomspace(1e-4, 1e-2, 20)


def creep_curve(folder: pathlib.Path, grid: int) -> Numbers:
    """Longitudinal force and stick area against creepage, with the line that Kalker's coefficient gives."""
    solver = Solver()
    results = [solver.solve(_at(float(c))) for c in CREEPAGES]
    problem, hertz = results[0].problem, results[0].hertz
    force = np.array([r.coupled.scalars["force_x_N"] for r in results]) / problem.traction_limit
    stick = [r.coupled.scalars["gamma_st"] for r in results]
    area = hertz["hertz_a_mm"] * hertz["hertz_b_mm"] * 1e-6
    c11 = creepage_coefficients(hertz["hertz_a_mm"] / hertz["hertz_b_mm"], problem.lower.poisson_ratio).c11
    slope = problem.lower.shear_modulus * area * c11 / problem.traction_limit
    figure, (left, right) = diagrams(1, 2, (2.75, 1.9))
    left.plot(CREEPAGES, force, "o-", color=ISOTHERMAL, markersize=2.5, label="thermoroll")
    left.plot(CREEPAGES, slope * CREEPAGES, color="0.45", linestyle=DASHED, linewidth=0.9, label="no slip (Kalker)")
    left.set_ylim(0.0, 1.05)
    left.set_ylabel(r"$F_x/\mu W$")
    left.legend(loc="lower right")
    right.plot(CREEPAGES, stick, "o-", color=COUPLED, markersize=2.5)
    right.set_ylim(0.0, 1.05)
    right.set_ylabel(r"$\gamma_{st}$")
    for axes, mark in ((left, "(a)"), (right, "(b)")):
        axes.set_xscale("log")
        axes.set_xlabel(r"creepage $\xi_x$", labelpad=2.0)
        few_ticks(axes, y=5)
        letter(axes, mark, right=axes is right)
    write(figure, folder, "creep_curve")
    return {"creepage": [rounded(float(c)) for c in CREEPAGES], "force_over_limit": [rounded(float(f)) for f in force],
            "kalker_slope": rounded(slope)}


def _at(creepage: float) -> Problem:
    return problem_of("article_4_1", 64, **{"thermal.heat": False, "creepage.longitudinal": creepage})


BLOCK = re.compile(r"(```console\n)(.*?)(```)", re.DOTALL)


def run_commands(document: pathlib.Path) -> None:
    """Run the commands of all ```console blocks (lines that begin with `$ `) in one empty folder and put in what they print."""
    text = document.read_text(encoding="utf-8")
    with tempfile.TemporaryDirectory() as folder:
        ran = BLOCK.sub(lambda block: block[1] + _session(block[2], folder) + block[3], text)
    if ran != text:
        document.write_text(ran, encoding="utf-8")


def _session(block: str, folder: str) -> str:
    commands = [line[2:] for line in block.splitlines() if line.startswith("$ ")]
    path = os.pathsep.join([str(pathlib.Path(sys.executable).parent), os.environ.get("PATH", "")])
    environment = {**os.environ, "PATH": path, "COLUMNS": "120", "NO_COLOR": "1"}
    printed = []
    for command in commands:
        done = subprocess.run(["bash", "-c", command], cwd=folder, env=environment, stdout=subprocess.PIPE,
                              stderr=subprocess.DEVNULL, text=True, check=False)
        printed.append(f"$ {command}\n{done.stdout}")
    return "".join(printed)


FIGURES = {"creep curve": creep_curve}
