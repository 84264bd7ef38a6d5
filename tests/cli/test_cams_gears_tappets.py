"""docs/cams_gears_tappets.md: its cases and its hand calculations."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path

import pytest

from tests.support.command_line import call
from tests.support.documents import page

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


def test_a_body_softer_than_its_pressure_is_warned_of(tmp_path: Path) -> None:
    """A tyre's rubber would have to carry what its air does."""
    text = CASES["roller"].replace("youngs_modulus_GPa = 206.0", "youngs_modulus_GPa = 0.01").replace("[force]", "[creepage]")
    text = text.replace("longitudinal_N_mm = 3.75", "").replace("normal_N_mm = 150.0", "normal_N_mm = 20.0")
    (tmp_path / "soft.toml").write_text(text)
    done = call("validate", tmp_path / "soft.toml")
    assert done.returncode == 0 and "a tyre that air carries, is another model" in " ".join(done.stderr.split())
