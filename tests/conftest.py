"""What holds for every test."""

from __future__ import annotations

import pytest

from scripts.signals import give_children_default_signals
from tests.support import command_line
from thermoroll_cli.process import one_thread

# Before anything loads NumPy, as the command does: a second thread of linear algebra costs a quarter more processor time here.
one_thread()


def pytest_configure(config: pytest.Config) -> None:
    give_children_default_signals()
    if "error" in (config.getoption("pythonwarnings") or ()):
        command_line.WARNINGS["PYTHONWARNINGS"] = "error"
