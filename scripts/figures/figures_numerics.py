"""What docs/numerics.md states: errors and work of each algorithm, measured, and the figure of convergence."""

from __future__ import annotations

import dataclasses
import json
import math
import pathlib
import time
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from scripts.figures.figures_drawing import (
    COUPLED,
    DASHED,
    ISOTHERMAL,
    ROOT,
    Numbers,
    diagrams,
    letter,
    table,
    write,
)
from tests.support.errors import relative
from thermoroll_cli import Case
from thermoroll_cli.exact.hertz import element_averages, hertz_contact, line_contact
from thermoroll_cli.exact.rolling_cylinders import carter, saturation_creepage
from thermoroll_cli.one_contact.steady_state.discretisation import SolverOptions
from thermoroll_cli.physics.contact.normal_contact import NormalSolver
from thermoroll_cli.physics.halfspace.bodies import Bodies
from thermoroll_cli.physics.halfspace.elastic import ShearCompliance
from thermoroll_cli.physics.numerics.grid import UPSTREAM_WEIGHTS, Grid
from thermoroll_cli.physics.rolling.newton import TangentialProblem
from thermoroll_cli.physics.rolling.rolling_gradient import RollingGradient, RollingOptions
from thermoroll_cli.physics.rolling.rolling_solver import RollingSolver
from thermoroll_cli.problem.problem import Numerics, Problem
from thermoroll_cli.python_api import Solver

Folder = pathlib.Path
Rows = list[list[str]]

REFERENCE = ROOT / "tests" / "reference"


def problem_of(name: str, grid: int, **changes: Any) -> Problem:
    case = Case.read(ROOT / "cases" / f"{name}.toml")
    problem = (case.with_values(changes) if changes else case).problem
    return dataclasses.replace(problem, numerics=Numerics(grid=(grid, grid), extent=problem.numerics.extent))


# --- normal contact --------------------------------------------------------------------------------------------------


def normal(folder: Folder, grid: int) -> Numbers:
    """Errors against Hertz of the border on whole elements and inside elements, and the iterations they take."""
    rows: Rows = []
    curvature, modulus, force = 1.0 / 0.015, 210e9 / (2.0 * (1.0 - 0.28**2)), 65.0
    for ratio in (1.0, 10.0):
        hertz = hertz_contact(curvature, curvature / ratio, modulus, force)
        for n in (32, 128):
            mesh = Grid.over((n, n), 2.2 * hertz.semi_axis_x, 2.2 * hertz.semi_axis_y)
            gap = hertz.undeformed_gap(mesh.x[:, None], mesh.y[None, :])
            edges = [np.append(c - 0.5 * d, c[-1] + 0.5 * d) for c, d in ((mesh.x, mesh.dx), (mesh.y, mesh.dy))]
            exact, _ = element_averages(hertz, *edges)
            solver = NormalSolver(mesh, Bodies(modulus))
            warm, cold = (solver.solve(gap, force, start) for start in (exact, np.zeros(mesh.shape)))
            refined = solver.refine(warm, gap, force)
            area = (np.count_nonzero(warm.contact) * mesh.element_area, float(refined.covered.sum()) * mesh.element_area)
            mean = [float(np.abs(p - exact).mean() / exact.mean()) for p in (warm.pressure, refined.pressure)]
            rows.append([f"{hertz.semi_axis_y / hertz.semi_axis_x:.1f}", str(n), f"{warm.pressure.max() / exact.max() - 1:.1e}",
                         f"{mean[0]:.1e}", f"{mean[1]:.1e}", *(f"{abs(a / hertz.area - 1):.1e}" for a in area),
                         f"{warm.iterations}", f"{cold.iterations}"])
    return {"table": table(["b0/a0", "N", "p_max", "mean p, whole elements", "mean p, border resolved", "area, whole elements",
                            "area, border resolved", "CG iterations from Hertz", "from nothing"], rows)}


# --- tangential contact ----------------------------------------------------------------------------------------------


FORCE_CASES = (("creepage alone (Sec. 4.1)", "article_4_1_mechanical", "table1", {"thermal.heat": False}),
               ("creepages and spin (Sec. 3.1, case 5)", "article_3_1_case_5", "article_3_1_case_5", {}))
SIDES = (16, 32, 64, 128, 256)
REFERENCE_SIDE = 512


@dataclasses.dataclass(frozen=True)
class Rolled:
    """Forces over μW as summed on the grid and as reported, heat over μWV, and the work on the finest grid."""

    summed: tuple[float, float]
    reported: tuple[float, float]
    heat: float
    power_error: float
    stick: float
    estimate: float
    applications: int
    seconds: float


def rolled(problem: Problem, rolling: RollingOptions | None = None) -> Rolled:
    options = SolverOptions(rolling=rolling or RollingOptions())
    Solver(options=options).solve(problem)  # plans of the transforms are made once per size
    start = time.process_time()
    result = Solver(options=options).solve(problem)
    seconds = time.process_time() - start
    limit, s = problem.traction_limit, result.coupled.scalars
    area = (result.x[1] - result.x[0]) * (result.y[1] - result.y[0])
    summed = [float(result.coupled.fields[f"shear_{axis}"].sum()) * area / limit for axis in "xy"]
    return Rolled((summed[0], summed[1]), (s["force_x_N"] / limit, s["force_y_N"] / limit),
                  s["Q_F_W"] / limit / problem.motion.speed, s["power_balance_error"], s["gamma_st"],
                  relative(result)["force_x_N"] * max(abs(s["force_x_N"]) / limit, 1.0),
                  result.work["levels"][-1]["applications"], seconds)


