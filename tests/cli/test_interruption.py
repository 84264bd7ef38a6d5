"""Stopping by signals: noted at once, acted upon at the next step, and never lost in code that drops exceptions."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import time
import weakref
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import pytest

from tests.support.command_line import MECHANICAL, PATIENCE
from tests.support.scenes import rolling
from thermoroll_cli.python_api import solve
from thermoroll_cli.studies.creep_table.build import journal_path
from thermoroll_cli.tools import process
from thermoroll_cli.tools.process import Interrupted, safe_point, stoppable

ROOT = Path(__file__).parents[2]


@pytest.fixture
def caught() -> Iterator[None]:
    """Signals that have us stop, as they do while a command runs."""
    with stoppable():
        yield


@pytest.mark.usefixtures("caught")
def test_a_signal_inside_a_callback_is_not_lost() -> None:
    """Whatever a callback of a weak reference raises is dropped: the signal shows at the next safe point, and only there."""

    class Thing:
        pass

    thing = Thing()
    called: list[object] = []
    reference = weakref.ref(thing, lambda _: (os.kill(os.getpid(), signal.SIGTERM), called.append(1)))
    del thing
    assert called and reference() is None
    with pytest.raises(Interrupted) as stop:
        safe_point()
    assert stop.value.number == signal.SIGTERM
    safe_point()  # on the way out nothing is disturbed any more
    assert process.noted() == signal.SIGTERM


@pytest.mark.usefixtures("caught")
def test_every_step_of_a_solver_is_a_safe_point(monkeypatch: pytest.MonkeyPatch) -> None:
    """A signal that comes in the tenth transform ends the solution before the eleventh."""
    from thermoroll_cli.physics.numerics import convolution

    steps: list[int] = []

    def step() -> None:
        steps.append(len(steps))
        safe_point()
        if len(steps) == 10:
            os.kill(os.getpid(), signal.SIGINT)

    monkeypatch.setattr(convolution, "safe_point", step)
    with pytest.raises(Interrupted):
        solve(rolling(grid=32, creepage=(1e-3, 0.0)))
    assert len(steps) == 11


@pytest.mark.usefixtures("caught")
def test_a_second_signal_ends_the_process_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    ended: list[int] = []
    monkeypatch.setattr(process.os, "_exit", ended.append)
    os.kill(os.getpid(), signal.SIGINT)
    assert ended == []
    os.kill(os.getpid(), signal.SIGTERM)
    assert ended == [130]


@pytest.mark.parametrize("number", [signal.SIGHUP, signal.SIGINT])
def test_signals_that_are_ignored_stay_so_and_handlers_come_back(number: signal.Signals) -> None:
    """As under nohup (HUP), and in the background of a script (INT)."""
    before = signal.signal(number, signal.SIG_IGN)
    handlers = [signal.getsignal(number) for number in process.SIGNALS]
    try:
        with stoppable():
            os.kill(os.getpid(), number)
            safe_point()
            assert process.noted() == 0
        assert [signal.getsignal(number) for number in process.SIGNALS] == handlers
    finally:
        signal.signal(number, before)


@contextmanager
def started(folder: Path, *arguments: str, **streams: int) -> Iterator[subprocess.Popen[str]]:
    """The command in a group of processes of its own, all of which are gone afterwards."""
    process = subprocess.Popen(
        [sys.executable, "-m", "thermoroll_cli", *arguments], cwd=folder, text=True, start_new_session=True,
        **{"stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE, **streams},
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    try:
        yield process
    finally:
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.communicate()


def test_a_run_stops_with_the_code_of_the_signal(tmp_path: Path) -> None:
    """SIGINT; what comes while a file is written is SIGHUP and SIGTERM (test_faults.py)."""
    (tmp_path / "case.toml").write_text(MECHANICAL)
    with started(tmp_path, "run", "case.toml", "-v", "--set", "numerics.grid=512") as run:
        assert run.stderr is not None and run.stderr.readline().startswith("case: ")  # it is at work
        run.send_signal(signal.SIGINT)
        out, told = run.communicate(timeout=PATIENCE)
    assert (run.returncode, out) == (130, "")
    assert "stopped by SIGINT" in told and no_fault(told)
    assert not (tmp_path / "results").exists() or not list((tmp_path / "results").iterdir())


@pytest.mark.slow
def test_a_table_in_several_processes_stops_and_keeps_its_journal(tmp_path: Path) -> None:
    """The signal reaches the first process alone, which ends the others."""
    small = ("--aspect", "1", "--accuracy", "1e-2", "--nodes", "8,7,7", "--checks", "100", "-o", "table.h5")
    journal = journal_path(tmp_path / "table.h5")
    with started(tmp_path, "table", "build", *small, "--jobs", "2") as build:
        deadline = time.monotonic() + PATIENCE
        while not (journal.exists() and journal.stat().st_size):
            assert time.monotonic() < deadline and build.poll() is None
            time.sleep(0.005)
        build.send_signal(signal.SIGTERM)
        out, told = build.communicate(timeout=PATIENCE)  # which waits for all processes that have these streams
    assert (build.returncode, out) == (143, "")
    assert no_fault(told)
    assert list(tmp_path.iterdir()) == [journal]


@pytest.mark.slow
def test_whoever_waits_for_others_can_be_stopped(tmp_path: Path) -> None:
    """Here for standard input."""
    with started(tmp_path, "validate", "-", stdin=subprocess.PIPE) as waiting:
        # Asleep, and not for a moment only: it waits.
        deadline, asleep = time.monotonic() + PATIENCE, 0
        while asleep < 30:
            assert time.monotonic() < deadline and waiting.poll() is None
            asleep = asleep + 1 if catches(waiting.pid, signal.SIGTERM) and asleep_now(waiting.pid) else 0
            time.sleep(0.01)
        waiting.send_signal(signal.SIGTERM)
        _, told = waiting.communicate(timeout=PATIENCE)
    assert waiting.returncode == 143 and "Traceback" not in told


def no_fault(told: str) -> bool:
    return not any(words in told for words in ("Traceback", "Exception ignored", "bug in thermoroll"))


def catches(pid: int, number: signal.Signals) -> bool:
    """Whether the process `pid` handles the signal `number` itself."""
    (caught,) = re.findall(r"(?m)^SigCgt:\s*(\w+)", Path(f"/proc/{pid}/status").read_text())
    return bool(int(caught, 16) >> (number - 1) & 1)


def asleep_now(pid: int) -> bool:
    return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] == "S"


def test_a_signal_during_the_first_imports_leaves_no_trace() -> None:
    program = """
import os, signal, sys
class Interrupting:
    def find_spec(self, name, *_):
        if name == "typer":
            os.kill(os.getpid(), signal.SIGINT)
sys.meta_path.insert(0, Interrupting())
from thermoroll_cli.__main__ import main
main()
"""
    done = subprocess.run([sys.executable, "-c", program, "--version"], capture_output=True, text=True, timeout=PATIENCE,
                          env={**os.environ, "PYTHONPATH": str(ROOT)})  # fmt: skip
    assert (done.returncode, done.stdout, done.stderr) == (-signal.SIGINT, "", "")


def test_a_signal_after_the_last_word_counts() -> None:
    """While libraries put their things away, when all is done."""
    program = (
        "import atexit, time; from thermoroll_cli.__main__ import main; "
        "atexit.register(lambda: (print('late', flush=True), time.sleep(300))); main()"
    )
    command = [sys.executable, "-c", program, "--version"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env={**os.environ, "PYTHONPATH": str(ROOT)}) as process:
        assert process.stdout is not None
        assert [process.stdout.readline().split()[0] for _ in range(2)] == ["thermoroll", "late"]
        process.send_signal(signal.SIGINT)
        assert process.wait(timeout=PATIENCE) in (130, -signal.SIGINT)
