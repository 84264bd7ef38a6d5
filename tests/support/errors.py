"""Estimated errors over the scales by which they are judged."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from thermoroll_cli.problem.result import Result
from thermoroll_cli.problem.scalar_errors import error_scale


def relative(result: Result | Mapping[str, Any]) -> dict[str, float]:
    """The uncertainty of each scalar of a result, or of its summary, over its `error_scale`; nan for null."""
    summary = result.summary() if isinstance(result, Result) else result
    known = {name: math.nan if value is None else value for name, value in summary["uncertainty"].items()}
    return {name: value / (error_scale(name, summary) or 1.0) for name, value in known.items()}
