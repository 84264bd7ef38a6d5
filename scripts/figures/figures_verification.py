"""The table of docs/verification.md: what is checked against what, and how large the difference is."""

from __future__ import annotations

import dataclasses
import json
import math
import pathlib
from typing import Any

import numpy as np

from scripts import closed_forms
from scripts.figures.figures_drawing import ROOT, Numbers, solve_problem, table
from scripts.figures.figures_numerics import problem_of
from thermoroll_cli.exact.cattaneo_mindlin import full_slip_displacement
from thermoroll_cli.exact.hertz import element_averages, hertz_contact
from thermoroll_cli.exact.moving_sources import rectangle_temperature
from thermoroll_cli.physics.halfspace.bodies import Bodies
from thermoroll_cli.physics.halfspace.elastic import ShearCompliance, rectangle_integrals
from thermoroll_cli.physics.halfspace.thermal import displacement_table, temperature_table
from thermoroll_cli.physics.halfspace.variable_peclet import variable_peclet_tables
from thermoroll_cli.physics.numerics.grid import Grid
from thermoroll_cli.physics.rolling.rolling_gradient import RollingGradient
from thermoroll_cli.problem.friction import Friction
from thermoroll_cli.problem.geometry import Geometry
from thermoroll_cli.problem.problem import Heating, Material, Motion, Numerics, Problem
from thermoroll_cli.problem.result import Result

Folder = pathlib.Path
Row = list[str]

REFERENCE = ROOT / "tests" / "reference"
SIDE = 128


def reference(name: str) -> Any:
    return json.loads((REFERENCE / f"{name}.json").read_text())


def verification(folder: Folder, grid: int) -> Numbers:
    """All rows; tests hold the same comparisons to bounds."""
    rows = [*_kernels(), *_tangential(), *_thermal(), *_whole()]
    return {"table": table(["quantity", "against", "difference", "test"], rows)}


def closed(folder: Folder, grid: int) -> Numbers:
    """The table of `python -m scripts.closed_forms`."""
    return {"table": table(closed_forms.HEADER, [list(check.row) for check in closed_forms.checks(64)])}


def _row(what: str, against: str, difference: str, test: str) -> Row:
    (path,) = (ROOT / "tests").rglob(f"{test}.py")
    return [what, against, difference, f"`{path.relative_to(ROOT).as_posix()}`"]


def _kernels() -> list[Row]:
    from scipy.integrate import dblquad

    i_xx, i_yy, i_xy = rectangle_integrals(4, 4, 1.0, 0.7)
    worst = 0.0
    for i, j in ((1, 0), (0, 2), (2, 1), (3, 3)):
        for table_, power in ((i_xx, (2, 0)), (i_yy, (0, 2)), (i_xy, (1, 1))):
            value, _ = dblquad(lambda y, x, p=power: x ** p[0] * y ** p[1] / math.hypot(x, y) ** 3,
                               i - 0.5, i + 0.5, 0.7 * (j - 0.5), 0.7 * (j + 0.5), epsabs=1e-12)
            worst = max(worst, abs(float(table_[i, j]) - value))
    rows = [_row("Love's and Cerruti's influence coefficients", "adaptive quadrature of the point solutions",
                 f"{worst:.0e} (absolute; the largest is {i_xx[0, 0] + i_yy[0, 0]:.1f})", "test_elastic_kernels")]
    entries = reference("thermal_kernel")["entries"]
    for words, key, make in (("temperature", "T", temperature_table), ("expansion", "U", displacement_table)):
        worst = 0.0
        for peclet in sorted({e["P"] for e in entries}):
            found = make(201, 51, 1.0, peclet)
            chosen = [e for e in entries if e["P"] == peclet]
            worst = max(worst, max(abs(found[200 + e["offset"][0], 50 + e["offset"][1]] - e[key]) for e in chosen)
                        / float(found[200, 50]))
        rows.append(_row(f"thermal influence coefficients, {words}, P = 0 … 1000", "independent quadratures, good to 1e-13",
                         f"{worst:.0e} of the element's own", "test_thermal_kernels"))
    return rows


def _tangential() -> list[Row]:
    rows = [_gradient()]
    contact = reference("contact_rolling")["cases"]
    worst = {"CONTACT": 0.0, "stick": 0.0, "heat": 0.0}
    for name, case in reference("rolling_fine")["cases"].items():
        given = case["input"]
        radius = given["radius_mm"] * 1e-3
        body = Material(given["youngs_modulus_GPa"] * 1e9, given["poisson_ratio"])
        motion = Motion(1.0, given["creepage_longitudinal"], given["creepage_lateral"], given["spin_rad_mm"] * 1e3,
                        differential_slip=False)
        problem = Problem(body, body, Geometry(radius, radius, radius, radius), given["normal_N"],
                          Friction(given["friction_coefficient"]), motion, Heating(False, False), Numerics((SIDE, SIDE)), name)
        s, limit = solve_problem(problem).coupled.scalars, problem.traction_limit
        theirs = contact[name]["extrapolated"]
        for axis in "xy":
            worst["CONTACT"] = max(worst["CONTACT"], abs(s[f"force_{axis}_N"] - theirs[f"force_{axis}_N"]) / limit)
        worst["stick"] = max(worst["stick"], abs(s["gamma_st"] - theirs["stick_fraction"]))
        worst["heat"] = max(worst["heat"], abs(s["Q_F_W"] / theirs["dissipation_from_forces_W"] - 1.0))
    return [
        *rows,
        _row("creep forces of seven isothermal cases over the friction limit, N = 128", "CONTACT, extrapolated, good to 1e-3",
             f"{worst['CONTACT']:.0e}", "test_tangential"),
        _row("stick fraction of the same", "CONTACT, extrapolated", f"{worst['stick']:.0e}", "test_tangential"),
        _row("dissipated heat of the same", "CONTACT, extrapolated", f"{worst['heat']:.0e}", "test_tangential"),
    ]


