"""What a plain run must not pay for."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from tests.support.command_line import THERMAL, environment
from thermoroll_cli.tools.process import THREADS


def test_help_loads_neither_numpy_nor_matplotlib() -> None:
    program = ("import sys; from thermoroll_cli.cli.main import main; code = main(['--help']); "
               "print(code, *(name for name in ('numpy', 'matplotlib') if name in sys.modules), file=sys.stderr)")  # fmt: skip
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stderr == "0\n"


def test_commands_load_no_library_that_they_do_not_need(tmp_path: Path) -> None:
    """SciPy's splines and minimisers take a quarter of the start of a process, matplotlib as much as the rest."""
    (tmp_path / "case.toml").write_text(THERMAL)
    run = ["run", "case.toml", "-q"]
    heavy = ("matplotlib", "scipy.ndimage", "scipy.optimize", "scipy.interpolate", "dask")
    program = ("import sys; from thermoroll_cli.cli.main import main\n"
               f"for words in (['validate', 'case.toml', '-q'], {[*run, '--no-plots']!r},\n"
               f"              {[*run, '--plots', 'summary']!r}):\n"
               f"    print(main(words), *(name for name in {heavy!r} if name in sys.modules))")  # fmt: skip
    done = subprocess.run([sys.executable, "-c", program], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert done.stdout.splitlines() == ["0", "0", "0 matplotlib scipy.ndimage"]
    assert list((tmp_path / "results").glob("*.png"))


def test_processes_that_only_solve_points_load_no_pictures() -> None:
    """What a worker of a sweep or a fit imports, with what it is sent; and a sweep, until it draws."""
    program = ("import sys, thermoroll_cli.studies.sweeps.sweep, thermoroll_cli.cli.sweep_command; "
               "print(*({'matplotlib', 'scipy.optimize', 'scipy.interpolate'} & sys.modules.keys()))")  # fmt: skip
    assert subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True).stdout == "\n"


def test_linear_algebra_gets_one_thread() -> None:
    """Unless the user wants otherwise: sums depend on the number of threads in their last digits."""
    program = ("import os; from thermoroll_cli.cli.main import main; main(['--version']); "
               f"print(*(os.environ[name] for name in {THREADS!r}))")  # fmt: skip
    # `environment` leaves it to the command how many threads linear algebra gets.
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True, env=environment({}))
    assert done.stdout.splitlines()[-1] == "1 1 1"
