"""Parameter sweeps: one case solved for every combination of values of some of its keys.

Points are divided into short stretches of neighbours. A stretch is what one worker solves, each point starting from the
one before it, and the division depends on nothing but the swept values: the same sweep gives the same results in one
process, in many, and on a cluster.
"""

from __future__ import annotations

import sys
import types
from typing import Any


class _CallablePackage(types.ModuleType):
    """`from thermoroll_cli import sweep` gives this package, whatever else has that name: so it can be called."""

    def __call__(self, *arguments: Any, **options: Any) -> list[dict[str, Any]]:
        """`thermoroll_cli.python_api.sweep`."""
        from thermoroll_cli.python_api import sweep

        return sweep(*arguments, **options)


sys.modules[__name__].__class__ = _CallablePackage
