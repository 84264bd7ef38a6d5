"""Seeded cases over the whole range that case files allow: every number is one a user can write."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import tomli_w
from scipy.special import elliprd

from thermoroll_cli.files.case import Case, CaseError
from thermoroll_cli.one_contact.refinement.expected_heat import bulge_bound
from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.problem.problem import Problem

SMALL_GRIDS = (8, 8, 10, 12, 16, 16, 20, 24, 24, 32, 32, 40, 48)
LARGE_GRIDS = (64, 96, 128)
LARGE_SHARE = 0.05
LARGEST_SHARE = 0.004
THERMAL_SHARE = 0.45
HOT_SHARE = 0.08
HOT_GRID = 20

BELOW_LIMIT = 0.3
"""A case is below the thermo-elastic limit if the plan's bound of the bulge is less than this share of the approach."""

RECIRCULATING_SHARE = 0.6
"""Share of the cases with heat, unless both bodies are straight: with it one case of five brings heat back."""


@dataclass(frozen=True)
class StressCase:
    """A case, the problem it describes, and its thermal bulge over the approach (estimate from above, 0 without)."""

    seed: int
    case: Case
    problem: Problem
    bulge: float

    @property
    def below_limit(self) -> bool:
        return self.bulge < BELOW_LIMIT


def stress_case(seed: int, *, small: bool = False) -> StressCase:
    """The case of `seed`, always the same; `small` keeps its grid below 25 elements per side."""
    rng = np.random.default_rng(seed)
    thermal = bool(rng.random() < THERMAL_SHARE)
    for _ in range(1000):
        try:
            case, bulge = _draw(rng, thermal, small)
        except CaseError:
            continue  # two wide ranges together left the range of a third key
        return StressCase(seed, case, case.problem, bulge)
    raise RuntimeError(f"seed {seed} finds no valid case")


def _draw(rng: np.random.Generator, thermal: bool, small: bool) -> tuple[Case, float]:
    content: dict[str, Any] = {"title": "stress", "material": _materials(rng, thermal)}
    content["geometry"], content["load"] = _geometry_and_load(rng, content["material"])
    content["rolling"] = {"speed_m_s": 1.0}
    content["thermal"] = _thermal(rng) if thermal else {"heat": False}
    content["numerics"] = _numerics(rng, small)
    case = _parse(content)
    content["creepage"], content["force"] = _driven(rng, case.problem)
    if not thermal:
        return _parse(content), 0.0
    content["rolling"]["speed_m_s"] = _log(rng, -3, 3)
    # Péclet numbers from next to nothing to 1e5, of each body by itself where they differ.
    length = DerivedQuantities(case.problem).hertz.semi_axis_x
    bodies = content["material"].values() if "lower" in content["material"] else [content["material"]]
    for body in bodies:
        number = _log(rng, -3, 5)
        body["diffusivity_mm2_s"] = content["rolling"]["speed_m_s"] * length / number * 1e6
    return _heated(rng, content, bodies)


def _heated(rng: np.random.Generator, content: dict[str, Any], bodies: Any) -> tuple[Case, float]:
    """Thermal constants such that the bulge is a wanted share of the approach, from nothing to far beyond the limit."""
    limit = math.log10(BELOW_LIMIT)
    if rng.random() < HOT_SHARE:
        wanted = _log(rng, limit, 2)
    else:
        wanted = _log(rng, -6 if rng.random() < 0.4 else -3, limit)
    case = _parse(content)
    problem = case.problem
    derived = DerivedQuantities(problem)
    if wanted > BELOW_LIMIT and max(problem.numerics.grid or ()) > HOT_GRID:
        content["numerics"]["grid"] = HOT_GRID  # a limit is searched for with some twenty solutions
    if derived.kinematics.has_traction or problem.heating.conducts:
        bound = bulge_bound(derived)
        factor = wanted * derived.hertz.approach / bound if bound > 0.0 else 0.0
        if 0.0 < factor < math.inf:
            for body in bodies:
                body["expansion_um_mK"] *= math.sqrt(factor)
                body["conductivity_W_mK"] /= math.sqrt(factor)
    # Where a force is prescribed, friction that falls might no longer carry it.
    if rng.random() < 0.1 and problem.prescribed_force == 0.0:
        hottest = wanted / max(body["expansion_um_mK"] * 1e-6 for body in bodies) * _log(rng, -4, -1)
        content.setdefault("friction", {})["temperature_slope_1_K"] = min(10.0, 1.0 / hottest) if hottest > 0.0 else 1e-3
        content["friction"]["temperature_minimum_factor"] = float(rng.uniform(0.05, 0.9))
    # By dice of its own: other cases stay what they were.
    _recirculation(rng.spawn(1)[0], content, derived)
    case = _parse(content)
    if not case.problem.heating.deformation:
        return case, 0.0
    return case, bulge_bound(DerivedQuantities(case.problem)) / derived.hertz.approach


