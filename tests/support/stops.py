"""Signals to runs, sweeps and tables at work: each must end with its exit code, soon, and leave nothing behind."""

from __future__ import annotations

import os
import pathlib
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator

from thermoroll_cli import CreepForceTable
from thermoroll_cli.files.result.hdf5 import read_result

ROOT = pathlib.Path(__file__).resolve().parents[2]

COMMAND = (sys.executable, "-m", "thermoroll_cli")
OVER = ("--over", "creepage.longitudinal=5e-4:3e-3:6", "--set", "numerics.grid=32")
TABLE = ("--aspect", "1", "--accuracy", "1e-2", "--nodes", "8,7,7", "--checks", "100", "-o", "table.h5")
PROGRAMS: dict[str, tuple[str, ...]] = {
    "run": ("run", "case.toml", "--set", "numerics.grid=192"),
    "sweep": ("sweep", "case.toml", *OVER),
    "sweep --jobs 2": ("sweep", "case.toml", *OVER, "--jobs", "2"),
    "table": ("table", "build", *TABLE),
    "table --jobs 2": ("table", "build", *TABLE, "--jobs", "2"),
}
"""A second or two of work each, with pictures."""
SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
TO_ALL = (signal.SIGINT, signal.SIGHUP)
"""Those that a terminal sends to a program and all processes it has started."""
PATIENCE = 120.0
SOON = 5.0
"""Processor seconds to the end after a signal."""
PF_EXITING = 4
"""A flag of Linux, in /proc/PID/stat."""


def stopped(program: str, number: signal.Signals, moment: float) -> tuple[str, ...] | None:
    """Start `program` and send it `number` when it has worked for `moment` seconds: what is wrong then. None if it has ended
    by then."""
    with tempfile.TemporaryDirectory(prefix="thermoroll-signals-") as name:
        folder, already = pathlib.Path(name), _children_seconds()
        with started(program, folder) as process:
            time.sleep(moment)
            before = _group_seconds(process.pid)
            if process.poll() is not None or _leaving(process.pid):
                process.communicate()
                return None
            if number in TO_ALL:
                os.killpg(process.pid, number)
            else:
                process.send_signal(number)
            try:
                out, err = process.communicate(timeout=PATIENCE)
            except subprocess.TimeoutExpired:
                os.killpg(process.pid, signal.SIGKILL)
                out, err = process.communicate()
        busy = _children_seconds() - already - before
        late = (f"{busy:.1f} s of processor time to the end",) if busy > SOON else ()
        return (*late, *_faults(process.returncode, number, out + err, folder))


def started(program: str, folder: pathlib.Path) -> subprocess.Popen[str]:
    """The program at work in `folder`: it has taken hold of the signals, which takes Python a moment."""
    shutil.copy(ROOT / "cases" / "article_4_1.toml", folder / "case.toml")
    process = subprocess.Popen(
        [*COMMAND, *PROGRAMS[program]], cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        env={**os.environ, "PYTHONPATH": str(ROOT)}, start_new_session=True,
    )  # fmt: skip
    while process.poll() is None and not catches(process.pid, signal.SIGTERM):
        time.sleep(0.001)
    return process


def catches(pid: int, number: signal.Signals) -> bool:
    """Whether the process `pid` handles the signal `number` itself."""
    try:
        status = pathlib.Path(f"/proc/{pid}/status").read_text()
    except FileNotFoundError:
        return False
    caught = next(line.split()[1] for line in status.splitlines() if line.startswith("SigCgt"))
    return bool(int(caught, 16) >> (number - 1) & 1)


def _leaving(pid: int) -> bool:
    """Whether the kernel is already taking the process down, with an exit code that is settled: no signal reaches it then."""
    flags = int(pathlib.Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[6])
    return bool(flags & PF_EXITING)


def _children_seconds() -> float:
    """Processor time of all processes that were started from here and have ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def _group_seconds(group: int) -> float:
    """Processor time of a process and all that it has started so far."""
    ticks = 0
    for stat in pathlib.Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = stat.read_text().rpartition(")")[2].split()
        except OSError:
            continue
        if int(fields[2]) == group:
            ticks += sum(int(field) for field in fields[11:15])  # its own, and of its children that have ended
    return ticks / os.sysconf("SC_CLK_TCK")


def _faults(code: int, number: signal.Signals, told: str, folder: pathlib.Path) -> Iterator[str]:
    # As a shell shows it: a process that a signal ended right away counts the same.
    shown = 128 - code if code < 0 else code
    if shown != 128 + number:
        yield f"exit code {shown} instead of {128 + number}"
    for word in ("Traceback", "Exception ignored", "bug in thermoroll"):
        if word in told:
            yield f"{word}: {told.strip()[-300:]}"
    for path in sorted((folder / "results").glob("*")) if (folder / "results").exists() else ():
        if path.name.startswith("."):
            yield f"left {path.name}"
        elif path.suffix == ".h5" and not read_result(path).converged:
            yield f"{path.name} is no result"
    # What is left of a table is its journal, for --resume; its own name has what is whole.
    for path in folder.glob("*.h5"):
        CreepForceTable.read(path)
    yield from (f"left {path.name}" for path in folder.glob(".*"))
