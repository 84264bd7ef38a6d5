"""Stopping by signals: noted at once, acted upon at the next step, and never lost in code that drops exceptions."""

from __future__ import annotations

import fcntl
import os
import signal
import subprocess
import sys
import time
import weakref
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.support.command_line import PATIENCE
from tests.support.scenes import rolling
from tests.support.stops import ROOT, SIGNALS, catches, stopped
from thermoroll_cli import process
from thermoroll_cli.process import Interrupted, safe_point, stoppable
from thermoroll_cli.refinement.solve import solve


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
    from thermoroll_cli.numerics import convolution

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


def test_signals_that_are_ignored_stay_so_and_handlers_come_back() -> None:
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    handlers = [signal.getsignal(number) for number in process.SIGNALS]
    try:
        with stoppable():
            os.kill(os.getpid(), signal.SIGHUP)
            safe_point()
            assert process.noted() == 0
        assert [signal.getsignal(number) for number in process.SIGNALS] == handlers
    finally:
        signal.signal(signal.SIGHUP, before)


@pytest.mark.parametrize(("program", "moment", "number"), [
    *(("run", 0.3, number) for number in SIGNALS), ("sweep", 0.7, signal.SIGTERM),
    ("sweep --jobs 2", 0.6, signal.SIGINT), ("sweep --jobs 2", 0.6, signal.SIGTERM),
    ("table", 0.4, signal.SIGTERM), ("table --jobs 2", 0.6, signal.SIGINT),
])  # fmt: skip
def test_programs_stop_with_their_code_and_leave_nothing(program: str, moment: float, number: signal.Signals) -> None:
    """At work, and in processes that they have started."""
    assert stopped(program, number, moment) == ()


@pytest.mark.parametrize("command", [["validate", "-"], ["validate", "pipe.toml"], ["schema"]])
def test_whoever_waits_for_others_can_be_stopped(command: list[str], tmp_path: Path) -> None:
    """For standard input, for a named pipe that nobody opens, and for a reader that does not read."""
    os.mkfifo(tmp_path / "pipe.toml")
    read_end, write_end = os.pipe()
    fcntl.fcntl(write_end, fcntl.F_SETPIPE_SZ, 4096)  # the schema is larger
    process = subprocess.Popen(
        [sys.executable, "-m", "thermoroll_cli", *command], cwd=tmp_path, stdin=subprocess.PIPE, stdout=write_end,
        stderr=subprocess.PIPE, text=True, env={**os.environ, "PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    os.close(write_end)
    # Asleep, and not for a moment only: it waits.
    deadline, asleep = time.monotonic() + PATIENCE, 0
    while asleep < 30:
        assert time.monotonic() < deadline and process.poll() is None
        asleep = asleep + 1 if catches(process.pid, signal.SIGTERM) and state_of(process.pid) == "S" else 0
        time.sleep(0.01)
    process.send_signal(signal.SIGTERM)
    _, told = process.communicate(timeout=PATIENCE)
    os.close(read_end)
    assert process.returncode == 143 and "Traceback" not in told


def state_of(pid: int) -> str:
    return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]


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
