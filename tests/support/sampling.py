"""Rows of references of which the suite takes some."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import pytest


def sampled(rows: Iterable[Any], every: int = 2) -> list[Any]:
    """Parameters of a test: the first of `every` so many rows; the others are slow tests, which `make test-all` runs."""
    return [row if number % every == 0 else pytest.param(row, marks=pytest.mark.slow) for number, row in enumerate(rows)]
