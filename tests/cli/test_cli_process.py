"""The command as a process: start-up, signals, closed and full outputs, odd environments."""

from __future__ import annotations

import os
import shlex
import subprocess
import sys
from pathlib import Path
from unittest import mock

import pytest

from tests.support.command_line import COMMAND, MECHANICAL, call, on_terminal, thermoroll
from thermoroll_cli.cli import streams
from thermoroll_cli.cli.commands import COMMANDS
from thermoroll_cli.cli.main import main
from thermoroll_cli.files.result.outcome import read_result


def test_help_version_and_bare_command() -> None:
    done = subprocess.run([sys.executable, "-m", "thermoroll_cli", "-h"], capture_output=True, text=True)
    assert (done.returncode, done.stdout, done.stderr) == (0, call("--help").stdout, "")
    for command, (_, about) in COMMANDS.items():
        assert f"  {command.ljust(9)} {about}\n" in done.stdout
        of_command = call(command, "--help")
        assert of_command.returncode == 0 and about.rstrip(".").split(",")[0] in of_command.stdout
    assert call("--version").stdout.startswith("thermoroll 0.")
    bare = call()
    assert (bare.returncode, bare.stdout) == (2, "")
    assert "Commands:" in bare.stderr


def test_a_reader_that_goes_away_loses_no_result(tmp_path: Path) -> None:
    """`thermoroll run … | head -n 1`: results are written before they are printed."""
    (tmp_path / "case.toml").write_text(MECHANICAL)
    reading, writing = os.pipe()
    os.close(reading)
    command = [*COMMAND, "run", "case.toml", "-q", "--json", "--no-plots"]
    done = subprocess.run(command, cwd=tmp_path, stdout=writing, stderr=subprocess.PIPE, text=True)
    assert (done.returncode, done.stderr) == (141, "")
    os.close(writing)
    assert [path.name for path in (tmp_path / "results").iterdir()] == ["case.h5"]
    assert read_result(tmp_path / "results" / "case.h5").converged


def test_standard_streams_may_be_missing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "case.toml").write_text(MECHANICAL)
    # Files that are opened then have the numbers of the streams.
    done = subprocess.run(["sh", "-c", f"{shlex.join(COMMAND)} run case.toml --no-plots >&- 2>&- <&-"], cwd=tmp_path)
    assert done.returncode == 0 and read_result(tmp_path / "results" / "case.h5").converged
    for stream, arguments, code, words in (
        ("stdout", [str(tmp_path / "case.toml"), "--json"], 5, "cannot write to standard output: it is closed"),
        ("stdin", ["-"], 3, "<stdin>"),
    ):
        with monkeypatch.context() as patch:
            patch.setattr(sys, stream, None)
            assert main(["validate", *arguments]) == code
        assert words in capsys.readouterr().err


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="needs /dev/full")
def test_full_disk_behind_standard_output() -> None:
    with open("/dev/full", "w") as full:
        done = subprocess.run([*COMMAND, "--help"], stdout=full, stderr=subprocess.PIPE, text=True)
    assert done.returncode == 5 and "No space left" in done.stderr and "Traceback" not in done.stderr


def test_terminals_and_names_without_unicode(tmp_path: Path) -> None:
    """Linux allows any bytes in a name."""
    case = tmp_path / os.fsdecode(b"k\xf6rper.toml")
    try:
        case.write_text(MECHANICAL)
    except OSError:
        case = tmp_path / "case.toml"  # this file system wants Unicode
        case.write_text(MECHANICAL)
    ascii_only = {"LC_ALL": "C", "PYTHONCOERCECLOCALE": "0", "PYTHONUTF8": "0", "PYTHONIOENCODING": "ascii"}
    done = thermoroll("run", case, "--no-plots", "-o", tmp_path, env=ascii_only)
    assert done.returncode == 0 and " +- " in done.stdout and "16x16" in done.stdout and done.stdout.isascii()
    assert read_result(case.with_suffix(".h5")).converged


def test_what_came_from_outside_does_not_steer_a_terminal(tmp_path: Path) -> None:
    """Names of files and words on a command line may hold escape sequences, here one that changes a window's title."""
    name, replaced = "a\x1b]0;title\x07", "a\N{REPLACEMENT CHARACTER}]0;title\N{REPLACEMENT CHARACTER}"
    (tmp_path / f"{name}.toml").write_text(MECHANICAL)
    shown = on_terminal(["run", f"{name}.toml", "--no-plots"], tmp_path)
    assert f"results/{replaced}.h5" in shown
    assert "\x1b[2K" in shown and "\x1b]0" not in shown and "\x07" not in shown
    result = f"results/{name}.h5"
    for arguments, code in ((["compare", result, result], 0), (["export", result, "--format", "csv"], 0),
                            (["plot", result, "--fields", "pressure"], 0), (["report", result], 0),
                            (["show", f"{name}.toml"], 0), (["validate", f"{name}.toml"], 0),
                            (["sweep", f"{name}.toml", "--over", "load.normal_N=60,65", "--no-plots"], 0),
                            (["plot", f"{name}.toml"], 2), ([name], 2), (["run", name], 3), (["compare", name, result], 5)):
        done = call(*arguments, cwd=tmp_path)
        assert done.returncode == code, (arguments, done.stderr)
        assert "\x1b" not in done.stdout + done.stderr and "\x07" not in done.stdout + done.stderr, arguments


def test_colour_and_progress_on_terminals_only_and_never_with_no_color(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "bad.toml").write_text("load = 3\n")
    assert "\x1b" not in call("validate", "bad.toml", cwd=tmp_path).stderr
    terminal = mock.Mock(isatty=lambda: True)
    for variables, shown in (({"TERM": "xterm"}, (True, True)), ({"NO_COLOR": "1"}, (True, False)),
                             ({"TERM": "dumb", "NO_COLOR": ""}, (False, False))):  # fmt: skip
        for name, value in variables.items():
            monkeypatch.setenv(name, value)
        assert (streams.is_terminal(terminal), streams.coloured(terminal)) == shown
    monkeypatch.setattr(streams, "is_terminal", lambda stream: True)
    assert "\x1b[1;31merror:" in call("validate", "bad.toml", cwd=tmp_path).stderr


def test_completion_is_offered() -> None:
    for run, words, offered in ((thermoroll, "va", "validate"), (call, "table q", "query"),
                                (call, "init --example man", "manchester"),
                                (call, "run --set load.n", "load.normal_N=\nload.normal_N_mm=")):
        with mock.patch.dict(os.environ, {"_THERMOROLL_COMPLETE": "complete_bash", "COMP_WORDS": f"thermoroll {words}",
                                          "COMP_CWORD": str(len(words.split()))}):
            assert run().stdout.strip() == offered


def test_a_bug_is_told_as_such_and_too_little_memory_is_none(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    (tmp_path / "case.toml").write_text(MECHANICAL)
    for cause, code, words, traced in ((ZeroDivisionError("by nothing"), 1, "this is a bug in thermoroll, please report it: "
                                        "ZeroDivisionError: by nothing", True), (MemoryError(), 5, "not enough memory", False)):
        monkeypatch.setattr("thermoroll_cli.cli.run.Solver.solve", mock.Mock(side_effect=cause))
        for extra in ((), ("-v",)):
            done = call("run", "case.toml", *extra, cwd=tmp_path)
            assert (done.returncode, done.stdout) == (code, "") and words in done.stderr
            assert ("Traceback" in done.stderr) is (traced and bool(extra))
