"""Faults that the tests of single commands leave out: see docs/developing.md, Faults."""

from __future__ import annotations

import io
import os
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from tests.support.command_line import COMMAND, MECHANICAL, PATIENCE, call, environment, limited
from thermoroll_cli.cli.main import main
from thermoroll_cli.files.result.outcome import read_result

QUICK = ("run", "case.toml", "--no-plots", "-q")
ROOT = Path(__file__).parents[2]
NOBODY = 65534


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with a case in it."""
    (tmp_path / "case.toml").write_text(MECHANICAL)
    return tmp_path


def names(path: Path) -> set[str]:
    """What a listing of `path` shows; hidden files are nobody's result."""
    return {item.name for item in path.iterdir() if not item.name.startswith(".")} if path.exists() else set()


def leftovers(path: Path) -> list[str]:
    return [item.name for item in path.iterdir() if item.name.startswith(".")] if path.exists() else []


# --- signals --------------------------------------------------------------------------------------------------------

HELD = """
import os, sys, time
from thermoroll_cli.cli.main import main
from thermoroll_cli.tools import process
from thermoroll_cli.tools import atomic

held = getattr(atomic.os, {step!r})

def hold(*arguments):
    print("writing", flush=True)
    for _ in range(6000):
        time.sleep(0.01)
        if process.noted():  # what must not be disturbed goes on
            return held(*arguments)

setattr(atomic.os, {step!r}, hold)
sys.exit(main())
"""


@contextmanager
def writing(folder: Path, step: str, *arguments: str) -> Iterator[subprocess.Popen[str]]:
    """A process that runs the case and has got as far as `step` of writing its file."""
    process = subprocess.Popen(
        [sys.executable, "-c", HELD.format(step=step), *arguments],
        cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment({}),
    )  # fmt: skip
    assert process.stdout is not None
    assert process.stdout.readline() == "writing\n"
    try:
        yield process
    finally:
        process.kill()
        process.communicate()


@pytest.mark.slow
@pytest.mark.parametrize(("name", "code", "step"), [
    pytest.param("SIGHUP", 129, "replace", marks=pytest.mark.slow), ("SIGKILL", -9, "fsync")])
def test_signals_while_a_file_is_written(name: str, code: int, step: str, folder: Path) -> None:
    """What has the name of a result is whole: the new file, which is finished first, or the old one after SIGKILL."""
    results = folder / "results"
    results.mkdir()
    (results / "case.h5").write_bytes(b"old")
    with writing(folder, step, *QUICK) as process:
        process.send_signal(getattr(signal, name))
        out, err = process.communicate(timeout=PATIENCE)
        assert process.returncode == code
    assert "Traceback" not in err and out == ""
    assert names(results) == {"case.h5"}
    if name != "SIGKILL":  # which leaves a process no time to clean up
        assert name in err and leftovers(results) == []
    else:
        assert (results / "case.h5").read_bytes() == b"old"
        assert call(*QUICK, cwd=folder).returncode == 0
    assert read_result(results / "case.h5").converged


# --- disks ----------------------------------------------------------------------------------------------------------


def test_no_room_for_a_result(folder: Path) -> None:
    done = limited(folder, 4096, "run", "case.toml", "--no-plots", "--json")
    assert done.returncode == 5
    assert "cannot write results/case.h5" in done.stderr
    assert '"files": []' in done.stdout and '"status": "converged"' in done.stdout  # what was computed is not lost
    assert names(folder / "results") == set() and leftovers(folder / "results") == []


def test_no_room_for_other_files(folder: Path) -> None:
    assert call(*QUICK, cwd=folder).returncode == 0
    before = (folder / "results" / "case.h5").read_bytes()
    for arguments in (
        ["plot", "results/case.h5", "--fields", "pressure"], ["export", "results/case.h5", "--format", "csv"],
        ["init", "new.toml"]):
        done = limited(folder, 512, *arguments)
        assert (done.returncode, done.stdout) == (5, ""), arguments
        assert "cannot write" in done.stderr
    assert names(folder / "results") == {"case.h5"} and names(folder) == {"case.toml", "results"}
    assert leftovers(folder) == leftovers(folder / "results") == []
    assert (folder / "results" / "case.h5").read_bytes() == before


def test_no_room_for_a_picture_keeps_the_result(folder: Path) -> None:
    assert call(*QUICK, cwd=folder).returncode == 0
    size = (folder / "results" / "case.h5").stat().st_size
    done = limited(folder, size + 64, "run", "case.toml", "-o", "tight", "--dpi", "120")
    assert (done.returncode, "cannot write tight" in done.stderr) == (5, True)
    assert read_result(folder / "tight" / "case.h5").converged
    assert leftovers(folder / "tight") == []
    for name in names(folder / "tight") - {"case.h5"}:
        assert (folder / "tight" / name).read_bytes().endswith(b"IEND\xaeB`\x82"), "a whole picture"


@pytest.fixture
def shared() -> Iterator[Path]:
    """A folder that every user of this machine can reach."""
    path = Path(tempfile.mkdtemp())
    path.chmod(0o755)
    yield path
    shutil.rmtree(path)


AS_NOBODY = """
import os
from tests.support.command_line import call

# Before as ourselves: nobody else may be able to read the program, which loads modules when needed.
for place, code in (("open", 0), ("case.toml/below", 5)):
    assert call("run", "case.toml", "--no-plots", "-o", place).returncode == code, place
if os.geteuid() == 0:  # root may write anywhere
    os.setegid({nobody})
    os.seteuid({nobody})
done = call("run", "case.toml", "--no-plots", "-o", "locked")
assert (done.returncode, done.stdout) == (5, ""), done
assert "locked" in done.stderr and "bug" not in done.stderr and "Traceback" not in done.stderr, done
"""


