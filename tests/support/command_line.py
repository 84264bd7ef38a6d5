"""Running the real command, as a shell does."""

from __future__ import annotations

import io
import os
import pty
import subprocess
import sys
from collections.abc import Mapping
from contextlib import ExitStack, chdir, redirect_stderr, redirect_stdout
from dataclasses import dataclass
from pathlib import Path
from unittest import mock

from thermoroll_cli.tools.process import THREADS

MECHANICAL = """\
title = "Two spheres"
[material]
youngs_modulus_GPa = 210.0
poisson_ratio = 0.28
[geometry]
lower_radius_x_mm = 30.0
lower_radius_y_mm = 30.0
upper_radius_x_mm = 30.0
upper_radius_y_mm = 30.0
[load]
normal_N = 65.0
friction_coefficient = 0.3
[rolling]
speed_m_s = 1.0
[creepage]
longitudinal = 0.003
[numerics]
grid = 16
"""
"""A case that is solved in no time."""

THERMAL = MECHANICAL.replace(
    "[geometry]", "conductivity_W_mK = 50.2\nexpansion_um_mK = 11.7\ndiffusivity_mm2_s = 10.0\n[geometry]"
)
"""The same with heat."""

ENTRY_POINT = Path(sys.executable).with_name("thermoroll")
COMMAND = [str(ENTRY_POINT)] if ENTRY_POINT.exists() else [sys.executable, "-m", "thermoroll_cli"]

WARNINGS: dict[str, str] = {}
"""Variables that have a command take warnings for errors, if pytest does (`-W error`)."""

PATIENCE = 1800.0
"""Seconds after which a process that should have ended is given up: against those that hang alone. A script of ten processor
seconds has taken three minutes on a machine that was busy otherwise."""


def thermoroll(
    *arguments: str | Path, cwd: Path | None = None, stdin: str = "", env: Mapping[str, str | None] | None = None
) -> subprocess.CompletedProcess[str]:
    """Run the command with `arguments`; variables in `env` are set, or removed where None. A trace is never right."""
    done = subprocess.run(
        [*COMMAND, *map(str, arguments)], cwd=cwd, input=stdin, env=environment(env or {}), capture_output=True, text=True,
        encoding="utf-8", timeout=PATIENCE)
    assert "Traceback" not in done.stderr
    return done


def environment(changes: Mapping[str, str | None]) -> dict[str, str]:
    """The environment of this process with `changes`; None removes a variable. How many threads linear algebra gets is left
    to the command."""
    merged = {**os.environ, **dict.fromkeys(THREADS), **WARNINGS, **changes}
    return {key: value for key, value in merged.items() if value is not None}


@dataclass(frozen=True)
class Called:
    """What a call of the entry point left: as a process would, but without starting one."""

    returncode: int
    stdout: str
    stderr: str


def call(*arguments: str | Path, cwd: Path | None = None, stdin: str = "", painted: bool = False) -> Called:
    """`thermoroll` with `arguments` within this process, which saves the imports. For what needs no process of its own.
    Pictures have few pixels, and are blank sheets unless `painted`: to lay out and paint one costs more than most solutions."""
    from matplotlib.figure import Figure

    from thermoroll_cli.cli.main import main
    from thermoroll_cli.plots import style

    words = [str(argument) for argument in arguments]
    out, err = io.StringIO(), io.StringIO()
    with ExitStack() as stack:
        stack.enter_context(chdir(cwd or Path.cwd()))
        stack.enter_context(redirect_stdout(out))
        stack.enter_context(redirect_stderr(err))
        stack.enter_context(mock.patch.object(style, "DPI", 40))
        if not painted:
            stack.enter_context(mock.patch.object(Figure, "draw"))
        stack.enter_context(mock.patch.object(sys, "argv", ["thermoroll", *words]))
        stack.enter_context(mock.patch.object(sys, "stdin", io.TextIOWrapper(io.BytesIO(stdin.encode()))))
        code = main()
    return Called(code, out.getvalue(), err.getvalue())


def limited(folder: Path, size: int, *arguments: str | Path) -> Called:
    """`call` where no file may grow beyond `size` bytes: to the command, that is a disk that fills up. What Python compiles
    meanwhile stays out of its cache, where it would be cut, too."""
    import resource

    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    with mock.patch.object(sys, "dont_write_bytecode", True):
        resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
        try:
            done = call(*arguments, cwd=folder, painted=True)
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert "Traceback" not in done.stderr and "bug" not in done.stderr
    return done


def on_terminal(arguments: list[str], cwd: Path, **variables: str) -> str:
    """What the command shows on a terminal."""
    controller, terminal = pty.openpty()
    process = subprocess.Popen(
        [*COMMAND, *arguments], cwd=cwd, stdout=terminal, stderr=terminal,
        env=environment({"TERM": "xterm", "NO_COLOR": None, **variables}))
    os.close(terminal)
    shown = b""
    while True:
        try:
            chunk = os.read(controller, 65536)
        except OSError:  # the other end is closed
            break
        if not chunk:
            break
        shown += chunk
    os.close(controller)
    process.wait(timeout=PATIENCE)
    return shown.decode()
