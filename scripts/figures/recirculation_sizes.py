"""The table of docs/physics.md: what heat that comes back amounts to in real cases, solved with and without it.

    python -m scripts.figures.recirculation_sizes
"""

from __future__ import annotations

import math
from dataclasses import replace

from thermoroll_cli.problem.problem import Geometry, Heating, Material, Motion, Numerics, Problem, Recirculation
from thermoroll_cli.problem.result import Result
from thermoroll_cli.refinement.solve import solve

STEEL = Material(210e9, 0.3, 45.0, 12e-6, 12e-6)
ARTICLE = Material(210e9, 0.28, 50.2, 11.7e-6, 10e-6)
PEEK = Material(3.6e9, 0.38, 0.25, 47e-6, 0.15e-6)
GRID = Numerics(grid=(96, 96))
FLAT = math.inf


def _problem(
    body: Material, radii: tuple[float, float, float, float], load: float, friction: float, motion: Motion,
    tracks: tuple[Recirculation | None, Recirculation | None],
) -> Problem:
    heating = Heating(partition="matched", lower_track=tracks[0], upper_track=tracks[1])
    return Problem(body, body, Geometry(*radii), load, friction, motion, heating, GRID)


def _alike(track: Recirculation) -> tuple[Recirculation, Recirculation]:
    return track, track


CASES = {
    "wheel on rail, 2 % slip, h = 30": _problem(
        replace(STEEL, conductivity=50.0, diffusivity=13e-6), (FLAT, 0.3, 0.46, FLAT), 100e3, 0.3, Motion(30.0, 0.02),
        (None, Recirculation(0.135, convection=30.0))),
    "ball (upper, h = 500) in a race of 9 balls (1 K/W)": _problem(
        STEEL, (0.022, -0.0066, 0.00635, 0.00635), 300.0, 0.1, Motion(5.0, 0.0067),
        (Recirculation(0.01, 9, resistance=1.0), Recirculation(0.0127, convection=500.0))),
    "traction drive, 30 mm, h = 3000": _problem(
        STEEL, (0.03, 0.03, 0.03, 0.03), 1500.0, 0.08, Motion(30.0, 1.0 / 3.6), _alike(Recirculation(0.02, convection=3000.0))),
    "twin disc, 4 K/W": _problem(
        ARTICLE, (0.0235, FLAT, 0.0235, 0.2), 1500.0, 0.4, Motion(3.0, 0.02), _alike(Recirculation(0.01, resistance=4.0))),
    "PEEK on PEEK, 5 % slip, h = 50": _problem(
        PEEK, (0.02, FLAT, 0.02, 0.1), 100.0, 0.4, Motion(0.5, 0.05), _alike(Recirculation(0.01, convection=50.0))),
    "the article's spheres at 1 m/s, h = 20": _problem(
        ARTICLE, (0.03, 0.03, 0.03, 0.03), 65.0, 0.3, Motion(1.0, 0.003), _alike(Recirculation(0.06, convection=20.0))),
    "the article's spheres at 200 m/s, h = 200": _problem(
        ARTICLE, (0.03, 0.03, 0.03, 0.03), 65.0, 0.3, Motion(200.0, 0.003),
        _alike(Recirculation(0.06, convection=200.0))),
}


def row(name: str, problem: Problem) -> str:
    """One line of the table. Raises RuntimeError if a case does not converge."""
    passing = replace(problem, heating=replace(problem.heating, lower_track=None, upper_track=None))
    once, back = _solved(name, passing), _solved(name, problem)
    s, o = back.coupled.scalars, once.coupled.scalars
    hottest, before = (max(t["temperature_rise_max_lower_K"], t["temperature_rise_max_upper_K"]) for t in (s, o))
    bulge, crown = 1e-6 * o["thermal_displacement_max_um"], 1e-6 * s["recirculation_bulge_um"]
    approach = 1e-6 * s["approach_um"]
    bulk = " / ".join(f"{s[f'bulk_temperature_{body}_K']:.3g}" for body in ("lower", "upper"))
    return (f"| {name} | {s['Q_F_W']:.3g} | {before:.3g} → {hottest:.3g} | {bulk} | {100.0 * s['partition_mean']:.0f} | "
            f"{bulge / approach:.1g}; {crown / approach:.1g} | {s['thermal_crown_ratio']:.1g} | "
            f"{s['gamma_p'] - o['gamma_p']:+.4f} |")


def _solved(name: str, problem: Problem) -> Result:
    result = solve(problem)
    if not result.converged:
        raise RuntimeError(f"{name}: {result.reason}")
    return result


def main() -> None:
    print("| case | Q_F (W) | T_max, one pass → turning (K) | bulk lower / upper (K) | share of lower (%) | "
          "bulge/approach: pass; track | Λ | change of γ_p |")
    print("|---|---|---|---|---|---|---|---|")
    for name, problem in CASES.items():
        print(row(name, problem))


if __name__ == "__main__":
    main()
