"""Seeded ball bearings, and the check of each."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from scripts.stress.outcome import Outcome, Pair
from thermoroll_cli import Case
from thermoroll_cli.many_contacts.bearing.bearing_problem import BearingProblem
from thermoroll_cli.many_contacts.bearing.bearing_result import BearingSolver
from thermoroll_cli.problem.result import Result

GRID, REFERENCE, FEW = 24, 72, 3
"""Elements per side of each contact, and of the ones that stand for the truth; balls of the bearings that are compared."""
CERAMIC = {"youngs_modulus_GPa": 315.0, "poisson_ratio": 0.26, "density_kg_m3": 3200.0}
EXCUSE = "gyroscopic moment"
"""In the reasons of balls that friction does not hold."""
LOAD_SHARE = 1e-3
"""Departure of the forces of all balls from the loads that may remain, over the largest load."""
SCALARS = ("axial_displacement_um", "radial_displacement_um", "axial_stiffness_N_um", "radial_stiffness_N_um",
           "cage_speed_rad_s", "torque_Nmm", "T_gamma_N", "pressure_max_MPa", "contact_area_mm2", "shear_max_MPa")
"""Scalars of the whole whose errors are compared."""
OF_CONTACTS = ("normal_N", "contact_angle_deg", "spin_to_roll", "creepage_longitudinal", "creepage_lateral", "Q_F_W",
               "spin_moment_Nmm")
"""Those of the contacts of ball 1."""


def random_bearing(seed: int, grid: int = GRID) -> Case:
    """The bearing of `seed`, always the same: balls of 3 to 30 mm, up to 400,000 mm/min (d_m n), dry or nearly lubricated,
    under thrust or combined loads from light to heavy, angular contact or a deep groove, either ring turning; a third has
    ceramic balls and turns up to four times as fast, a third carries a hundredth of the load, or hardly has friction."""
    rng = np.random.default_rng([67, seed])
    ball = float(10.0 ** rng.uniform(0.5, 1.5))
    inner, outer = rng.uniform(0.505, 0.56, 2).tolist()
    pitch = ball * float(rng.uniform(3.2, 8.0))
    balls = max(3, int(math.pi / math.asin(ball / pitch) * rng.uniform(0.5, 0.98)))
    angle = float(rng.uniform(10.0, 45.0)) if rng.random() < 0.6 else 0.0
    whole = float(10.0 ** rng.uniform(-0.3, 1.3)) * ball**2 * balls
    speed = float(10.0 ** rng.uniform(0.0, math.log10(4e5 / pitch)))
    turning = ("inner_rpm", "outer_rpm")[rng.random() < 0.3]
    load = {"axial_N": whole * math.sin(math.radians(angle))}
    if not angle or rng.random() < 0.4:
        load = {"radial_N": 0.2 * whole, "axial_N": whole * float(rng.uniform(0.1, 0.6))}
        if rng.random() < 0.3:
            load["moment_Nm"] = float(rng.uniform(-5e-5, 5e-5)) * whole * pitch
    contact: dict[str, Any] = {"contact_angle_deg": angle} if angle else {
        "clearance_um": float(rng.uniform(0.0, 10.0)) * ball * (inner + outer - 1.0)}
    friction, material = float(10.0 ** rng.uniform(-1.5, -0.5)), {"youngs_modulus_GPa": 206.0, "poisson_ratio": 0.3}
    bodies: dict[str, Any] = material
    if rng.random() < 1.0 / 3.0:
        bodies, speed = {"lower": material, "upper": CERAMIC}, speed * float(rng.uniform(1.0, 4.0))
    if rng.random() < 1.0 / 3.0:
        if rng.random() < 0.5:
            load = {name: 0.01 * value for name, value in load.items()}
        else:
            friction *= 0.02
    return Case.from_dict({
        "bearing": {"ball_diameter_mm": ball, "pitch_diameter_mm": pitch, "balls": balls, "conformity_inner": inner,
                    "conformity_outer": outer, turning: speed, "load": load, **contact},
        "load": {"friction_coefficient": friction}, "material": bodies, "numerics": {"grid": grid}})  # fmt: skip


def check(case: Case) -> Outcome:
    """Solve the bearing; if it converges all balls together carry the loads."""
    return _outcome(case, _solved(case))


def covered(case: Case, *_: int) -> Outcome:
    """As `check`, with few balls, and with the estimated and the true errors of the whole and of the contacts of ball 1."""
    case = case.with_values({"bearing.balls": FEW})
    result, fine = _solved(case), _solved(case.with_values({"numerics.grid": REFERENCE}))
    outcome = _outcome(case, result)
    if not (result.converged and fine.converged):
        return outcome
    numbers = [(name, result[name], result.uncertainty[name], fine[name]) for name in SCALARS if name in result.scalars]
    for one, other in zip(result.contacts[:2], fine.contacts[:2], strict=True):
        numbers += [(name, one.record[name], one.record["uncertainty"][name], other.record[name]) for name in OF_CONTACTS]
    # What symmetry makes zero has no scale.
    pairs = (Pair(GRID, name, float(estimate) / abs(truth), abs(value - truth) / abs(truth))
             for name, value, estimate, truth in numbers if abs(truth) > 1e-6)
    return replace(outcome, pairs=tuple(pair for pair in pairs if math.isfinite(pair.estimate)))


def _outcome(case: Case, result: Result) -> Outcome:
    return Outcome(result.converged, result.reason, EXCUSE in result.reason, _faults(case, result) if result.converged else ())


def _solved(case: Case) -> Result:
    task = case.task
    assert isinstance(task, BearingProblem)
    return BearingSolver().solve(task)


def _faults(case: Case, result: Result) -> tuple[str, ...]:
    task = case.task
    assert isinstance(task, BearingProblem)
    records = [contact.record for contact in result.contacts if contact.record["ring"] == "inner"]
    load, angle, ball = (np.array([record[name] for record in records]) for name in ("normal_N", "contact_angle_deg", "ball"))
    lateral = np.array([contact["force_y_N"] for contact in result.contacts if contact.record["ring"] == "inner"])
    angle, place = np.radians(angle), task.places[ball - 1]
    # Across rolling e_y is (cos α, −sin α) for a ring that turns faster, and friction acts on the ball.
    push = task.direction * lateral
    axial = float((load * np.sin(angle) - push * np.cos(angle)).sum())
    radial = float(((load * np.cos(angle) + push * np.sin(angle)) * np.cos(place)).sum())
    largest = max(abs(task.axial), task.radial)
    wrong = [name for name, found, wanted in (("axial", axial, task.axial), ("radial", radial, task.radial))
             if abs(found - wanted) > LOAD_SHARE * largest]
    return tuple(f"the balls do not carry the {name} load" for name in wrong)
