"""What holds for every test."""

from __future__ import annotations

from scripts.signals import give_children_default_signals


def pytest_configure() -> None:
    give_children_default_signals()
