"""The examples of add_a_stage.md and add_a_kind.md, followed line by line on copies of the package."""

from __future__ import annotations

import json
import math
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
CAM = """
title = "a cam"
material = {youngs_modulus_GPa = 210.0, poisson_ratio = 0.28}
cam = {base_radius_mm = 20, lift_mm = 4, follower_radius_mm = 10, speed_rpm = 600, base_N_mm = 50, top_N_mm = 100, angles = 4}
load.friction_coefficient = 0.2
creepage.longitudinal = 0.001
numerics.grid = 32
"""
MOST_OTHERS = {"add_a_stage.md": 6, "add_a_kind.md": 4}
"""Files of the package that an addition changes at most, besides those that it adds."""


def edited(text: str, block: str) -> str:
    """`text` with one block of the document made: its lines without + are found exactly once."""
    lines = block.splitlines()
    before = "".join(f"{line[1:]}\n" for line in lines if not line.startswith("+"))
    after = "".join(f"{line[1:]}\n" for line in lines if not line.startswith("-"))
    assert text.count(before) == 1, f"where is this?\n{before}"
    return text.replace(before, after)


def extended(folder: Path, page: str) -> Path:
    """The folder with the package as the document leaves it."""
    if not (folder / "thermoroll_cli").exists():
        shutil.copytree(ROOT / "thermoroll_cli", folder / "thermoroll_cli")  # what has been compiled, too
    text = (Path(__file__).parent / page).read_text(encoding="utf-8")
    blocks = re.findall(r"```diff\n--- (\S+)\n(.*?)```", text, re.DOTALL)
    others = {path for path, _ in blocks if (folder / path).exists()}
    assert len(others) <= MOST_OTHERS[page], others
    for path, block in blocks:
        file = folder / path
        file.parent.mkdir(exist_ok=True)
        file.write_text(edited(file.read_text() if file.exists() else "", block))
    return folder


def called(place: Path, commands: list[list[str]]) -> subprocess.CompletedProcess[str]:
    program = ("import sys; from thermoroll_cli.cli.main import main\n"
               f"for words in {commands!r}:\n    print(main(words), file=sys.stderr)")  # fmt: skip
    environment = {**os.environ, "PYTHONPATH": str(place)}
    return subprocess.run([sys.executable, "-c", program], cwd=place, env=environment, capture_output=True, text=True)


def test_each_edit_has_its_place_and_its_case_can_be_planned(tmp_path: Path) -> None:
    """Both in one package."""
    place = extended(extended(tmp_path, "add_a_stage.md"), "add_a_kind.md")
    (place / "cam.toml").write_text(CAM)
    done = called(place, [["show", str(ROOT / "cases" / "article_4_1.toml"), "--set", "load.debris_coefficient_m3_J=1e-13"],
                          ["show", "cam.toml"]])
    assert done.stderr.splitlines()[-2:] == ["0", "0"] and "debris" in done.stdout and "cam.lift_mm" in done.stdout


@pytest.mark.slow
def test_a_stage_goes_the_whole_way(tmp_path: Path) -> None:
    """From the case file to the scalar, the field's picture and the plan: the rate is k times the frictional heat."""
    case = (str(ROOT / "cases" / "article_4_1.toml"), "--set", "load.debris_coefficient_m3_J=1e-13", "--json")
    commands = [["run", *case, "--set", "numerics.grid=16", "--no-plots"],
                ["plot", "results/article_4_1.h5", "--fields", "debris_rate", "-q"], ["show", *case]]  # fmt: skip
    place = extended(tmp_path, "add_a_stage.md")
    done = called(place, commands)
    assert re.findall(r"^\d$", done.stderr, re.MULTILINE) == ["0", "0", "0"], done.stderr
    solved, shown = map(json.loads, done.stdout.splitlines())
    # Declared as an integral, it is extrapolated from three grids as the heat is, and has its error.
    assert solved["debris_rate_mm3_s"] == pytest.approx(1e-4 * solved["Q_F_W"], rel=1e-9)
    assert solved["uncertainty"]["debris_rate_mm3_s"] == pytest.approx(1e-4 * solved["uncertainty"]["Q_F_W"])
    assert solved["debris_rate_mm3_s"] != solved["isothermal"]["debris_rate_mm3_s"]
    assert (place / "results" / "article_4_1_debris_rate.png").stat().st_size > 10_000
    assert "debris" in shown["run"]
    assert shown["inputs"]["load.debris_coefficient_m3_J"]["si"] == 1e-13


