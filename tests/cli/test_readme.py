"""The README's own commands, verbatim."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text()
SHELL = [block for block in re.findall(r"```sh\n(.*?)```", README, re.DOTALL) if "thermoroll " in block]
(PYTHON,) = re.findall(r"```python\n(.*?)```", README, re.DOTALL)


@pytest.fixture
def place(tmp_path: Path) -> Path:
    (tmp_path / "cases").symlink_to(ROOT / "cases")
    return tmp_path


def run(command: list[str], place: Path) -> subprocess.CompletedProcess[str]:
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    done = subprocess.run(command, cwd=place, env={**os.environ, "PATH": path}, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    return done


def test_commands(place: Path) -> None:
    """Every command of the section on commands, in order, as one script that stops at the first failure."""
    run(["bash", "-eu", "-c", SHELL[0]], place)
    for name in ("my_case.h5", "my_case_pressure.png", "my_case_pressure.svg", "my_case.xdmf"):
        assert (place / "results" / name).exists(), name
    assert (place / "creep" / "sweep.csv").read_text().count("\n") == 9


def test_scripts(place: Path) -> None:
    """The recipes for scripts and CI; a drift that is there is found."""
    run(["bash", "-eu", "-c", SHELL[1]], place)
    assert (place / "speeds.jsonl").read_text().count("\n") == 3
    drifted = SHELL[1].splitlines()[-2].replace("-o build", "-o build --set load.friction_coefficient=0.31")
    assert "run" in drifted
    run(["bash", "-eu", "-c", drifted], place)
    with pytest.raises(AssertionError, match="outside"):
        run(["bash", "-eu", "-c", SHELL[1].splitlines()[-1]], place)


def test_python(place: Path) -> None:
    heat, pressure = run([sys.executable, "-c", PYTHON], place).stdout.split()
    assert 5.0 < float(heat) < 6.0 and float(pressure) > 9e8
