"""The table of docs/physics.md on recirculating heat: real cases, solved with and without it."""

from __future__ import annotations

import math
import pathlib
from dataclasses import replace

from scripts.figures.figures_drawing import Numbers, solve_problem, table
from thermoroll_cli.problem.friction import Friction
from thermoroll_cli.problem.geometry import Geometry
from thermoroll_cli.problem.problem import Heating, Material, Motion, Numerics, Problem, ReturningTrack

HEADER = ("case (`partition = \"matched\"`)", "Q_F (W)", "T_max, one pass → recirculating (K)", "bulk lower / upper (K)",
          "share of lower (%)", "bulge/approach: pass; track", "Λ", "change of γ_p")
STEEL = Material(210e9, 0.3, 45.0, 12e-6, 12e-6)
ARTICLE = Material(210e9, 0.28, 50.2, 11.7e-6, 10e-6)
PEEK = Material(3.6e9, 0.38, 0.25, 47e-6, 0.15e-6)
GRID = Numerics(grid=(96, 96))
FLAT = math.inf


def _problem(
    body: Material, radii: tuple[float, float, float, float], load: float, friction: float, motion: Motion,
    tracks: tuple[ReturningTrack | None, ReturningTrack | None],
) -> Problem:
    heating = Heating(partition="matched", lower_track=tracks[0], upper_track=tracks[1])
    return Problem(body, body, Geometry(*radii), load, Friction(friction), motion, heating, GRID)


def _alike(track: ReturningTrack) -> tuple[ReturningTrack, ReturningTrack]:
    return track, track


CASES = {
    "wheel on rail, 2 % slip, h = 30": _problem(
        replace(STEEL, conductivity=50.0, diffusivity=13e-6), (FLAT, 0.3, 0.46, FLAT), 100e3, 0.3, Motion(30.0, 0.02),
        (None, ReturningTrack(0.135, convection=30.0))),
    "PEEK on PEEK, 5 % slip, h = 50": _problem(
        PEEK, (0.02, FLAT, 0.02, 0.1), 100.0, 0.4, Motion(0.5, 0.05), _alike(ReturningTrack(0.01, convection=50.0))),
    "the article's spheres at 1 m/s, h = 20": _problem(
        ARTICLE, (0.03, 0.03, 0.03, 0.03), 65.0, 0.3, Motion(1.0, 0.003), _alike(ReturningTrack(0.06, convection=20.0))),
    "the article's spheres at 200 m/s, h = 200": _problem(
        ARTICLE, (0.03, 0.03, 0.03, 0.03), 65.0, 0.3, Motion(200.0, 0.003),
        _alike(ReturningTrack(0.06, convection=200.0))),
}


def sizes(folder: pathlib.Path, grid: int) -> Numbers:
    """A line for each case."""
    return {"table": table(HEADER, [_row(name, problem) for name, problem in CASES.items()])}


def _row(name: str, problem: Problem) -> list[str]:
    passing = replace(problem, heating=replace(problem.heating, lower_track=None, upper_track=None))
    o, s = (solve_problem(each).coupled.scalars for each in (passing, problem))
    before, hottest = (max(t["temperature_rise_max_lower_K"], t["temperature_rise_max_upper_K"]) for t in (o, s))
    bulges = (f"{t / s['approach_um']:.1g}" for t in (o["thermal_displacement_max_um"], s["recirculation_bulge_um"]))
    return [name, f"{s['Q_F_W']:.3g}", f"{before:.3g} → {hottest:.3g}",
            " / ".join(f"{s[f'bulk_temperature_{body}_K']:.3g}" for body in ("lower", "upper")),
            f"{100.0 * s['partition_mean']:.0f}", "; ".join(bulges), f"{s['thermal_crown_ratio']:.1g}",
            f"{s['gamma_p'] - o['gamma_p']:+.4f}"]


FIGURES = {"recirculation": sizes}