def _recirculation(rng: np.random.Generator, content: dict[str, Any], derived: DerivedQuantities) -> None:
    """Bodies that bring heat back, in one case of five of all: Biot numbers 1e-4 … 1e2, widths of 1 … 1000 contacts, 1 … 20
    passes per turn, or a resistance of the size of such convection (always for rings)."""
    if abs(content["creepage"].get("longitudinal", 0.0)) > 1.9 or rng.random() > RECIRCULATING_SHARE:
        return
    materials = content["material"]
    for body in ("lower", "upper"):
        radius = abs(content["geometry"][f"{body}_radius_x_mm"])
        ring = content["geometry"][f"{body}_radius_x_mm"] < 0.0
        if math.isinf(radius) or rng.random() < 0.3:
            continue
        conductivity = (materials[body] if body in materials else materials)["conductivity_W_mK"]
        convection = _log(rng, -4, 2) * conductivity / (radius * 1e-3)
        width = 2e3 * derived.hertz.semi_axis_y * _log(rng, 0.01, 3)
        table = {"recirculate": True, "width_mm": width, "passes_per_revolution": int(rng.integers(1, 21))}
        if rng.random() < 0.7 and not ring:
            table["convection_W_m2K"] = convection
        else:
            table["thermal_resistance_K_W"] = 1e6 / (convection * 2.0 * math.pi * radius * (radius + width))
        content["thermal"] |= {"peclet": "rolling", body: table}


def _materials(rng: np.random.Generator, thermal: bool) -> dict[str, Any]:
    def body(modulus: float) -> dict[str, float]:
        material = {
            "youngs_modulus_GPa": modulus,
            "poisson_ratio": float(rng.choice([0.0, 0.28, 0.5, rng.uniform(0.0, 0.5), rng.uniform(0.0, 0.5)])),
        }
        if thermal:
            material |= {"conductivity_W_mK": _log(rng, -1, 3), "expansion_um_mK": _log(rng, 0, 2), "diffusivity_mm2_s": 1.0}
        return material

    modulus = _log(rng, -3, 3)
    if rng.random() < 0.75:
        return body(modulus)
    return {"lower": body(modulus), "upper": body(modulus * _log(rng, -3, 3))}


def _geometry_and_load(rng: np.random.Generator, material: dict[str, Any]) -> tuple[dict[str, float], dict[str, float]]:
    aspect = _log(rng, math.log10(0.02), math.log10(50.0)) if rng.random() < 0.8 else 1.0
    ratio = float(elliprd(0.0, 1.0 / aspect, aspect) / elliprd(0.0, aspect, 1.0 / aspect))  # of the curvatures (Hertz)
    size = _log(rng, -6, 6)
    geometry = {}
    for axis, relative in (("x", size / math.sqrt(ratio)), ("y", size * math.sqrt(ratio))):
        form = rng.integers(4)
        first, second = {
            0: (relative, math.inf),
            1: (2.0 * relative, 2.0 * relative),
            2: (0.5 * relative, -relative),  # a ball in a groove
            3: (1.5 * relative, 3.0 * relative),
        }[int(form)]
        if rng.random() < 0.5:
            first, second = second, first
        geometry[f"lower_radius_{axis}_mm"], geometry[f"upper_radius_{axis}_mm"] = first, second
    bodies = [material["lower"], material["upper"]] if "lower" in material else [material]
    modulus = min(body["youngs_modulus_GPa"] for body in bodies)
    # In units of E R² a load says how deep the bodies are pressed into each other: 1e-14 to 1e-2.
    load = modulus * 1e3 * size**2 * _log(rng, -14, -2)
    return geometry, {"normal_N": load, "friction_coefficient": _log(rng, -4, math.log10(2.0))}


