"""Results made of closed forms (Hertz pressure, Carter's strips, a smeared-out hot trailing edge), for tests of what
happens to a result after it was solved: files, comparison, export, pictures. Nothing here is meant to be accurate."""

from __future__ import annotations

import math

import numpy as np

from thermoroll_cli.problem.friction import Friction
from thermoroll_cli.problem.geometry import Geometry
from thermoroll_cli.problem.problem import Heating, Material, Motion, Numerics, Problem
from thermoroll_cli.problem.result import Result, State

STEEL = Material(210e9, 0.28, 50.2, 11.7e-6, 10e-6)
RADIUS, LOAD, FRICTION, SPEED, CREEPAGE = 0.030, 65.0, 0.3, 200.0, 0.003


def problem(*, aspect: float = 1.0, heat: bool = True, deformation: bool = True, title: str = "Synthetic") -> Problem:
    sphere = RADIUS * aspect
    return Problem(
        lower=STEEL, upper=STEEL, geometry=Geometry(RADIUS, sphere, RADIUS, sphere), normal_force=LOAD,
        friction=Friction(FRICTION), motion=Motion(SPEED, CREEPAGE, 0.0, 0.0),
        heating=Heating(heat=heat, deformation=deformation, peclet="stationary"), numerics=Numerics(grid=(64, 64)),
        title=title)


def result(
    shape: tuple[int, int] = (64, 64), *, aspect: float = 1.0, size: float = 1.0, extent: float = 2.2, angle: float = 0.0,
    slip_share: float = 0.4, heat: bool = True, deformation: bool = True, tangential: bool = True, upper_heating: float = 1.0,
    title: str = "Synthetic", converged: bool = True,
) -> Result:
    """A result on `shape` elements. `aspect` is b0/a0, `size` scales lengths, `angle` turns the creepage,
    `slip_share` is the slip length over 2 a0 on y = 0, `upper_heating` the upper temperature over the lower one."""
    modulus = 210e9 / (1 - 0.28**2) / 2
    a0 = size * (3 * LOAD * RADIUS / 2 / (4 * modulus)) ** (1 / 3)
    b0 = a0 * aspect
    p0 = 3 * LOAD / (2 * math.pi * a0 * b0)
    x, y = (extent * half * ((np.arange(n) + 0.5) / n - 0.5) for half, n in zip((a0, b0), shape, strict=True))
    options = {"tangential": tangential, "heat": heat, "angle": angle, "slip": 2 * a0 * slip_share,
               "upper_heating": upper_heating, "a0": a0, "b0": b0, "p0": p0}  # fmt: skip
    isothermal = _state(x, y, shift=0.0, shrink=1.0, bulge=0.0, **options)
    feedback = heat and deformation and tangential
    coupled = _state(x, y, shift=0.06, shrink=0.93, bulge=0.25, **options) if feedback else isothermal
    peclet = SPEED * a0 / 10e-6
    return Result(
        problem=problem(aspect=aspect, heat=heat, deformation=deformation, title=title),
        coupled=coupled,
        isothermal=isothermal,
        of_problem={"hertz_a_mm": a0 * 1e3, "hertz_b_mm": b0 * 1e3, "hertz_p0_MPa": p0 * 1e-6,
               "friction_limit_N": FRICTION * LOAD, "peclet_lower": peclet, "peclet_upper": peclet,
               "kalker_C11": 4.3, "kalker_C22": 3.7, "kalker_C23": 1.5},
        converged=converged,
        reason="" if converged else "the coupling iteration stopped at its limit of 50",
        uncertainty={name: 1.3e-4 * abs(value) for name, value in coupled.scalars.items()},
        work={"grid": list(shape), "iterations": {"normal": 9, "tangential": 21}, "seconds": {"normal": 0.02},
              "skipped": {"spin": "no spin is prescribed"}},
        residuals={"coupling": np.array([1.0, 0.1, 1e-3, 1e-5]), "tangential": np.array([0.5, 1e-7])},
        warnings=("the contact is small",),
    )  # fmt: skip


