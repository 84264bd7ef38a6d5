"""Write tests/reference/estimate_references.json: random rolling cases and finely solved scalars for each.

    python -m scripts.references.estimate_references [--cases N] [--grid N]

The error estimates are tested for honesty on these cases. Each is solved with 128 and 256 (or N/2 and N) elements per side and
extrapolated, f256 + (f256 − f128)/3. Takes a few minutes.
"""

from __future__ import annotations

import argparse
import json
import math
import pathlib
import sys
from collections.abc import Iterable
from typing import Any

import numpy as np

from tests.support.problems import ellipse, on_grid
from thermoroll_cli.one_contact.refinement.error_estimates import EXTRAPOLATED
from thermoroll_cli.one_contact.refinement.expected_heat import bulge_bound
from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.problem.friction import Friction
from thermoroll_cli.problem.problem import Heating, Material, Motion, Problem
from thermoroll_cli.problem.result import Result
from thermoroll_cli.python_api import solve

ROOT = pathlib.Path(__file__).resolve().parents[2]
OUTPUT = ROOT / "tests" / "reference" / "estimate_references.json"
SEED = 5077
"""Another one than that of the cases with which the estimates were calibrated."""

ABOUT = (
    "Random rolling cases (equal bodies, E = 210 GPa, heated ones with k = 50.2 W/mK and 10 mm2/s) and their scalars from "
    "N = {coarse} and {fine}, f{fine} + (f{fine} - f{coarse})/3. "
    "Written by scripts/references/estimate_references.py."
)


SCALARS = ("Q_F_W", "force_x_N", "force_y_N", "gamma_c", "gamma_st", "gamma_p", "temperature_rise_max_lower_K",
           "temperature_rise_max_upper_K")
"""Scalars whose estimates are held against references."""


def problem_of(given: dict[str, Any], grid: int) -> Problem:
    """The problem of one entry's `input`: two equal bodies of E = 210 GPa, on a square grid."""
    heated = given["peclet"] is not None
    thermal = (50.2, given["expansion_1e6_K"] * 1e-6, 10e-6) if heated else (None, None, None)
    body = Material(210e9, given["poisson_ratio"], *thermal)
    motion = Motion(given["speed_m_s"], given["creepage_longitudinal"], given["creepage_lateral"], given["spin_rad_m"],
                    given["force_x_N"], given["force_y_N"], differential_slip=False)
    heating = Heating(peclet=given["peclet"], partition=given["partition"]) if heated else Heating(heat=False)
    geometry = ellipse(given["aspect_ratio"], given["radius_m"])
    return on_grid(Problem(body, body, geometry, given["normal_N"], Friction(given["friction"]), motion, heating), grid)


def scale_of(name: str, reference: float, traction_limit: float) -> float:
    """What an error is relative to: the value, for forces μW at least; stick fractions are absolute."""
    if name.startswith("force"):
        return max(abs(reference), traction_limit)
    return 1.0 if name == "gamma_st" else abs(reference)


def has_error(name: str, given: dict[str, Any], reference: float | None) -> bool:
    """Whether there is an error to estimate: not in what is prescribed, vanishes by symmetry or is known in closed form."""
    if reference is None or given.get(name) is not None:
        return False
    if name.startswith("force"):
        return abs(reference) > 1e-6 * given["friction"] * given["normal_N"]
    if name in ("gamma_c", "gamma_p"):
        return given["peclet"] is not None  # without heat the contact is that of Hertz
    return reference != 0.0


