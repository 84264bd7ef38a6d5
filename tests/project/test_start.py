"""What a plain run must not pay for."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from tests.support.command_line import MECHANICAL, environment
from thermoroll_cli.files.environment import THREADS

SLOW = ("scipy", "matplotlib", "dask", "concurrent.futures", "thermoroll_cli.plots", "thermoroll_cli.sweeps",
        "thermoroll_cli.cli.sweep_command", "thermoroll_cli.cli.creep_table", "thermoroll_cli.cli.results",
        "thermoroll_cli.files.case.toml_positions", "thermoroll_cli.heat.sliding_heat", "numpy.polynomial",
        "email.feedparser", "tomli_w")  # fmt: skip


def test_a_mechanical_run_imports_nothing_slow(tmp_path: Path) -> None:
    case = tmp_path / "case.toml"
    case.write_text(MECHANICAL)
    code = ("import os, sys; from thermoroll_cli.cli.main import main; "
            f"code = main(['run', {str(case)!r}, '-o', {str(tmp_path)!r}, '--no-plots', '-q']); "
            f"print([name for name in {SLOW!r} if name in sys.modules]); "
            f"print(*(os.environ[name] for name in {THREADS!r})); sys.exit(code)")  # fmt: skip
    # `environment` leaves it to the command how many threads linear algebra gets.
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, env=environment({}))
    assert done.stdout == "[]\n1 1 1\n"


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
