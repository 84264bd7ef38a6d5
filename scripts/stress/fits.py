"""Values fitted to synthetic creep curves with known noise: their 95 % intervals must hold the truth as often as they say."""

from __future__ import annotations

import pathlib
from dataclasses import dataclass

import numpy as np

from scripts.stress.outcome import Outcome, Pair
from thermoroll_cli import Case, fit, solve

GRID, CREEPAGES = 32, (5e-4, 2e-3, 4e-3, 7e-3, 1e-2, 2e-2)
NOISE = 60.0
"""Standard deviation (N) of the forces: what they leave open is several times what the grid leaves open."""
TRUTH = {"load.friction_coefficient": 0.5135, "layer.compliance_um_GPa": 3.8, "creepage.lateral": 2e-3}
RIG = pathlib.Path(__file__).parents[2] / "cases" / "vt_fra_roller_rig.toml"


@dataclass(frozen=True)
class Curve:
    """A creep curve with noise, and the case that begins away from the truth; `free` are the keys that are sought."""

    case: Case
    data: dict[str, list[float]]
    free: tuple[str, ...]


def random_curve(seed: int, values: int) -> Curve:
    """Draw a curve of the roller rig from which two `values` follow, or three from forces along and across."""
    random, free = np.random.default_rng([61, values, seed]), tuple(TRUTH)[:values]
    lateral = TRUTH["creepage.lateral"] if values > 2 else 0.0
    rig = Case.read(RIG).with_values({"numerics.grid": GRID} | TRUTH | {"creepage.lateral": lateral})
    exact = [solve(rig.with_values({"creepage.longitudinal": creepage})).scalars for creepage in CREEPAGES]
    data = {"creepage.longitudinal": list(CREEPAGES)}
    for name in ("force_x_N", "force_y_N")[: values - 1]:
        data[name] = [float(scalars[name]) + NOISE * random.standard_normal() for scalars in exact]
        data[f"{name}_error"] = [NOISE] * len(exact)
    return Curve(rig.with_values({key: 0.8 * TRUTH[key] for key in free}), data, free)


def covered(curve: Curve) -> Outcome:
    """Fit the values again; a pair is half of an interval beside the true error, both over the true value."""
    found = fit(curve.case, curve.data, free=list(curve.free))
    pairs = [Pair(GRID, key, float(one.uncertainty_95) / TRUTH[key], abs(float(one.value) / TRUTH[key] - 1.0))
             for key, one in found.parameters.items()]
    lost = tuple(f"{pair.scalar} has no interval" for pair in pairs if not np.isfinite(pair.estimate))
    return Outcome(found.converged, found.reason, broken=lost if found.converged else (), pairs=() if lost else tuple(pairs))