def draw(rng: np.random.Generator, index: int) -> dict[str, Any]:
    """Inputs of one case: every third is thermally coupled, every fifth has a prescribed force."""
    heated, forced = index % 3 == 2, index % 5 == 4
    given: dict[str, Any] = {
        "aspect_ratio": 1.0 if index % 2 == 0 else float(10.0 ** rng.uniform(-0.6, 0.6)),
        "radius_m": float(10.0 ** rng.uniform(-2.0, -0.5)),
        "poisson_ratio": float(rng.uniform(0.0, 0.45)),
        "normal_N": float(10.0 ** rng.uniform(1.0, 3.0)),
        "friction": float(rng.uniform(0.1, 0.6)),
        "speed_m_s": 1.0,
        "creepage_longitudinal": 0.0,
        "creepage_lateral": 0.0,
        "spin_rad_m": 0.0,
        "force_x_N": None,
        "force_y_N": None,
        "peclet": str(rng.choice(["stationary", "stationary", "sliding", "rolling"])) if heated else None,
        "partition": 0.5 if index % 2 == 0 else float(rng.uniform(0.3, 0.7)),
        "expansion_1e6_K": 11.7,
    }
    given = {k: _rounded(v) for k, v in given.items()}
    derived = DerivedQuantities(problem_of(given, 16))
    # Where the contact saturates is the scale of creepage; spin counts at the border of the contact.
    angle, size = rng.uniform(0.0, 2.0 * math.pi), derived.saturation_creepage * 10.0 ** rng.uniform(-0.5, 0.3)
    mix = index % 4
    if mix != 3:
        given["creepage_longitudinal"] = _rounded(size * (1.0 if mix == 0 else math.cos(angle)))
        given["creepage_lateral"] = _rounded(0.0 if mix == 0 else size * math.sin(angle))
    if mix >= 2:
        given["spin_rad_m"] = _rounded(size * rng.choice([-1.0, 1.0]) * rng.uniform(0.3, 1.5) / derived.hertz.mean_radius)
    if forced:
        given["force_x_N"] = _rounded(rng.uniform(0.2, 0.85) * given["friction"] * given["normal_N"])
        given["creepage_longitudinal"] = None
    if heated:
        bulge = bulge_bound(DerivedQuantities(problem_of(given, 16))) / derived.hertz.approach
        factor = 10.0 ** rng.uniform(-1.5, -0.6) / bulge
        # Expansion and, for sources at rest, the bulge are proportional to these.
        name = "speed_m_s" if given["peclet"] == "stationary" else "expansion_1e6_K"
        given[name] = _rounded(given[name] * factor)
    return given


def _rounded(value: Any) -> Any:
    return float(f"{value:.4g}") if isinstance(value, float) else value


def extrapolated(coarse: Result, fine: Result, names: Iterable[str]) -> dict[str, float]:
    """Scalars of the coupled state, nine digits, from two grids of which one has twice the elements per side of the other."""
    values = {}
    for name in names:
        before, last = coarse.coupled.scalars[name], fine.coupled.scalars[name]
        # Integrals are reported extrapolated already.
        values[name] = float(f"{last if name in EXTRAPOLATED else last + (last - before) / 3.0:.9g}")
    return values


def reference(given: dict[str, Any], grid: int) -> dict[str, float | None] | None:
    """Scalars of the coupled state extrapolated from two fine grids; None if a grid did not converge."""
    coarse, fine = (solve(problem_of(given, n)) for n in (grid // 2, grid))
    if not (coarse.converged and fine.converged):
        print(f"  left out: {coarse.reason} | {fine.reason}", file=sys.stderr)
        return None
    return {name: None if math.isnan(value) else value for name, value in extrapolated(coarse, fine, SCALARS).items()}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", type=int, default=48)
    parser.add_argument("--grid", type=int, default=256, help="elements per side of the finer grid (default 256)")
    options = parser.parse_args()
    rng = np.random.default_rng(SEED)
    cases = []
    for index in range(options.cases):
        given = draw(rng, index)
        print(index, given, file=sys.stderr, flush=True)
        values = reference(given, options.grid)
        if values is not None:
            cases.append({"input": given, "reference": values})
    lines = ",\n".join("  " + json.dumps(case) for case in cases)
    about = ABOUT.format(coarse=options.grid // 2, fine=options.grid)
    OUTPUT.write_text(f'{{\n "about": {json.dumps(about)},\n "cases": [\n{lines}\n ]\n}}\n', encoding="utf-8")


if __name__ == "__main__":
    main()
