"""What a plain run must not pay for."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.command_line import THERMAL, environment
from thermoroll_cli.process import THREADS


def test_help_loads_neither_numpy_nor_matplotlib() -> None:
    program = ("import sys; from thermoroll_cli.cli.main import main; code = main(['--help']); "
               "print(code, *(name for name in ('numpy', 'matplotlib') if name in sys.modules), file=sys.stderr)")  # fmt: skip
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stderr == "0\n"


def loaded(arguments: list[str], names: tuple[str, ...]) -> str:
    """The exit code of a command, and those of `names` that it has imported."""
    program = (f"import sys; from thermoroll_cli.cli.main import main; code = main({arguments!r}); "
               f"print(code, *(name for name in {names!r} if name in sys.modules))")  # fmt: skip
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    return done.stdout.splitlines()[-1]


@pytest.mark.parametrize("pictures", [False, True])
def test_a_run_loads_no_library_that_it_does_not_need(tmp_path: Path, pictures: bool) -> None:
    """SciPy's splines and minimisers take a quarter of the start of a process, matplotlib as much as the rest."""
    (tmp_path / "case.toml").write_text(THERMAL)
    arguments = ["run", str(tmp_path / "case.toml"), "-o", str(tmp_path), "-q", *([] if pictures else ["--no-plots"])]
    heavy = ("scipy.optimize", "scipy.interpolate", "dask", *([] if pictures else ["matplotlib"]))
    assert loaded(arguments, heavy) == "0"
    assert bool(list(tmp_path.glob("*.png"))) == pictures


def test_validating_needs_no_pictures(tmp_path: Path) -> None:
    (tmp_path / "case.toml").write_text(THERMAL)
    assert loaded(["validate", str(tmp_path / "case.toml")], ("matplotlib", "scipy.optimize", "dask")) == "0"


def test_processes_that_only_solve_points_load_no_pictures() -> None:
    """What a worker of a sweep or a fit imports, with what it is sent."""
    program = ("import sys, thermoroll_cli.sweeps.sweep; "
               "print(*({'matplotlib', 'scipy.optimize', 'scipy.interpolate'} & sys.modules.keys()))")  # fmt: skip
    assert subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True).stdout == "\n"


def test_linear_algebra_gets_one_thread() -> None:
    """Unless the user wants otherwise: sums depend on the number of threads in their last digits."""
    program = ("import os; from thermoroll_cli.cli.main import main; main(['--version']); "
               f"print(*(os.environ[name] for name in {THREADS!r}))")  # fmt: skip
    # `environment` leaves it to the command how many threads linear algebra gets.
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True, env=environment({}))
    assert done.stdout.splitlines()[-1] == "1 1 1"
