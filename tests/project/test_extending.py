"""The example of add_a_stage.md, followed line by line on a copy of the package."""

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
PAGE = (Path(__file__).parent / "add_a_stage.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```diff\n--- (\S+)\n(.*?)```", PAGE, re.DOTALL)


def edited(text: str, block: str) -> str:
    """`text` with one block of the document made: its lines without + are found exactly once."""
    lines = block.splitlines()
    before = "".join(f"{line[1:]}\n" for line in lines if not line.startswith("+"))
    after = "".join(f"{line[1:]}\n" for line in lines if not line.startswith("-"))
    assert text.count(before) == 1, f"where is this?\n{before}"
    return text.replace(before, after)


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the package as the document leaves it."""
    folder = tmp_path_factory.mktemp("extended")
    shutil.copytree(ROOT / "thermoroll_cli", folder / "thermoroll_cli")  # what has been compiled, too
    for path, block in BLOCKS:
        file = folder / path
        file.write_text(edited(file.read_text(), block))
    return folder


def test_the_example_goes_the_whole_way(place: Path) -> None:
    """From the case file to the scalar, the field's picture and the plan: the rate is k times the frictional heat."""
    case = (str(ROOT / "cases" / "article_4_1.toml"), "--set", "load.debris_coefficient_m3_J=1e-13", "--json")
    commands = [["run", *case, "--set", "numerics.grid=16", "--no-plots"],
                ["plot", "results/article_4_1.h5", "--fields", "debris_rate", "-q"], ["show", *case]]  # fmt: skip
    program = f"from thermoroll_cli.cli.main import main\nfor words in {commands!r}:\n    assert main(words) == 0"
    environment = {**os.environ, "PYTHONPATH": str(place)}
    command = [sys.executable, "-c", program]
    done = subprocess.run(command, cwd=place, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    solved, shown = map(json.loads, done.stdout.splitlines())
    # Declared as an integral, it is extrapolated from three grids as the heat is, and has its error.
    assert solved["debris_rate_mm3_s"] == pytest.approx(1e-4 * solved["Q_F_W"], rel=1e-9)
    assert solved["uncertainty"]["debris_rate_mm3_s"] == pytest.approx(1e-4 * solved["uncertainty"]["Q_F_W"])
    assert solved["debris_rate_mm3_s"] != solved["isothermal"]["debris_rate_mm3_s"]
    assert (place / "results" / "article_4_1_debris_rate.png").stat().st_size > 10_000
    assert "debris" in shown["run"]
    assert shown["inputs"]["load.debris_coefficient_m3_J"]["si"] == 1e-13