def _state(x, y, *, shift, shrink, bulge, tangential, heat, angle, slip, upper_heating, a0, b0, p0):  # type: ignore[no-untyped-def]
    xx, yy = np.meshgrid(x, y, indexing="ij")
    half = shrink * a0 * np.sqrt(np.maximum(0.0, 1 - (yy / (shrink * b0)) ** 2))
    u = xx - shift * a0
    inside = np.maximum(0.0, half**2 - u**2) / (shrink * a0) ** 2
    swell = 1 + bulge * u / a0 + bulge / 2
    contact = inside > 0
    pressure = p0 * np.sqrt(inside) * swell
    radial = np.hypot(u / (shrink * a0), yy / (shrink * b0))
    fields = {
        "covered": _share(x, y, lambda u, v: (u - shift * a0) ** 2 + (v * a0 / b0) ** 2 < (shrink * a0) ** 2),
        "pressure": pressure, "displacement_elastic": a0 * 1e-3 * (1 - 0.5 * np.minimum(radial, 1.0) ** 2),
        "gap": 1e-3 * a0 * np.maximum(0.0, radial - 1) ** 1.5}
    scalars = {
        "gamma_c": shrink**2, "gamma_p": float(pressure.max() / p0), "pressure_max_MPa": float(pressure.max() * 1e-6),
        "contact_area_mm2": math.pi * a0 * b0 * shrink**2 * 1e6, "approach_um": 1.234}
    if not tangential:
        fields["state"] = np.where(contact, 1, 0)
        fields["stick_share"] = fields["covered"]
        return State(fields, scalars, x, y)
    core = half - slip / 2 * shrink
    beyond = (u + half - core) ** 2 - core**2
    stick = contact & (core > 0) & (beyond < 0)
    slipping = contact & ~stick
    fields["stick_share"] = _share(x, y, lambda u, v: sticks(u - shift * a0, shrink * a0, v * a0 / b0, slip * shrink))
    limit = FRICTION * p0 / (shrink * a0) * swell
    traction = limit * (np.sqrt(inside) * shrink * a0 - np.where(stick, np.sqrt(np.maximum(0.0, -beyond)), 0.0))
    speed = np.where(slipping, 0.01 * SPEED * np.sqrt(np.maximum(0.0, beyond)) / a0, 0.0)
    cosine, sine = math.cos(angle), math.sin(angle)
    fields |= {"shear_x": traction * cosine, "shear_y": traction * sine, "slip_x": speed * cosine}
    fields |= {"slip_y": speed * sine, "state": np.where(stick, 1, np.where(contact, 2, 0))}
    area = (x[1] - x[0]) * (y[1] - y[0])
    scalars |= {
        "gamma_st": float(stick.sum() / max(1, contact.sum())), "stick_area_mm2": float(stick.sum() * area * 1e6),
        "force_x_N": float(fields["shear_x"].sum() * area), "force_y_N": float(fields["shear_y"].sum() * area),
        "spin_moment_Nmm": float(1e3 * np.sum(xx * fields["shear_y"] - yy * fields["shear_x"]) * area),
        "creepage_longitudinal": CREEPAGE * cosine, "creepage_lateral": CREEPAGE * sine, "creepage_spin_rad_mm": 0.0,
        "shear_max_MPa": float(traction.max() * 1e-6), "power_balance_error": 3.1e-5}
    if not heat:
        return State(fields, scalars, x, y)
    flux = traction * speed
    lag = np.subtract.outer(x, x)
    smear = np.where(lag >= 0, 1 / np.sqrt(np.abs(lag) + 0.1 * a0), np.exp(lag / (0.1 * a0)) / np.sqrt(0.1 * a0))
    lower = smear @ flux * (x[1] - x[0]) * 1e-4 / SPEED**0.5
    fields |= {"heat_flux": flux, "temperature_rise_lower": lower, "temperature_rise_upper": lower * upper_heating}
    fields["displacement_thermal"] = 1e-9 * lower
    scalars |= {
        "Q_F_W": float(flux.sum() * area), "heat_flux_max_W_mm2": float(flux.max() * 1e-6),
        "temperature_rise_max_lower_K": float(lower.max()),
        "temperature_rise_max_upper_K": float(lower.max() * upper_heating),
        "thermal_displacement_max_um": float(1e-3 * lower.max())}
    return State(fields, scalars, x, y)


def sticks(u, radius, v, slip):  # type: ignore[no-untyped-def]
    """Whether a place of a round contact is in the stick strips, which end `slip` before its trailing edge."""
    half = np.sqrt(np.maximum(0.0, radius**2 - v**2))
    return (u > -half) & (u < half - slip)


def _share(x, y, inside):  # type: ignore[no-untyped-def]
    """Share of each element in which `inside` holds, counted at 7 × 7 places."""
    steps = (np.arange(7) - 3) / 7
    u, v = ((axis[:, None] + (axis[1] - axis[0]) * steps).ravel() for axis in (x, y))
    found = inside(u[:, None], v[None, :])
    return found.reshape(x.size, 7, y.size, 7).mean(axis=(1, 3))
