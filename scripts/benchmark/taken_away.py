"""The rolling solver with one of its ideas taken away at a time: options that the rest of the program is solved with.

A comparison then shows the worth of that idea alone.
"""

from __future__ import annotations

from dataclasses import replace

from thermoroll_cli.rolling.rolling_gradient import RollingOptions
from thermoroll_cli.steady_state.discretisation import SolverOptions

UPSTREAM = (0.0, -1.0, 1.0, 0.0)
"""(u_i − u_{i−1})/h at offsets −2 … 1."""

STANDARD = SolverOptions()

WITHOUT_EXTRAPOLATION = SolverOptions(extrapolated=False)
"""Values of the last grid as they are."""

FIRST_ORDER = replace(
    WITHOUT_EXTRAPOLATION,
    rolling=RollingOptions(difference_weights=UPSTREAM, leading_known=False),
    whole_elements=True,
)
"""CONTACT's discretisation: first-order upstream differences, whole elements inside the contact border, and the values of
the last grid as they are."""

UNPRECONDITIONED = SolverOptions(rolling=RollingOptions(preconditioned=False))
"""GMRES on the Newton equations as they are (without restart, as long as it takes)."""

NO_CONTINUATION = SolverOptions(sequence=False)
"""The wanted grid alone, from a cold start: then there is neither an estimate nor an extrapolation."""

BASELINES: dict[str, SolverOptions] = {
    "first-order discretisation": FIRST_ORDER,
    "no continuation": NO_CONTINUATION,
    "unpreconditioned GMRES": UNPRECONDITIONED,
}
