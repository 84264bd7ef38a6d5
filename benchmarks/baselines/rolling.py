"""The rolling solver with one of its ideas taken away at a time.

Each is a context manager: inside it `solve` works as others do. The rest of the program stays what it is, so that a
comparison shows the worth of that idea alone.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np

from thermoroll_cli.pipeline import outcome, plan
from thermoroll_cli.pipeline.contact import Pressure
from thermoroll_cli.pipeline.level import Level
from thermoroll_cli.pipeline.problem import Problem
from thermoroll_cli.pipeline.rolling import Rolling
from thermoroll_cli.solvers import newton, tangential_operator, tangential_preconditioner

UPSTREAM = (0.0, -1.0, 1.0, 0.0)
"""(u_i − u_{i−1})/h at offsets −2 … 1."""
UPSTREAM_DISSIPATIVE = (0.0, -0.5, 1.0, -0.5, 0.0)

LONGEST_KRYLOV = 1500


@contextlib.contextmanager
def _replaced(*changes: tuple[Any, str, Any]) -> Iterator[None]:
    """Attributes (owner, name, value) replaced for the time being. Raises AttributeError if one does not exist."""
    before = [(owner, name, getattr(owner, name)) for owner, name, _ in changes]
    try:
        for owner, name, value in changes:
            setattr(owner, name, value)
        yield
    finally:
        for owner, name, value in before:
            setattr(owner, name, value)


@contextlib.contextmanager
def without_extrapolation() -> Iterator[None]:
    """Values of the last grid as they are."""
    with _replaced((outcome, "reported", lambda levels, scene: dict(levels[-1]))):
        yield


@contextlib.contextmanager
def first_order() -> Iterator[None]:
    """CONTACT's discretisation: first-order upstream differences, whole elements inside the contact border, and the values of
    the last grid as they are."""
    smooth = Level.__dict__["hertz"].func

    def whole_elements(self: Level) -> Pressure:
        exact: Pressure = smooth(self)
        grid, hertz = self.grid, self.scene.hertz
        inside = 1.0 - (grid.x[:, None] / hertz.semi_axis_x) ** 2 - (grid.y[None, :] / hertz.semi_axis_y) ** 2
        pressure = hertz.peak_pressure * np.sqrt(np.maximum(inside, 0.0))
        pressure *= self.scene.problem.normal_force / (float(pressure.sum()) * grid.element_area)
        return replace(exact, pressure=pressure, covered=(pressure > 0.0).astype(float))

    whole = cached_property(whole_elements)
    whole.__set_name__(Level, "hertz")
    with without_extrapolation(), _replaced(
        (tangential_operator, "DIFFERENCE_WEIGHTS", UPSTREAM),
        (tangential_operator, "DISSIPATIVE_WEIGHTS", UPSTREAM_DISSIPATIVE),
        (tangential_preconditioner, "DIFFERENCE_WEIGHTS", UPSTREAM),
        (Level, "hertz", whole),
        (Rolling, "leading", lambda self, scene, normal, window, undisturbed: None),
    ):
        yield


@contextlib.contextmanager
def unpreconditioned() -> Iterator[None]:
    """GMRES on the Newton equations as they are (without restart, as long as it takes)."""

    def identity(self: newton.Linearisation, v: Any) -> Any:
        if self.newton.free:
            raise NotImplementedError("only with prescribed creepages")
        return v

    with _replaced(
        (newton.Linearisation, "precondition", identity),
        (newton, "MAX_KRYLOV", LONGEST_KRYLOV),
    ):
        yield


@contextlib.contextmanager
def no_continuation() -> Iterator[None]:
    """The wanted grid alone, from a cold start: then there is neither an estimate nor an extrapolation."""

    def one_grid(problem: Problem) -> tuple[tuple[int, int], ...]:
        if problem.numerics.grid is None:
            raise ValueError("a grid is needed")
        return (problem.numerics.grid,)

    with _replaced((plan, "grid_ladder", one_grid)):
        yield


BASELINES: dict[str, Callable[[], contextlib.AbstractContextManager[None]]] = {
    "first-order discretisation": first_order,
    "no continuation": no_continuation,
    "unpreconditioned GMRES": unpreconditioned,
}

__all__ = ["BASELINES", "first_order", "no_continuation", "unpreconditioned", "without_extrapolation"]
