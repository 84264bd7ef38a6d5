"""How the outlines of a wheelset and its rails wear: their evolution as files have it."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from thermoroll_cli.files.case import Case
from thermoroll_cli.many_contacts.wheelset.curves import Points
from thermoroll_cli.many_contacts.wheelset.wheelset_problem import WheelsetProblem
from thermoroll_cli.many_contacts.wheelset.wheelset_result import solve_wheelset
from thermoroll_cli.problem.geometry import Unsolvable
from thermoroll_cli.problem.problem import Wear
from thermoroll_cli.problem.result import Result
from thermoroll_cli.studies.worn.service import Outlines, outlines_of, positions_of, service, worn_outlines
from thermoroll_cli.studies.worn.steps import WearState
from thermoroll_cli.studies.worn.wearing import Record, Snapshots, Wearing
from thermoroll_cli.tools.journal import Journal
from thermoroll_cli.tools.runner import Workers

OUTLINE_OF = {"rail": ("track", "rail_profile"), "wheel": ("wheelset", "wheel_profile")}
"""Table and key of the outline of a case."""


class WearOfWheelset(Wearing):
    """The outlines of wheels and rails over the positions of their service."""

    task: WheelsetProblem

    @cached_property
    def positions(self) -> list[tuple[float, WheelsetProblem]]:
        """The positions with their shares of the distance."""
        return positions_of(self.case)

    @cached_property
    def new(self) -> Outlines:
        """The unworn outlines by name."""
        return outlines_of(self.task)

    @cached_property
    def asked(self) -> Wear:
        asked = super().asked
        if asked.lower.wears and math.isinf(asked.lower.track_length):
            raise Unsolvable("a rail has no circumference", "wear.lower",
                             "track_length_m, the distance between two passages of a wheel")
        return asked

    @property
    def shares_work(self) -> bool:
        return bool(self.positions)

    def states(self, start: WearState | None, journal: Journal, workers: Workers, threads: int) -> Iterator[WearState]:
        return service(self.positions, start, journal, workers, threads)

    def outlines(self, state: WearState) -> Mapping[str, tuple[Points, Points]]:
        return {name: (outline.points, outline.worn) for name, outline in worn_outlines(self.new, state).items()}

    def points(self, state: WearState) -> dict[str, Points]:
        return {name: worn for name, (_, worn) in self.outlines(state).items() if state.worn[name].any()}

    def content(self, state: WearState) -> dict[str, Any]:
        """At the first of its positions."""
        case, positions = self.case, self.case.settings.wear and self.case.settings.wear.positions
        if positions:
            values = positions[0][1]
            assert isinstance(values, dict)
            case = case.with_values(values)
        content: dict[str, Any] = json.loads(case.to_json())
        for name, points in self.points_mm(state).items():
            body, _, side = name.partition("_")
            section, key = OUTLINE_OF[body]
            content[section][side] = (content[section].get(side) or {}) | {key: {"points_mm": points}}
        return content

    def result(self, state: WearState, worn: Case, threads: int) -> Result | None:
        task = worn.task
        try:
            return solve_wheelset(task, threads=threads).with_case(worn.text, worn.to_json())  # type: ignore[arg-type]
        except Unsolvable:  # as a position that the evolution ended with
            return None

    def over(self, states: Sequence[WearState], records: Sequence[Record]) -> Snapshots:
        lengths = {name: np.asarray((np.arange(len(states[-1].worn[name])) + 0.5) * size)
                   for name, size in states[-1].sizes.items()}
        return Snapshots(np.array([state.distance for state in states]), lengths=lengths,
                         depths={name: np.array([state.worn[name] for state in states]) for name in lengths})
