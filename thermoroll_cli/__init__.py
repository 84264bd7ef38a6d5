"""Three-dimensional thermo-elastic rolling contact in the steady state.

For notebooks and scripts::

    from thermoroll_cli import Case, solve

    result = solve(Case.read("cases/article_4_1.toml"))
    result.coupled.scalars["Q_F_W"], result.coupled.fields["pressure"]
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from thermoroll_cli.files.case.case import Case
    from thermoroll_cli.model.problem import Problem
    from thermoroll_cli.model.result import Result

__all__ = ["Case", "__version__", "solve"]


def solve(case: Case | Problem, *, threads: int = 1, report: Callable[[str, Mapping[str, Any]], None] | None = None) -> Result:
    """Solve a case (or a problem in SI units): both states with fields in SI units, scalars in those of their names.

    `threads` and `report` as in `refinement.solve.solve`. A result that did not converge says so in `converged`.
    """
    from thermoroll_cli.model.problem import Problem
    from thermoroll_cli.refinement.solve import solve as solve_problem

    return solve_problem(case if isinstance(case, Problem) else case.problem, threads=threads, report=report)


def __getattr__(name: str) -> Any:
    # Imported when asked for: the command line must start without pydantic and NumPy.
    if name == "Case":
        from thermoroll_cli.files.case.case import Case

        return Case
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
