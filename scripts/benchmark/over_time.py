"""A contact over time: what a step costs beside a steady solve on the same grid alone, and how good forces are."""

from __future__ import annotations

import json
import math
import statistics
from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np

from scripts.benchmark.cases import ROOT, seconds
from tests.support.problems import elastic, rolling
from thermoroll_cli.many_contacts.history.course import Course, History
from thermoroll_cli.many_contacts.history.steps import Moment, Steps
from thermoroll_cli.problem.geometry import Geometry

GRIDS = 32, 64
WEIGHT, FRICTION = 0.4705, 0.4
REFERENCE = ROOT / "tests" / "reference" / "transient_creepages.json"
"""A ball on a plane over two contact lengths: forces of a finer grid with more steps, at 57 places."""
ALONG, ACROSS, SPIN = "creepage.longitudinal", "creepage.lateral", "creepage.spin_rad_mm"


def _courses(places: np.ndarray) -> dict[str, tuple[Sequence[float], dict[str, Sequence[float]]]]:
    """Places in m and values by the names of the reference."""
    ends = (0.0, 0.0, float(places[-1]))
    return {"step": (ends, {ALONG: (0.001, 0.003, 0.003)}),
            "wave": (tuple(places), {ALONG: tuple(0.0015 + 0.001 * np.sin(2.0 * math.pi * places / 7e-3))}),
            "spin": (ends, {ACROSS: (0.0, 0.001, 0.001), SPIN: (0.0, -0.0006, -0.0006)})}  # fmt: skip


def measure(runs: int) -> list[dict[str, Any]]:
    """A row for each history and grid: processor seconds of all steps, the error of the forces, and the applications of a step
    and of the steady solve that it begins with."""
    reference, out = json.loads(REFERENCE.read_text(encoding="utf-8")), []
    places = 1e-3 * np.array(reference["s_mm"])
    for name, (knots, values) in _courses(places).items():
        for n in GRIDS:
            ball = rolling(grid=n, geometry=Geometry(math.inf, math.inf, 0.16873, 0.16873), body=elastic(0.28, 2.56e6),
                           load=WEIGHT, friction=FRICTION)
            course = Course(tuple(knots), {key: tuple(given) for key, given in values.items()}, by_distance=True)
            found: list[list[Moment]] = []
            steps = len(places) - 1
            work = partial(_solved, History(ball, course), np.linspace(0.0, places[-1], steps * n // 32 + 1), found)
            times = [seconds(work) for _ in range(runs)]
            moments = found[-1]
            forces = np.array([[moment.reported.scalars[f"force_{x}_N"] for x in "xy"] for moment in moments])[:: n // 32]
            last = History(ball, Course((0.0, 1.0), {key: (given[-1],) * 2 for key, given in values.items()}, by_distance=True))
            error = forces / (FRICTION * WEIGHT) - reference["cases"][name]["force"]
            out.append({"history": name, "N": n, "steps": len(moments) - 1, "seconds": statistics.median(times),
                        "error": math.sqrt((error**2).sum(axis=1).mean()),
                        "applications": float(np.mean([moment.applications for moment in moments[1:]])),
                        "steady": next(Steps(last, (n, n)).moments(np.array([0.0, 1.0]))).applications})
    return out


def _solved(history: History, rows: np.ndarray, found: list[list[Moment]]) -> None:
    shape = history.problem.numerics.grid
    assert shape is not None
    found.append(list(Steps(history, shape).moments(rows)))