def _driven(rng: np.random.Generator, problem: Problem) -> tuple[dict[str, float], dict[str, float]]:
    """Creepages, spin and forces from none to 1e3 times saturation, and to 0.999 μW."""
    derived = DerivedQuantities(problem)
    scale = derived.saturation_creepage
    moderate = rng.random() < 0.6

    def size() -> float:
        return scale * float(rng.choice([-1.0, 1.0])) * (_log(rng, -2, 1) if moderate else _log(rng, -8, 3))

    chosen = ("x", "y", "xy", "s", "xs", "ys", "xys", "")[int(rng.choice(8, p=[0.16] * 6 + [0.03, 0.01]))]
    creepage, force = {}, {}
    if "x" in chosen:
        creepage["longitudinal"] = size()
    if "y" in chosen:
        creepage["lateral"] = size()
    if "s" in chosen:
        creepage["spin_rad_mm"] = size() / derived.hertz.mean_radius * 1e-3
    if rng.random() < 0.3:
        share = float(rng.choice([rng.uniform(0.0, 0.9), 0.99, 0.999]))
        angle = rng.uniform(0.0, 2.0 * math.pi)
        directions = str(rng.choice(["longitudinal", "lateral", "both"]))
        if directions != "both":
            # Spin turns the tractions: a force close to μW leaves it no room, and then there is no steady state.
            force[f"{directions}_N"] = share * problem.traction_limit * float(rng.choice([-1.0, 1.0]))
            creepage = {k: v for k, v in creepage.items() if k == "lateral" and directions == "longitudinal" and share < 0.5}
        else:
            force = {"longitudinal_N": share * problem.traction_limit * math.cos(angle),
                     "lateral_N": share * problem.traction_limit * math.sin(angle)}  # fmt: skip
            creepage = {}
    return creepage, force


def _thermal(rng: np.random.Generator) -> dict[str, Any]:
    thermal: dict[str, Any] = {
        "deformation": bool(rng.random() < 0.75),
        "peclet": str(rng.choice(["rolling", "sliding", "stationary"], p=[0.5, 0.25, 0.25])),
        "partition": float(rng.choice([0.0, 0.5, 1.0, rng.uniform()])),
    }
    if rng.random() < 0.25:
        thermal["partition"] = "matched"
        if rng.random() < 0.3:
            thermal["bulk_temperature_upper_K"] = float(rng.choice([-1.0, 1.0])) * _log(rng, -2, 3)
    return thermal


def _numerics(rng: np.random.Generator, small: bool) -> dict[str, Any]:
    dice = rng.random()
    if small:
        n = int(rng.choice([8, 10, 12, 16, 20, 24]))
    elif dice < LARGEST_SHARE:
        n = 256
    else:
        n = int(rng.choice(LARGE_GRIDS if dice < LARGE_SHARE else SMALL_GRIDS))
    grid: int | list[int] = n
    if rng.random() < 0.3:
        other = int(np.clip(round(n * rng.choice([0.5, 0.75, 1.5, 2.0])), 8, 24 if small else 256))
        grid = [n, other] if rng.random() < 0.5 else [other, n]
    extent = float(rng.choice([2.2, 2.2, 2.2, 1.2, 2.1, 3.0, 4.0, 6.0]))
    return {"grid": grid, "extent": extent}


def _log(rng: np.random.Generator, low: float, high: float) -> float:
    """10 to a power between `low` and `high`, each as likely."""
    return float(10.0 ** rng.uniform(low, high))


def _parse(content: dict[str, Any]) -> Case:
    return Case.parse(tomli_w.dumps(content), name="stress")
