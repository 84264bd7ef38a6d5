"""What a plain run must not pay for."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from tests.support.command_line import THERMAL, environment
from thermoroll_cli.tools.process import THREADS


def test_commands_load_no_library_that_they_do_not_need(tmp_path: Path) -> None:
    """SciPy's splines and minimisers take a quarter of the start of a process, matplotlib as much as the rest. What a worker of
    a sweep or a fit imports draws nothing. Linear algebra gets one thread: sums depend on their number in the last digits."""
    (tmp_path / "case.toml").write_text(THERMAL.replace("grid = 16", "grid = 8"))
    program = f"""
import os, sys
from thermoroll_cli.cli.main import main
def loaded(*names):
    print(main(words), *(name for name in names if name in sys.modules), file=sys.stderr)
words = ["--help"]
loaded("numpy", "matplotlib")
print(*(os.environ[name] for name in {THREADS!r}), file=sys.stderr)
heavy = "matplotlib", "scipy.ndimage", "scipy.optimize", "scipy.interpolate", "dask"
run = ["run", "case.toml", "-q"]
for words in (["validate", "case.toml", "-q"], [*run, "--no-plots"]):
    loaded(*heavy)
import thermoroll_cli.studies.sweeps.sweep, thermoroll_cli.cli.sweep_command
words = [*run, "--plots", "summary", "--dpi", "30"]
print(*(name for name in heavy[:4] if name in sys.modules), file=sys.stderr)
loaded(*heavy)
"""
    # `environment` leaves it to the command how many threads linear algebra gets.
    done = subprocess.run([sys.executable, "-c", program], cwd=tmp_path, capture_output=True, text=True, check=True,
                          env=environment({}))  # fmt: skip
    assert done.stderr.splitlines() == ["0", "1 1 1", "0", "0", "", "0 matplotlib scipy.ndimage"]
    assert list((tmp_path / "results").glob("*.png"))
