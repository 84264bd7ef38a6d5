"""What each command refuses: its exit code and the words of its message, and nothing is written, on standard output neither.
Commands end alike: the same options, the same exit codes."""

from __future__ import annotations

import inspect
import json
import shlex
from pathlib import Path

import pytest
from PIL import Image

from tests.support import synthetic
from tests.support.command_line import MECHANICAL, call
from tests.support.documents import ROOT
from thermoroll_cli import Case, solve
from thermoroll_cli.cli import conicity, fit, run, sweep_command, wear
from thermoroll_cli.files.result.outcome import write_result

ROWS = json.loads((ROOT / "tests" / "reference" / "refused_commands.json").read_text(encoding="utf-8"))
"""Command, exit code and words. All points of a sweep are checked before the first is solved."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A case and a result of one name, also in another folder; that of a line, an invalid case, a table that is none, a file
    without content."""
    folder = tmp_path_factory.mktemp("refused")
    (folder / "other").mkdir()
    for place in (folder, folder / "other"):
        (place / "a.toml").write_text(MECHANICAL)
        write_result(place / "a.h5", synthetic.result((24, 24)))
    (folder / "bad.toml").write_text(MECHANICAL.replace("0.28", "0.6"))
    (folder / "other.csv").write_text("a,b\n1,2\n")
    (folder / "file").write_text("")
    (folder / "cases").symlink_to(ROOT / "cases")
    solve(Case.read(ROOT / "cases" / "gear_pair.toml").with_values({"numerics.grid": 8})).save(folder / "line.h5")
    return folder


@pytest.mark.parametrize(("command", "code", "words"), ROWS)
def test_what_is_refused(folder: Path, command: str, code: int, words: list[str]) -> None:
    before = sorted(folder.rglob("*"))
    done = call(*shlex.split(command), cwd=folder)
    told = " ".join(done.stderr.split())
    assert (done.returncode, done.stdout) == (code, ""), told
    assert all(each in told for each in words) and told.count("unknown key") <= 1, told
    assert sorted(folder.rglob("*")) == before


@pytest.mark.parametrize("command", [run.run, sweep_command.sweep, fit.fit, wear.wear, conicity.conicity])
def test_commands_that_compute_have_the_same_options(command: object) -> None:
    declared = " ".join(str(value.annotation) for value in inspect.signature(command).parameters.values())  # type: ignore
    for name in ("Output", "Settings", "AsJson", "NoPlots", "Formats", "Dpi", "Report", "Quiet"):
        assert f"options.{name}" in declared, name
    assert "options.Verbose" in declared or "options.Trace" in declared  # who shows no grids has the trace of a bug


@pytest.mark.slow
def test_conicity_takes_them(tmp_path: Path) -> None:
    asked = ("--amplitude", "3:4:2", "-v", "--dpi", 50, "--report", "-o", tmp_path)
    done = call("conicity", ROOT / "cases" / "manchester.toml", *asked)
    assert done.returncode == 0, done.stderr
    with Image.open(tmp_path / "manchester_conicity.png") as image:
        assert round(image.info["dpi"][0]) == 50
    assert "manchester_conicity_report.html" in done.stdout


def test_a_command_that_finds_no_number_says_so(tmp_path: Path) -> None:
    """An amplitude beyond the flanges; a case without the table of its command."""
    far = ("--amplitude", "40", "--no-plots", "-o", tmp_path)
    done = call("conicity", ROOT / "cases" / "manchester.toml", *far, "--json")
    assert done.returncode == 4 and "no amplitude has an equivalent conicity" in done.stderr
    assert set(json.loads(done.stdout)["conicity"]) == {None}
    (tmp_path / "case.toml").write_text(MECHANICAL)
    for command, words in (("wear", "does not say how far the profiles wear"), ("conicity", "no equivalent conicity")):
        done = call(command, tmp_path / "case.toml", "--json", "-o", tmp_path)
        assert done.returncode == 3 and words in done.stderr
        assert json.loads(done.stdout)["errors"][0]["key"] in ("wear", "geometry")
