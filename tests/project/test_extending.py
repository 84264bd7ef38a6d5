"""The examples of add_a_stage.md and add_a_kind.md, followed line by line on copies of the package."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
STACK = """
material = {youngs_modulus_GPa = 210.0, poisson_ratio = 0.28}
stack = {radius_mm = 20, loads_N = [50, 100]}
load.friction_coefficient = 0.2
rolling.speed_m_s = 1.0
creepage.longitudinal = 0.001
numerics.grid = 16
"""


def edited(text: str, block: str) -> str:
    """`text` with one block of the document made: its lines without + are found exactly once."""
    lines = block.splitlines()
    before = "".join(f"{line[1:]}\n" for line in lines if not line.startswith("+"))
    after = "".join(f"{line[1:]}\n" for line in lines if not line.startswith("-"))
    assert text.count(before) == 1, f"where is this?\n{before}"
    return text.replace(before, after)


def extended(folder: Path, page: str) -> Path:
    """The folder with the package as the document leaves it."""
    shutil.copytree(ROOT / "thermoroll_cli", folder / "thermoroll_cli")  # what has been compiled, too
    text = (Path(__file__).parent / page).read_text(encoding="utf-8")
    for path, block in re.findall(r"```diff\n--- (\S+)\n(.*?)```", text, re.DOTALL):
        file = folder / path
        file.parent.mkdir(exist_ok=True)
        file.write_text(edited(file.read_text() if file.exists() else "", block))
    return folder


def called(place: Path, commands: list[list[str]]) -> subprocess.CompletedProcess[str]:
    program = ("import sys; from thermoroll_cli.cli.main import main\n"
               f"for words in {commands!r}:\n    print(main(words), file=sys.stderr)")  # fmt: skip
    environment = {**os.environ, "PYTHONPATH": str(place)}
    return subprocess.run([sys.executable, "-c", program], cwd=place, env=environment, capture_output=True, text=True)


@pytest.mark.parametrize(("page", "command"), [
    ("add_a_stage.md", ["show", str(ROOT / "cases" / "article_4_1.toml"), "--set", "load.debris_coefficient_m3_J=1e-13"]),
    ("add_a_kind.md", ["show", "balls.toml"])])
def test_each_edit_has_its_place_and_its_case_can_be_planned(page: str, command: list[str], tmp_path: Path) -> None:
    place = extended(tmp_path, page)
    (place / "balls.toml").write_text(STACK)
    done = called(place, [command])
    assert done.stderr.splitlines()[-1:] == ["0"] and ("debris" in done.stdout or "stack" in done.stdout)


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
    """Every command knows it: what it is, what it does not go with, its numbers and those of its contacts."""
    place = extended(tmp_path, "add_a_kind.md")
    (place / "balls.toml").write_text(STACK)
    done = called(place, [
        ["run", "balls.toml", "--json", "--no-plots"], ["validate", "balls.toml", "-q"], ["run", "balls.toml", "--report"],
        ["export", "results/balls.h5", "--format", "csv", "-o", "results"], ["plot", "results/balls.h5", "-q"],
        ["sweep", "balls.toml", "--over", "stack.radius_mm=10,20", "-q"], ["schema"],
        ["compare", "results/balls.h5", "results/balls.h5"], ["wear", "balls.toml"]])
    assert re.findall(r"^\d$", done.stderr, re.MULTILINE) == [*8 * ["0"], "3"], done.stderr
    assert "the wear of stacks is not followed" in done.stderr
    solved, *words = done.stdout.splitlines()
    found = json.loads(solved)
    assert found["approach_sum_um"] == pytest.approx(sum(each["approach_um"] for each in found["patches"]))
    assert [each["normal_N"] for each in found["patches"]] == [50.0, 100.0]
    assert any(re.match(r"\s+approach_sum_um\s.*sum of all approaches", line) for line in words)
    assert any(re.match(r"\s+contact\s+level 1\s+level 2", line) for line in words)
    assert "A stack of balls, with 2 patches of contact." in (place / "results" / "balls_report.html").read_text()
    assert (place / "results" / "balls.csv").read_text().startswith("level,normal_N,")
    assert "level_2.Q_F_W" in (place / "results" / "sweep.csv").read_text()
    assert {"balls_patches.png", "sweep.png"} <= {path.name for path in (place / "results").glob("*.png")}