def against_sides(ax: Axes, label: str) -> None:
    """Dress axes on which `label` is drawn against N."""
    ax.set_xlabel("elements per side $N$", labelpad=2.0)
    ax.set_ylabel(label, labelpad=3.0)
    ax.set_xlim(13.0, 320.0)
    ax.set_xticks(list(SIDES), [str(n) for n in SIDES])
    ax.minorticks_off()


def forces(folder: Folder, grid: int) -> Numbers:
    """Creep forces and heat against N, with CONTACT's, and the figure of convergence."""
    contact = json.loads((REFERENCE / "contact_rolling.json").read_text())["cases"]
    figure, axes = diagrams(1, 3, (1.75, 2.0), gap=(0.66, 0.0), bottom=0.75)
    rows: Rows = []
    for (words, name, case, changes), colour in zip(FORCE_CASES, (ISOTHERMAL, COUPLED), strict=True):
        runs = {n: rolled(problem_of(case, n, **changes)) for n in (*SIDES, REFERENCE_SIDE)}
        best = runs[REFERENCE_SIDE]
        problem = problem_of(case, 16, **changes)
        limit = problem.traction_limit

        def error(values: tuple[float, float], best: Rolled = best) -> float:
            return math.hypot(values[0] - best.reported[0], values[1] - best.reported[1])

        theirs = {int(n): v for n, v in contact[name]["grids"].items()}
        their_errors = {n: error((v["force_x_N"] / limit, v["force_y_N"] / limit)) for n, v in theirs.items()}
        their_heat = {n: v["dissipation_from_forces_W"] / limit for n, v in theirs.items()}
        for n in (32, 64, 128, 256):
            r = runs[n]
            rows.append([words, str(n), f"{error(r.summed):.1e}", f"{error(r.reported):.1e}", f"{r.estimate:.1e}",
                         f"{r.heat / best.heat - 1:+.1e}", f"{r.power_error:.1e}", str(r.applications), f"{r.seconds:.2f}",
                         f"{their_errors[n]:.1e}" if n in their_errors else ""])
        sides = list(SIDES)
        axes[0].loglog(sides, [error(runs[n].summed) for n in sides], color=colour, marker="o", markersize=2.5)
        axes[0].loglog(sides, [error(runs[n].reported) for n in sides], color=colour, marker="o", markersize=2.5,
                       linestyle=DASHED)
        axes[0].loglog(list(their_errors), list(their_errors.values()), color=colour, marker="s", markersize=2.5, linewidth=0.7)
        axes[1].loglog(sides, [abs(runs[n].heat / best.heat - 1.0) for n in sides], color=colour, marker="o", markersize=2.5,
                       linestyle=DASHED)
        axes[1].loglog(sides, [runs[n].power_error for n in sides], color=colour, marker="o", markersize=2.5)
        axes[1].loglog(list(their_heat), [abs(q / best.heat - 1.0) for q in their_heat.values()], color=colour, marker="s",
                       markersize=2.5, linewidth=0.7)
        axes[2].semilogx(sides, [runs[n].applications for n in sides], color=colour, marker="o", markersize=2.5)
    guide = np.array([20.0, 90.0])
    axes[0].loglog(guide, 6e-3 * (guide / 20.0) ** -2, color="0.6", linewidth=0.8)
    axes[0].text(70, 6.5e-4, "$N^{-2}$", color="0.4")
    for ax, mark, label in zip(axes, "abc", ("error of the creep force / $\\mu W$", "error of the heat / $Q_F$",
                                            "applications on the finest grid"), strict=True):
        against_sides(ax, label)
        letter(ax, f"({mark})", right=True)
    axes[2].set_ylim(0.0, 60.0)
    handles = [
        *(Line2D([], [], color=c, label=w[0]) for w, c in zip(FORCE_CASES, (ISOTHERMAL, COUPLED), strict=True)),
        Line2D([], [], color="0.3", linestyle=DASHED, marker="o", markersize=2.5, label="reported (extrapolated)"),
        Line2D([], [], color="0.3", marker="o", markersize=2.5, label="(a) sum over the grid; (b) power balance"),
        Line2D([], [], color="0.3", marker="s", markersize=2.5, linewidth=0.7, label="CONTACT (recorded)"),
    ]
    figure.legend(handles=handles, loc="lower center", ncols=3, handlelength=2.4, columnspacing=1.2, borderpad=0.1)
    write(figure, folder, "convergence")
    header = ["case", "N", "error of the sum", "error as reported", "its estimate", "Q_F", "power balance", "applications",
              "CPU s", "CONTACT: error"]
    return {"table": table(header, rows)}


