"""What holds for every test."""

from __future__ import annotations

import gc
import os
import signal
import sys
from collections.abc import Iterator

import pytest

from tests.support import command_line
from tests.support.signals import give_children_default_signals
from thermoroll_cli.tools.process import one_thread

# Before anything loads NumPy, as the command does: a second thread of linear algebra costs a quarter more processor time here.
one_thread()
# Neither the hundreds of processes that tests start nor those that share the tests need compile what others have compiled.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False


def pytest_configure(config: pytest.Config) -> None:
    give_children_default_signals()
    if "error" in (config.getoption("pythonwarnings") or ()):
        command_line.WARNINGS["PYTHONWARNINGS"] = "error"


LONGEST = ("test_history_case", "test_bearing", "test_fit", "test_solve_wheelset", "test_conicity",
           "test_wheelsets_over_time", "test_cli_process", "test_lines_over_time", "test_sweep_faults", "test_sweep",
           "test_run_pictures", "test_worn", "test_surfaces_of_wheelsets", "test_slip_friction", "test_tangential",
           "test_slices_over_time", "test_creep_table", "test_sweep_pictures", "test_wheelset_file", "test_line_case",
           "test_slices", "test_relaxation", "test_determinism", "test_friction_places", "test_steps", "test_surfaces",
           "test_subsurface_files", "test_dissimilar", "test_cli_results", "test_sliding")
"""Files whose tests take longest: processes that share the files begin with them, so that none is left with one at the end."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    items.sort(key=lambda item: LONGEST.index(item.path.stem) if item.path.stem in LONGEST else len(LONGEST))


def pytest_collection_finish() -> None:
    """Tests themselves and what they have imported stay to the end: looking through them for garbage again and again took a
    twentieth of all processor time."""
    gc.collect()
    gc.freeze()


def process_state() -> dict[str, object]:
    """What all tests of one process share and any of them can change: folder, user, signal handlers, environment, new files'
    permissions."""
    mask = os.umask(0o077)
    os.umask(mask)
    users = [getattr(os, name)() for name in ("geteuid", "getegid") if hasattr(os, name)]
    variables = {name: value for name, value in os.environ.items() if name != "PYTEST_CURRENT_TEST"}
    handlers = {number: signal.getsignal(number) for number in signal.valid_signals()}
    timers = [signal.getitimer(timer) for timer in (signal.ITIMER_REAL, signal.ITIMER_PROF)]
    return {"folder": os.getcwd(), "users": users, "environment": variables, "signals": handlers, "timers": timers,
            "umask": mask}


@pytest.fixture(autouse=True)
def unchanged_process() -> Iterator[None]:
    """No test leaves another one's process changed: what must not be undone belongs into a process of its own."""
    before = process_state()
    yield
    assert process_state() == before
