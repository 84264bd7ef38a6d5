"""The README's own commands, verbatim."""

import os
import re
import shlex
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.support.command_line import PATIENCE, call

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text()
SHELL = [block for block in re.findall(r"```sh\n(.*?)```", README, re.DOTALL) if "thermoroll " in block]
GRID = "grid = 128\n"
(PYTHON,) = re.findall(r"```python\n(.*?)```", README, re.DOTALL)


@pytest.fixture
def place(tmp_path: Path) -> Path:
    (tmp_path / "cases").symlink_to(ROOT / "cases")
    return tmp_path


def run(command: list[str], place: Path) -> subprocess.CompletedProcess[str]:
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    env = {**os.environ, "PATH": path}
    done = subprocess.run(command, cwd=place, env=env, capture_output=True, text=True, timeout=PATIENCE)
    assert done.returncode == 0, done.stderr
    return done


def lines(script: str, place: Path) -> Iterator[tuple[str, list[str]]]:
    """The commands of a script one by one with their words; those that take a shell have been run by one."""
    for line in re.findall(r"^for .*?^done.*?$|^thermoroll .*?$", script, re.DOTALL | re.MULTILINE):
        words = shlex.split(line, comments=True)
        if {"||", "|", ">"} & set(words) or words[0] == "for":
            run(["bash", "-eu", "-c", line], place)
        else:
            yield line, words[1:]


def test_commands(place: Path) -> None:
    """Every command of the section on commands, in order: in this process, and by a shell where it takes one."""
    count = 0
    for line, words in lines(SHELL[0], place):
        coarser = ("--set", "numerics.accuracy=0.03") if words[0] in ("sweep", "wear") else ()  # many points
        coarser += ("--set", "wear.depth_um=1") if words[0] == "wear" else ()
        done = call(*words, *coarser, cwd=place)
        assert done.returncode == 0, (line, done.stderr)
        count += 1
    assert count == len(SHELL[0].splitlines()) - 2
    for name in ("my_case.h5", "my_case_pressure.png", "my_case_pressure.svg", "my_case.xdmf"):
        assert (place / "results" / name).exists(), name
    assert (place / "case.schema.json").read_text().startswith("{")
    assert (place / "creep" / "sweep.csv").read_text().count("\n") == 9


def test_scripts(tmp_path: Path) -> None:
    """The recipes for scripts and CI, with a coarser case; a drift that is there is found."""
    (tmp_path / "cases").mkdir()
    case = (ROOT / "cases" / "article_4_1.toml").read_text()
    script = SHELL[1].replace("numerics.grid=64", "numerics.grid=16")
    assert GRID in case and script != SHELL[1]
    (tmp_path / "cases" / "article_4_1.toml").write_text(case.replace(GRID, "grid = 16\n"))
    commands = []
    for line, words in lines(script, tmp_path):
        commands.append(words)
        done = call(*words, cwd=tmp_path)
        assert done.returncode == 0, (line, done.stderr)
    assert (tmp_path / "speeds.jsonl").read_text().count("\n") == 3
    assert (tmp_path / "speeds" / "sweep.png").exists()
    again, compared = commands[-2:]
    assert call(*again, "--set", "load.friction_coefficient=0.31", cwd=tmp_path).returncode == 0
    done = call(*compared, cwd=tmp_path)
    assert (done.returncode, "outside" in done.stdout) == (6, True)


def test_python(place: Path) -> None:
    heat, pressure = run([sys.executable, "-c", PYTHON], place).stdout.split()
    assert 5.0 < float(heat) < 6.0 and float(pressure) > 9e8
