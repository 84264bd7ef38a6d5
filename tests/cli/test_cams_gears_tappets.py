"""docs/cams_gears_tappets.md: its cases and its hand calculations."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path

import numpy as np
import pytest
from scipy.special import k0

from tests.support.command_line import call
from tests.support.documents import page
from thermoroll_cli import solve

PAGE = page("cams_gears_tappets")
CASES = {block.split()[1]: block for block in re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL)}
MODULUS = 206e9 / (2.0 * (1.0 - 0.3**2))
OMEGA = 1500.0 * math.pi / 30.0


def hertz(load: float, radius: float) -> tuple[float, float]:
    """Half-width in m and largest pressure in MPa of a line contact."""
    half = math.sqrt(4.0 * load * radius / (math.pi * MODULUS))
    return half, 2e-6 * load / (math.pi * half)


def by_hand(name: str) -> tuple[float, float, float, dict[str, float]]:
    """V, ξ, R and what else is to be found."""
    if name == "gear":
        base, tangent = 0.5 * 20 * 4e-3 * math.cos(math.radians(20.0)), math.tan(math.radians(20.0))
        radii = base * tangent + 4e-3, 2.0 * base * tangent - 4e-3
        speeds = OMEGA * radii[0], 0.5 * OMEGA * radii[1]
    elif name == "cam":
        lift, second = 8e-3, -4e-3
        radii, speeds = (14e-3 + lift + second, math.inf), (OMEGA * (14e-3 + lift + second), OMEGA * second)
    else:
        radii, speeds = (20e-3, 10e-3), (OMEGA * 20e-3, OMEGA * 20e-3)
    mean, radius = 0.5 * sum(speeds), 1.0 / sum(1.0 / each for each in radii)
    creepage = (speeds[0] - speeds[1]) / mean
    if name != "roller":
        return mean, creepage, radius, {"Q_F_W_mm": 10.0 * (speeds[0] - speeds[1])}
    creepage = 0.1 * hertz(150e3, radius)[0] / radius * (1.0 - math.sqrt(1.0 - 3.75 / 15.0))
    return mean, creepage, radius, {"creepage_longitudinal": creepage}


@pytest.mark.parametrize(("name", "load"), [("gear", 200e3), ("cam", 100e3), ("roller", 150e3)])
def test_what_the_page_says_is_so(name: str, load: float, tmp_path: Path) -> None:
    speed, creepage, radius, found = by_hand(name)
    (tmp_path / f"{name}.toml").write_text(CASES[name].replace("grid = 64", "grid = 32"))
    record = json.loads(call("run", tmp_path / f"{name}.toml", "-o", tmp_path, "--no-plots", "--json", "-q").stdout)
    written = dict(re.findall(r"(\w+) = ([\d.]+)", CASES[name]))
    assert float(written["speed_m_s"]) == pytest.approx(speed, abs=6e-5)
    if "longitudinal" in written:
        assert float(written["longitudinal"]) == pytest.approx(creepage, abs=6e-5)
    half, pressure = hertz(load, radius)
    assert record["pressure_max_MPa"] == pytest.approx(pressure, rel=2e-4)
    for scalar, value in found.items():
        assert abs(record[scalar]) == pytest.approx(value, rel=2e-3)
    for text in (f"a = {1e3 * half:.4f} mm", f"p₀ = {pressure:.1f} MPa", f"= {speed:.4f} m/s"):
        assert text in PAGE


def test_surfaces_that_run_against_each_other_on_a_pointed_nose() -> None:
    """ω (r_b + h + h″) = 1.336 m/s and ω h″ = −3.361 m/s: V = −1.013 m/s, of which a case has the magnitude. Both surfaces are
    equally warm at each place, at the hottest by 102.7 K, as from lines of heat on both (Carslaw, Jaeger); Blok has 90.6."""
    speeds, radius, load = (1.3360, -3.3611), 6.3788e-3, 83416.4
    half, _ = hertz(load, radius)
    edges = np.linspace(-half, half, 81)
    middles, width = 0.5 * (edges[1:] + edges[:-1]), edges[1] - edges[0]
    within, weights = np.polynomial.legendre.leggauss(8)  # even: no node where K₀ is infinite
    away = middles[:, None, None] - middles[None, :, None] - 0.5 * width * within
    responses = [np.exp(speed * away / 25.4e-6) * k0(np.abs(speed * away) / 25.4e-6) @ weights * 0.5 * width / (math.pi * 46.0)
                 for speed in speeds]
    flux = 0.1 * load * (speeds[0] - speeds[1]) * 2.0 / (math.pi * half) * np.sqrt(1.0 - (middles / half) ** 2)
    by_lines = (responses[0] @ np.linalg.solve(sum(responses), responses[1] @ flux)).max()
    mean = 0.5 * sum(speeds)
    found = solve({
        "material": {"youngs_modulus_GPa": 206.0, "poisson_ratio": 0.3, "conductivity_W_mK": 46.0, "expansion_um_mK": 0.0,
                     "diffusivity_mm2_s": 12.7},
        "geometry": {"lower_radius_x_mm": 1e3 * radius, "upper_radius_x_mm": math.inf}, "numerics": {"grid": 64},
        "load": {"normal_N_mm": 1e-3 * load, "friction_coefficient": 0.1}, "rolling": {"speed_m_s": abs(mean)},
        "creepage": {"longitudinal": (speeds[0] - speeds[1]) / mean}, "thermal": {"partition": "matched"}})
    assert by_lines == pytest.approx(102.7, abs=0.4)
    assert found["temperature_rise_max_lower_K"] == pytest.approx(by_lines, rel=4e-3)
    assert found["temperature_rise_max_upper_K"] == pytest.approx(by_lines, rel=4e-3)


def test_a_body_softer_than_its_pressure_is_warned_of(tmp_path: Path) -> None:
    """A tyre's rubber would have to carry what its air does."""
    text = CASES["roller"].replace("youngs_modulus_GPa = 206.0", "youngs_modulus_GPa = 0.01").replace("[force]", "[creepage]")
    text = text.replace("longitudinal_N_mm = 3.75", "").replace("normal_N_mm = 150.0", "normal_N_mm = 20.0")
    (tmp_path / "soft.toml").write_text(text)
    done = call("validate", tmp_path / "soft.toml")
    assert done.returncode == 0 and "a tyre that air carries, is another model" in " ".join(done.stderr.split())
