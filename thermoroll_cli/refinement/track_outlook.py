"""What is known of bodies that bring heat back before anything is solved: numbers for `show`, and warnings."""

from __future__ import annotations

import math

from thermoroll_cli.heat.track import Roller
from thermoroll_cli.steady_state.derived import DerivedQuantities

LUMPED_BIOT = 10.0
"""hR/k from which the surface of a solid body is cold beside its core of the track: cooling like this takes jets or baths."""
WIDE = 2.0
"""A half-space takes a body this many times as wide as its contact."""


def rollers_of(derived: DerivedQuantities) -> dict[str, Roller]:
    """The bodies that bring heat back, by name, at the creepage that is given (0 where it is to be found)."""
    found = zip(("lower", "upper"), derived.rollers(derived.problem.motion.creepage_x or 0.0), strict=True)
    return {body: roller for body, roller in found if roller is not None}


def track_facts(derived: DerivedQuantities) -> dict[str, float]:
    """Numbers known before solving: most heat, thermal crown Λ at most, and per body the bulk temperature expected.

    The heat is that of full sliding, shared evenly if the partition is not given: what a slide rule would give."""
    problem = derived.problem
    motion, share = problem.motion, problem.heating.partition
    creepages = [3.0 * derived.saturation_creepage if c is None else abs(c) for c in (motion.creepage_x, motion.creepage_y)]
    heat = problem.traction_limit * math.hypot(*creepages) * motion.speed
    facts = {"thermal_crown_bound": derived.crown_bound}
    shares = (0.5, 0.5) if share == "matched" else (share, 1.0 - share)
    rollers = rollers_of(derived)
    for (body, part), around in zip(zip(("lower", "upper"), shares, strict=True),
                                    (problem.heating.bulk_lower, problem.heating.bulk_upper), strict=True):
        if (roller := rollers.get(body)) is not None:
            facts[f"expected_bulk_temperature_{body}_K"] = around + roller.mean_resistance * roller.passes * part * heat
            if roller.convection is not None:
                facts[f"biot_{body}"] = roller.biot
            facts[f"warm_up_time_{body}_s"] = roller.warm_up_time
    return facts


def track_warnings(derived: DerivedQuantities) -> list[str]:
    """Told: a fixed partition, a track wider than its body, cooling stronger than a solid body can use.

    Raises ValueError where a contact does not fit on its body."""
    out = []
    if derived.problem.heating.partition != "matched":
        out.append("heat that comes back takes part in how it divides: with a fixed thermal.partition temperatures can be wrong"
                   ' by a factor; use "matched"')
    for body, roller in rollers_of(derived).items():
        if 2.0 * derived.scales.semi_axis_y > roller.width:
            raise ValueError(f"thermal.{body}.width_mm = {1e3 * roller.width:g}: the contact is "
                             f"{2e3 * derived.scales.semi_axis_y:.4g} mm wide")
        track = 2.0 * derived.scales.semi_axis_y + 4.0 * roller.spreading
        if track > roller.width:
            out.append(f"the heated track of the {body} body, {1e3 * track:.3g} mm with what spreads between passes, is wider "
                       f"than the body ({1e3 * roller.width:.3g} mm)")
        elif 2.0 * derived.scales.semi_axis_y * WIDE > roller.width:
            share = 200.0 * derived.scales.semi_axis_y / roller.width
            out.append(f"the contact takes {share:.0f} % of the width of the {body} body: the half-space is a doubtful model "
                       "of it")
        if roller.biot > LUMPED_BIOT:
            out.append(f"the Biot number hR/k of the {body} body is {roller.biot:.3g}: its surface is cooled faster than heat "
                       "flows through it, and the answer depends on where exactly it is cooled")
    return out