def border(folder: Folder, grid: int) -> Numbers:
    """Carter's strip with its border anywhere inside an element: whole elements against covered fractions."""
    cylinders = line_contact(20.0, 210e9 / (2.0 * (1.0 - 0.28**2)), 3e5)
    friction, shear = 0.3, 210e9 / 2.56
    exact = carter(cylinders, friction, 0.5 * saturation_creepage(cylinders, friction))
    bodies = Bodies.of_shear(ShearCompliance.of((shear, 0.28), (shear, 0.28)))
    limit = friction * cylinders.load_per_length
    rows: Rows = []
    for n in (32, 64, 128):
        dx, length = 2.2 * cylinders.half_width / n, 1e4 * cylinders.half_width
        errors: dict[bool, list[float]] = {True: [], False: []}
        for offset in np.arange(8) / 8.0:
            edges = (np.arange(n + 1) - 0.5 * n + offset) * dx / cylinders.half_width
            t = np.clip(edges, -1.0, 1.0)
            pressure = np.diff(t * np.sqrt(1.0 - t * t) + np.arcsin(t)) / np.diff(edges) * 0.5 * cylinders.peak_pressure
            covered = np.diff(t) / np.diff(edges)
            rigid = np.zeros((2, n, 1))
            rigid[0] = exact.creepage
            for resolved in (True, False):
                share = np.minimum(covered, 1.0) if resolved else (covered > 0.0).astype(float)
                cell = TangentialProblem(friction * pressure[:, None], share[:, None], rigid, dx * length)
                solution = RollingSolver(RollingGradient((n, 1), dx, length, bodies)).solve(cell, [], 1e-8)
                errors[resolved].append(float(solution.traction[0].sum()) * dx / limit - exact.force / limit)
        rows.append([str(n), *(f"{np.mean(errors[r]):+.1e} ± {np.std(errors[r]):.1e}" for r in (False, True))])
    return {"table": table(["N", "whole elements", "covered fractions"], rows)}


FORMULAS = (("(u_i − u_{i−1})/h", (0.0, -1.0, 1.0, 0.0)),
            ("(3u_i − 4u_{i−1} + u_{i−2})/2h", (0.5, -2.0, 1.5, 0.0)),
            ("(2u_{i+1} + 3u_i − 6u_{i−1} + u_{i−2})/6h", (1.0 / 6.0, -1.0, 0.5, 1.0 / 3.0)),
            ("0.7 of the third + 0.3 of the second", UPSTREAM_WEIGHTS))


def differences(folder: Folder, grid: int) -> Numbers:
    """Force and heat with other formulas for ∂u/∂x."""
    base = {"creepage.longitudinal": 0.0016, "thermal.heat": False}
    best = rolled(problem_of("table1", REFERENCE_SIDE, **base))
    rows: Rows = []
    for words, weights in FORMULAS:
        row = [words]
        for n in (64, 128):
            r = rolled(problem_of("table1", n, **base), RollingOptions(difference_weights=weights))
            row += [f"{r.summed[0] - best.reported[0]:+.1e}", f"{-r.power_error:+.1e}"]
        rows.append(row)
    return {"table": table(["∂u/∂x at x_i", "F_x/μW, N = 64", "power balance", "F_x/μW, N = 128", "power balance"], rows)}


def leading(folder: Folder, grid: int) -> Numbers:
    """Lateral force of pure spin: K alone at the leading edge, and the known gradient there."""
    best = rolled(problem_of("article_3_1_case_3", REFERENCE_SIDE)).reported[1]
    rows: Rows = []
    for n in (32, 64, 128, 256):
        problem = problem_of("article_3_1_case_3", n)
        found = []
        # Nothing of the known gradient is taken where the deepest deficit counts as infinite.
        for options in (RollingOptions(deepest=math.inf), RollingOptions()):
            found.append(rolled(problem, options).summed[1] - best)
        rows.append([str(n), *(f"{value:+.1e}" for value in found)])
    return {"table": table(["N", "K alone", "gradient known"], rows)}


def coupling(folder: Folder, grid: int) -> Numbers:
    """Outer iterations of the fixed point against heat."""
    rows: Rows = []
    for speed in (25.0, 50.0, 100.0, 200.0, 400.0, 800.0):
        problem = problem_of("article_4_1", 64, **{"rolling.speed_m_s": speed})
        result = Solver().solve(problem)
        s, level = result.coupled.scalars, result.work["levels"][-1]
        bulge = s["thermal_displacement_max_um"] / result.isothermal.scalars["approach_um"]
        rows.append([f"{speed:g}", f"{bulge:.2f}", f"{s['gamma_p']:.3f}", f"{s['gamma_c']:.3f}",
                     str(level["coupling_iterations"]), str(level["coupled_normal_iterations"]),
                     str(level["coupled_applications"]), "yes" if result.converged else "no"])
    return {"heat": table(["V (m/s)", "bulge / approach", "γ_p", "γ_c", "outer iterations", "CG iterations", "applications",
                           "converged"], rows)}


FIGURES = {
    "normal": normal,
    "forces": forces,
    "border": border,
    "differences": differences,
    "leading": leading,
    "coupling": coupling,
}