def _gradient() -> Row:
    hertz = hertz_contact(1.0 / 0.015, 1.0 / 0.015, 210e9 / (2.0 * (1.0 - 0.28**2)), 65.0)
    mesh = Grid.over((SIDE, SIDE), 2.2 * hertz.semi_axis_x, 2.2 * hertz.semi_axis_y)
    edges = [np.append(c - 0.5 * d, c[-1] + 0.5 * d) for c, d in ((mesh.x, mesh.dx), (mesh.y, mesh.dy))]
    traction = np.zeros((2, *mesh.shape))
    traction[0] = element_averages(hertz, *edges)[0]
    shear = 80e9
    operator = RollingGradient(mesh.shape, mesh.dx, mesh.dy, Bodies.of_shear(ShearCompliance.of((shear, 0.28), (shear, 0.28))))
    x = (np.arange(-2, mesh.nx + 2) - 0.5 * (mesh.nx - 1)) * mesh.dx
    exact = full_slip_displacement(x[:, None], mesh.y[None, :], hertz.semi_axis_x, hertz.peak_pressure, shear, 0.28)
    found = operator.displacement(traction)
    error = max(float(np.abs(found[i] - 2.0 * exact[i]).max()) for i in (0, 1)) / (2.0 * float(np.abs(exact[0]).max()))
    return _row("displacement by a sliding Hertz contact, N = 128", "Cattaneo–Mindlin, inside and outside",
                f"{error:.0e}", "test_tangential")


def _thermal() -> list[Row]:
    worst = 0.0
    for speed in (1.0, 18.8, 100.0):
        mesh = Grid.over((3 * 64, 64), 6.0, 2.0)
        flux = (np.abs(mesh.x) < 1.0).astype(float)
        kernel = temperature_table(mesh.nx, mesh.ny, 1.0, speed * mesh.dx)
        row = np.array([(kernel[mesh.nx - 1 + i - np.arange(mesh.nx)] * flux[:, None]).sum(axis=0) for i in range(mesh.nx)])
        line = np.array([row[i, mesh.ny - 1 - np.arange(mesh.ny) + mesh.ny // 2].sum() for i in range(mesh.nx)]) * mesh.dx
        exact = rectangle_temperature(mesh.x, 0.5 * mesh.dy, 1.0, 1.0, 1.0, 1.0, 1.0, speed)
        worst = max(worst, float(np.abs(line - exact).max() / exact.max()))
    rows = [_row("temperature under a moving square, Pe = 1, 18.8, 100", "integral of the point source, good to 1e-14",
                 f"{worst:.0e} of the largest", "test_heat")]
    random = np.random.default_rng(2)
    nx, ny, peclet_max = 24, 20, 2.0
    peclet = peclet_max * random.random((nx, ny)) ** 3
    flux = peclet * (0.5 + random.random((nx, ny)))
    kinds = (("temperature", "temperature", temperature_table), ("expansion", "displacement", displacement_table))
    for words, kind, make in kinds:
        exact, found = np.zeros((nx, ny)), np.zeros((nx, ny))
        tables, expansion = variable_peclet_tables(nx, ny, 1.0, peclet_max, kind, 1e-5)  # type: ignore[arg-type]
        weights, offset = expansion(peclet), expansion.offset(peclet)
        for i in range(nx):
            for j in range(ny):
                window = (slice(nx - 1 - i, 2 * nx - 1 - i), slice(ny - 1 - j, 2 * ny - 1 - j))
                exact += flux[i, j] * make(nx, ny, 1.0, float(peclet[i, j]))[window]
                table_ = np.tensordot(weights[:, i, j], tables[:, window[0], window[1]], axes=1)
                found += flux[i, j] * (table_ + offset[i, j])
        rows.append(_row(f"sliding Péclet numbers, {words}, {expansion.terms} terms", "one kernel per source element, summed",
                         f"{np.abs(found - exact).max() / np.abs(exact).max():.0e} of the largest", "test_sliding"))
    return rows


def _whole() -> list[Row]:
    hot = problem_of("article_4_1", 64)
    difference = _scaled(solve_problem(hot), hot)
    return [_row("lengths × 4, stresses / 128, κ × 8, coupled", "equal γ_p, γ_c, γ_st", f"{difference:.0e}", "test_forces")]


def _scaled(result: Result, problem: Problem) -> float:
    length, stress, diffusivity = 4.0, 2.0**-7, 8.0

    def body(b: Material) -> Material:
        assert b.conductivity is not None and b.diffusivity is not None
        return dataclasses.replace(b, youngs_modulus=b.youngs_modulus * stress, diffusivity=b.diffusivity * diffusivity,
                                   conductivity=b.conductivity * stress * diffusivity)

    g, m = problem.geometry, problem.motion
    radii = {f.name: value * length for f in dataclasses.fields(g) if (value := getattr(g, f.name)) is not None}
    other = solve_problem(dataclasses.replace(
        problem, lower=body(problem.lower), upper=body(problem.upper), geometry=Geometry(**radii),
        normal_force=problem.normal_force * length**2 * stress,
        motion=dataclasses.replace(m, speed=m.speed * diffusivity / length)))
    keys = ("gamma_p", "gamma_c", "gamma_st")
    return max(abs(other.coupled.scalars[k] / result.coupled.scalars[k] - 1.0) for k in keys)


FIGURES = {"verification": verification, "closed": closed}