@pytest.mark.slow
def test_a_kind_goes_the_whole_way(tmp_path: Path) -> None:
    """A cam is solved, shown, drawn, compared, exported and swept, and refused by the commands that cannot take it."""
    place = extended(tmp_path, "add_a_kind.md")
    (place / "cam.toml").write_text(CAM)
    hollow, loaded = ["--set", "cam.lift_mm=60"], ["--set", "load.normal_N_mm=50"]
    done = called(place, [
        ["run", "cam.toml", "--json", "--no-plots"], ["show", "cam.toml", "--json"], ["show", "cam.toml"],
        ["run", "cam.toml", "--report"], ["export", "results/cam.h5", "--format", "csv", "-o", "results"],
        ["plot", "results/cam.h5", "-q"], ["sweep", "cam.toml", "--over", "cam.speed_rpm=300,600", "-q"], ["schema"],
        ["compare", "results/cam.h5", "results/cam.h5"],
        ["wear", "cam.toml"], ["conicity", "cam.toml"], ["run", "cam.toml", *hollow], ["validate", "cam.toml", *loaded]])
    assert re.findall(r"^\d$", done.stderr, re.MULTILINE) == [*9 * ["0"], *4 * ["3"]], done.stderr
    for refusal in ("the wear of cams is not followed", "a cam has no equivalent conicity",
                    "the cam is hollow or undercut at 0°", "load.normal_N_mm: cannot be given together with [cam]"):
        assert refusal in done.stderr
    solved, shown, *words = done.stdout.splitlines()
    found, omega = json.loads(solved), 20.0 * math.pi
    base, rising, top, falling = found["patches"]
    # By hand: an arc without slope has a radius of curvature R²/(R − R″), here with R = 30 and 34 mm and R″ = ±2 mm.
    for contact, r, second, load in ((base, 30.0, 2.0, 50.0), (top, 34.0, -2.0, 100.0)):
        radius = r * r / (r - second) - 10.0
        assert contact["cam_radius_mm"] == pytest.approx(radius) and contact["normal_N_mm"] == pytest.approx(load)
        assert contact["rolling_speed_m_s"] == pytest.approx(1e-3 * omega * r * radius / (radius + 10.0))
        modulus = 210e3 / (2.0 * (1.0 - 0.28**2))  # Hertz's line contact: p₀ = √(P'E*/πR)
        pressure = math.sqrt(load * modulus / math.pi * (1.0 / radius + 0.1))
        assert abs(contact["pressure_max_MPa"] - pressure) <= contact["uncertainty"]["pressure_max_MPa"] <= 0.02 * pressure
    # Rising and falling it is the same but for the sign of the slope, 2 mm on 32 mm.
    assert rising["normal_N_mm"] == pytest.approx(75.0 * math.hypot(1.0, 2.0 / 32.0)) == falling["normal_N_mm"]
    assert found["largest_pressure_MPa"] == max(each["pressure_max_MPa"] for each in found["patches"])
    assert found["mean_heat_W_mm"] == pytest.approx(sum(each["Q_F_W_mm"] for each in found["patches"]) / 4)
    assert json.loads(shown)["inputs"]["cam.lift_mm"]["si"] == 4e-3
    assert any(re.match(r"\s+largest_pressure_MPa\s.*largest pressure over a turn", line) for line in words)
    assert any(re.match(r"\s+contact\s+angle 1\s+angle 2", line) for line in words)
    results = place / "results"
    assert "A cam and its follower over one turn, with 4 patches of contact." in (results / "cam_report.html").read_text()
    assert (results / "cam.csv").read_text().startswith("angle,angle_deg,cam_radius_mm,")
    assert "angle_2.Q_F_W_mm" in (results / "sweep.csv").read_text()
    assert {"cam_turn.png", "sweep.png"} <= {path.name for path in results.glob("*.png")}
