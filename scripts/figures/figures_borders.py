"""What each treatment of borders inside elements is worth: errors against N with and without it."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from scripts.figures.figures_drawing import COUPLED, DASHED, ISOTHERMAL, THIRD, Numbers, diagrams, letter, rounded, write
from scripts.figures.figures_numerics import REFERENCE_SIDE, SIDES, Folder, against_sides, problem_of
from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.one_contact.steady_state.discretisation import Discretisation, SolverOptions
from thermoroll_cli.one_contact.steady_state.scalars import STICK
from thermoroll_cli.physics.rolling.rolling_gradient import RollingOptions
from thermoroll_cli.problem.result import Result
from thermoroll_cli.python_api import Solver

CASES = tuple(f"article_3_1_case_{k}" for k in (1, 2, 3, 4, 5))
VARIANTS = (("whole elements", "0.45", DASHED), ("covered fractions", THIRD, "-"),
            ("tractions at the leading edge known", ISOTHERMAL, "-"))
TREATMENTS = (RollingOptions(smallest_cover=1.0, deepest=math.inf), RollingOptions(deepest=math.inf), RollingOptions())


def _mechanical() -> tuple[list[list[float]], list[list[float]]]:
    """Root mean squares over the cases of Sec. 3.1: of the creep force's error over μW, summed over one grid, per variant and
    side; and of the stick fraction's, where its border lies between elements and where it is located inside them."""
    forces = np.zeros((len(VARIANTS), len(SIDES)))
    sticks = np.zeros((2, len(SIDES)))
    for case in CASES:
        best = Solver().solve(problem_of(case, REFERENCE_SIDE)).coupled.scalars
        for k, n in enumerate(SIDES):
            problem = problem_of(case, n)
            for v, rolling in enumerate(TREATMENTS):
                result = Solver(options=SolverOptions(rolling=rolling)).solve(problem)
                fields, area = result.coupled.fields, (result.x[1] - result.x[0]) * (result.y[1] - result.y[0])
                error = [float(fields[f"shear_{i}"].sum()) * area - best[f"force_{i}_N"] for i in "xy"]
                forces[v, k] += float(np.dot(error, error)) / problem.traction_limit**2
            s = result.coupled.scalars
            covered = Discretisation(DerivedQuantities(problem), (n, n), problem.numerics.extent).isothermal_pressure.covered
            whole = float(covered[fields["state"] == STICK].sum() / covered.sum())
            sticks[:, k] += [(whole - best["gamma_st"]) ** 2, (s["gamma_st"] - best["gamma_st"]) ** 2]
    return np.sqrt(forces / len(CASES)).tolist(), np.sqrt(sticks / len(CASES)).tolist()


def _whole_area(result: Result) -> float:
    """Contact area over Hertz's where whole elements are counted."""
    problem, fields = result.problem, result.coupled.fields
    discretisation = Discretisation(DerivedQuantities(problem), (len(result.x), len(result.y)), problem.numerics.extent)
    gap = discretisation.pressure.undeformed_gap - fields["displacement_thermal"]
    contact = discretisation.pressure.solver.solve(gap, problem.normal_force, fields["pressure"], 1e-8).contact
    return np.count_nonzero(contact) * discretisation.grid.element_area / discretisation.derived.hertz.area


def borders(folder: Folder, grid: int) -> Numbers:
    """Forces and stick area of the mechanical cases, contact area of the hot one."""
    figure, axes = diagrams(1, 3, (1.75, 2.0), gap=(0.66, 0.0), bottom=0.75)
    forces, sticks = _mechanical()
    for errors, (_, colour, line) in zip(forces, VARIANTS, strict=True):
        _curve(axes[0], errors, colour, line)
    runs = {n: Solver().solve(problem_of("article_4_1", n)) for n in (*SIDES, REFERENCE_SIDE)}
    best = runs[REFERENCE_SIDE].coupled.scalars["gamma_c"]
    _curve(axes[1], [abs(_whole_area(runs[n]) - best) for n in SIDES], *VARIANTS[0][1:])
    _curve(axes[1], [abs(runs[n].coupled.scalars["gamma_c"] - best) for n in SIDES], COUPLED, "-")
    for errors, look in zip(sticks, (VARIANTS[0][1:], (COUPLED, "-")), strict=True):
        _curve(axes[2], errors, *look)
    labels = (r"error of the creep force / $\mu W$", "error of $γ_c$, hot contact", "error of $γ_{st}$")
    for ax, mark, label in zip(axes, "abc", labels, strict=True):
        against_sides(ax, label)
        letter(ax, f"({mark})", right=True)
    handles = [Line2D([], [], color=c, linestyle=s, marker="o", markersize=2.5, label=label) for label, c, s in VARIANTS]
    handles.append(Line2D([], [], color=COUPLED, marker="o", markersize=2.5, label="border located inside its elements"))
    figure.legend(handles=handles, loc="lower center", ncols=2, handlelength=2.4, columnspacing=1.2, borderpad=0.1)
    write(figure, folder, "borders")
    return {"forces": [[rounded(e, 2) for e in v] for v in forces], "stick": [[rounded(e, 2) for e in v] for v in sticks]}


def _curve(ax: Axes, errors: list[float], colour: str, line: object) -> None:
    ax.loglog(SIDES, errors, color=colour, linestyle=line, marker="o", markersize=2.5)


FIGURES = {"borders": borders}
