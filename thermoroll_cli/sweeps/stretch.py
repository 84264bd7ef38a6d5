"""Solving one stretch: what every worker does, wherever it runs."""

from __future__ import annotations

import pathlib
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass

from thermoroll_cli.files.result.hdf5 import write_result
from thermoroll_cli.problem.result import Result
from thermoroll_cli.refinement.solve import Solver
from thermoroll_cli.sweeps.points import Point, Stretch
from thermoroll_cli.sweeps.worker_process import WRITING


@dataclass(frozen=True)
class Target:
    """Where the files go and what they tell about their origin; `threads` of each solver."""

    folder: pathlib.Path
    command_line: str
    threads: int = 1

    def path(self, point: Point) -> pathlib.Path:
        return self.folder / f"{point.name}.h5"


@dataclass(frozen=True)
class Outcome:
    """The point `number` has its file; or it has none, for a `reason`. `content` is that file where whoever solved the
    point cannot write it."""

    number: int
    reason: str = ""
    content: bytes = b""


def solve_into(stretch: Stretch, target: Target) -> Iterator[Outcome]:
    """Solve the pending points of `stretch` and write each when it is solved. Raises OSError."""
    for point, result, reason in solved(stretch, target.threads):
        if result is not None:
            _write(target.path(point), point, result, target.command_line)
        yield Outcome(point.number, reason)


def solve_all_into(stretch: Stretch, target: Target) -> list[Outcome]:
    """`solve_into` for a process of its own. Raises OSError."""
    try:
        return list(solve_into(stretch, target))
    except OSError as cause:
        # Plain, because not every OSError survives the way between processes.
        raise OSError(str(cause)) from None


def solve_away(stretch: Stretch, command_line: str) -> list[Outcome]:
    """`solve_into` for a machine that may not see the folder: the files come back as bytes."""
    outcomes = []
    with tempfile.TemporaryDirectory(prefix="thermoroll-") as folder:
        target = Target(pathlib.Path(folder), command_line)
        points = {point.number: point for point in stretch.points}
        for outcome in solve_into(stretch, target):
            path = target.path(points[outcome.number])
            if outcome.reason:
                outcomes.append(outcome)
                continue
            outcomes.append(Outcome(outcome.number, content=path.read_bytes()))
            path.unlink()
    return outcomes


def solved(stretch: Stretch, threads: int) -> Iterator[tuple[Point, Result | None, str]]:
    """Each pending point with its result, or with the reason why it has none."""
    solver: Solver | None = None
    pending = {point.number for point in stretch.pending}
    for point in stretch.points:
        if not pending:
            return
        if point.number in stretch.given_up:
            continue
        cold = solver is None
        solver = solver or Solver(threads)
        result, reason = _attempt(solver, point, search=cold)
        if not cold and (result is None or not result.converged):
            # The neighbour may have been a bad start: no point does worse than a run of its own.
            solver = Solver(threads)
            result, reason = _attempt(solver, point, search=True)
        if result is None:
            # What an exception leaves behind is no start for the next point.
            solver = None
        if point.number in pending:
            pending.remove(point.number)
            yield point, result, reason


def _attempt(solver: Solver, point: Point, *, search: bool) -> tuple[Result | None, str]:
    try:
        return solver.solve(point.problem, search=search), ""
    except MemoryError:
        return None, "not enough memory"
    except Exception as cause:
        return None, " ".join(f"{type(cause).__name__}: {cause}".split())


def _write(path: pathlib.Path, point: Point, result: Result, command_line: str) -> None:
    with WRITING:
        write_result(path, result, case_text=point.case_text, case_json=point.case_json, command_line=command_line)
