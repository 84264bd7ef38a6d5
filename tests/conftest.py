"""What holds for every test."""

from __future__ import annotations

from scripts.signals import give_children_default_signals
from thermoroll_cli.process import one_thread

# Before anything loads NumPy, as the command does: a second thread of linear algebra costs a quarter more processor time here.
one_thread()


def pytest_configure() -> None:
    give_children_default_signals()
