"""Thermo-elastic rolling contact with friction, heat, thermal expansion and estimated errors.

For notebooks and scripts (docs/read_results.md)::

    from thermoroll_cli import Case, solve

    result = solve(Case.read("cases/article_4_1.toml"))
    result["Q_F_W"], result.uncertainty["Q_F_W"], result.fields["pressure"]
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

if TYPE_CHECKING:
    from thermoroll_cli.files.case import Case
    from thermoroll_cli.files.case_errors import CaseError
    from thermoroll_cli.files.result.outcome import read_result
    from thermoroll_cli.problem.problem import Problem
    from thermoroll_cli.problem.result import Result
    from thermoroll_cli.python_api import Solver, conicity, solve
    from thermoroll_cli.studies.creep_table.creep_force_table import CreepForceTable
    from thermoroll_cli.studies.sweeps.fit import fit
    from thermoroll_cli.studies.sweeps.sweep import sweep
    from thermoroll_cli.studies.worn.follow import wear

__all__ = [
    "Case", "CaseError", "CreepForceTable", "Problem", "Result", "Solver", "__version__", "conicity", "fit", "read_result",
    "solve", "sweep", "wear",
]  # fmt: skip

_PLACES = {
    "Case": "thermoroll_cli.files.case",
    "CaseError": "thermoroll_cli.files.case_errors",
    "CreepForceTable": "thermoroll_cli.studies.creep_table.creep_force_table",
    "Problem": "thermoroll_cli.problem.problem",
    "Result": "thermoroll_cli.problem.result",
    "Solver": "thermoroll_cli.python_api",
    "conicity": "thermoroll_cli.python_api",
    "fit": "thermoroll_cli.studies.sweeps.fit",
    "read_result": "thermoroll_cli.files.result.outcome",
    "solve": "thermoroll_cli.python_api",
    "sweep": "thermoroll_cli.studies.sweeps.sweep",
    "wear": "thermoroll_cli.studies.worn.follow",
    # Not offered, but called by methods of a result.
    "draw_on": "thermoroll_cli.plots.pictures",
    "evolution_figure": "thermoroll_cli.studies.worn.evolution_picture",
    "figure": "thermoroll_cli.plots.pictures",
    "plot_table": "thermoroll_cli.studies.sweeps.table_picture",
    "write_result": "thermoroll_cli.files.result.outcome",
}


def of_above(name: str) -> Any:
    """What is called `name` in `_PLACES`. A result is made below the packages that write and draw it, and finds them here."""
    return getattr(importlib.import_module(_PLACES[name]), name)


def optional(package: str, method: str) -> Any:
    """A `package` that one `method` needs. Raises ImportError, which says what to install."""
    try:
        return importlib.import_module(package)
    except ImportError:
        raise ImportError(f"{method} needs the package {package}, which is not installed: pip install {package}") from None


def __getattr__(name: str) -> Any:
    # Imported when asked for: the command line must start without pydantic and NumPy.
    if name in __all__ and name in _PLACES:
        return of_above(name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return __all__
