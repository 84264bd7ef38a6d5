"""What a plain run must not pay for."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from tests.support.command_line import MECHANICAL, environment
from thermoroll_cli.files.environment import THREADS


def test_help_loads_neither_numpy_nor_matplotlib() -> None:
    program = ("import sys; from thermoroll_cli.cli.main import main; code = main(['--help']); "
               "print(code, *(name for name in ('numpy', 'matplotlib') if name in sys.modules), file=sys.stderr)")  # fmt: skip
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stderr == "0\n"


def test_linear_algebra_gets_one_thread() -> None:
    """Unless the user wants otherwise: sums depend on the number of threads in their last digits."""
    program = ("import os; from thermoroll_cli.cli.main import main; main(['--version']); "
               f"print(*(os.environ[name] for name in {THREADS!r}))")  # fmt: skip
    # `environment` leaves it to the command how many threads linear algebra gets.
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True, env=environment({}))
    assert done.stdout.splitlines()[-1] == "1 1 1"


def test_imports_are_not_searched_for_cycles(tmp_path: Path) -> None:
    """Of a process of its own, whose `main` begins with Python's own thresholds."""
    case = tmp_path / "case.toml"
    case.write_text(MECHANICAL)
    code = ("import gc; from thermoroll_cli.cli.main import main; before = gc.get_stats()[0]['collections']; "
            f"code = main(['run', {str(case)!r}, '-o', {str(tmp_path)!r}, '--no-plots', '-q']); "
            "print(gc.get_stats()[0]['collections'] - before, gc.get_freeze_count() > 0, gc.get_threshold()[0]); "
            "raise SystemExit(code)")  # fmt: skip
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    collections, frozen, threshold = done.stdout.split()
    assert int(collections) <= 3 and frozen == "True" and threshold == "20000"