@pytest.mark.slow
def test_read_only_folder(shared: Path) -> None:
    """In a process of its own: who has become somebody else may be unable to come back, to the folder to begin with."""
    (shared / "case.toml").write_text(MECHANICAL.replace("grid = 16", "grid = 8"))
    (shared / "locked").mkdir(mode=0o555)
    done = subprocess.run(
        [sys.executable, "-c", AS_NOBODY.format(nobody=NOBODY)], cwd=shared, env=environment({"PYTHONPATH": str(ROOT)}),
        capture_output=True, text=True, timeout=PATIENCE)  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert list((shared / "locked").iterdir()) == []


# --- inputs ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("command", [["run"], ["show"], ["validate"], ["sweep", "--over", "load.normal_N=1,2"]])
def test_case_files_that_are_no_text(command: list[str], tmp_path: Path) -> None:
    (tmp_path / "latin.toml").write_bytes(MECHANICAL.replace("Two", "Zwölf").encode("latin-1"))
    done = call(command[0], "latin.toml", *command[1:], cwd=tmp_path)
    assert (done.returncode, done.stdout) == (3, "")
    assert "latin.toml:1:" in done.stderr and "not UTF-8 text" in done.stderr
    assert names(tmp_path) == {"latin.toml"}


class Endless(io.RawIOBase):
    """A pipe that always has another comment."""

    def readable(self) -> bool:
        return True

    def readinto(self, buffer: bytearray) -> int:  # type: ignore[override]
        buffer[:] = (b"# more\n" * (len(buffer) // 7 + 1))[: len(buffer)]
        return len(buffer)


def test_a_case_without_end(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """Refused without being read to its end, from a file (a hole of a terabyte) or a pipe, whatever it holds."""
    huge = tmp_path / "huge.toml"
    huge.write_text(MECHANICAL)
    os.truncate(huge, 2**40)
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BufferedReader(Endless())))
    for name in (str(huge), "-"):
        assert main(["run", name]) == 3
        told = capsys.readouterr()
        assert told.out == "" and "too large" in told.err
    assert names(tmp_path) == {"huge.toml"}


def test_a_result_cut_anywhere(folder: Path) -> None:
    assert call(*QUICK, cwd=folder).returncode == 0
    whole = (folder / "results" / "case.h5").read_bytes()
    (folder / "foreign.h5").write_bytes(b"\x89HDF\r\n\x1a\n" + bytes(2000))
    for share in (0.0, 0.1, 0.999):
        (folder / "cut.h5").write_bytes(whole[: int(share * len(whole))])
        for arguments in (
            ["plot", "cut.h5"], ["plot", "foreign.h5"], ["compare", "results/case.h5", "cut.h5"],
            ["compare", "foreign.h5", "results/case.h5"], ["export", "cut.h5", "--format", "xdmf"],
            ["run", "--from", "cut.h5"]):
            done = call(*arguments, cwd=folder, painted=True)
            assert (done.returncode, done.stdout) == (5, ""), (share, arguments)
            assert ".h5" in done.stderr and "Traceback" not in done.stderr and "bug" not in done.stderr
    assert names(folder) == {"case.toml", "cut.h5", "foreign.h5", "results"}


@pytest.mark.slow
def test_odd_names_everywhere(tmp_path: Path) -> None:
    place = tmp_path / "Ordner mit Leerzeichen – 漢字 🚂"
    place.mkdir()
    (place / "fälle #1 (µ=0.3).toml").write_text(MECHANICAL.replace("Two spheres", "Zwei Kugeln µ"), encoding="utf-8")
    case, out = place / "fälle #1 (µ=0.3).toml", place / "aus gabe"
    sweep = ("sweep", case, "--over", "creepage.longitudinal=1e-3,2e-3", "-o", place / "swe ep")
    assert call("run", case, "--no-plots", "-o", out).returncode == 0
    for arguments in ((*sweep, "--no-plots"), (*sweep, "--resume")):
        assert call(*arguments).returncode == 0
    assert (place / "swe ep" / "sweep.png").exists()
    result = out / "fälle #1 (µ=0.3).h5"
    assert read_result(result).problem.title == "Zwei Kugeln µ"
    assert call("plot", result, "--fields", "pressure").returncode == 0
    assert call("compare", result, result).returncode == 0
    assert call("export", result, "--format", "xdmf").returncode == 0
    assert [path.suffix for path in sorted(out.iterdir())] == [".h5", ".xdmf", ".hdf5", ".png"]


# --- surroundings ---------------------------------------------------------------------------------------------------


SWEEP = ("sweep", "case.toml", "--over", "load.normal_N=60,65")
"""Which draws one picture."""


@pytest.mark.slow
def test_no_terminal_and_no_home_at_all(folder: Path) -> None:
    """As started by cron: a session without a terminal, nothing on standard input, hardly any environment."""
    done = subprocess.run(
        [*COMMAND, *SWEEP], cwd=folder, stdin=subprocess.DEVNULL, capture_output=True, text=True, start_new_session=True,
        env={"PATH": os.defpath},
    )  # fmt: skip
    assert done.returncode == 0 and "2 of 2 points converged" in done.stdout
    assert (folder / "results" / "sweep.png").exists()
    assert all(character not in done.stdout + done.stderr for character in "\x1b\r")
