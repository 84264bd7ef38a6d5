"""Commands end alike: the same options, the same exit codes."""

from __future__ import annotations

import inspect
import json
from pathlib import Path

import pytest
from PIL import Image

from tests.support.command_line import MECHANICAL, call
from thermoroll_cli.cli import conicity, fit, run, sweep_command, wear

CASES = Path(__file__).parents[2] / "cases"


@pytest.mark.parametrize("command", [run.run, sweep_command.sweep, fit.fit, wear.wear, conicity.conicity])
def test_commands_that_compute_have_the_same_options(command: object) -> None:
    declared = " ".join(str(value.annotation) for value in inspect.signature(command).parameters.values())  # type: ignore
    for name in ("Output", "Settings", "AsJson", "NoPlots", "Formats", "Dpi", "Report", "Quiet", "Verbose"):
        assert f"options.{name}" in declared, name


@pytest.mark.slow
def test_conicity_takes_them(tmp_path: Path) -> None:
    done = call("conicity", CASES / "manchester.toml", "--amplitude", "3:4:2", "-v", "--dpi", 50, "--report", "-o", tmp_path)
    assert done.returncode == 0, done.stderr
    with Image.open(tmp_path / "manchester_conicity.png") as image:
        assert round(image.info["dpi"][0]) == 50
    assert "manchester_conicity_report.html" in done.stdout


def test_a_command_that_finds_no_number_says_so(tmp_path: Path) -> None:
    """An amplitude beyond the flanges; a case without the table of its command."""
    far = ("--amplitude", "40", "--no-plots", "-o", tmp_path)
    done = call("conicity", CASES / "manchester.toml", *far, "--json")
    assert done.returncode == 4 and "no amplitude has an equivalent conicity" in done.stderr
    assert set(json.loads(done.stdout)["conicity"]) == {None}
    (tmp_path / "case.toml").write_text(MECHANICAL)
    for command, words in (("wear", "does not say how far the profiles wear"), ("conicity", "no equivalent conicity")):
        done = call(command, tmp_path / "case.toml", "--json", "-o", tmp_path)
        assert done.returncode == 3 and words in done.stderr
        assert json.loads(done.stdout)["errors"][0]["key"] in ("wear", "geometry")
