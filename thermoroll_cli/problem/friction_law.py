"""Friction that falls with slip: laws of the slip speed, with or without memory."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

LawName = Literal["exponential", "rational", "linear", "table"]


@dataclass(frozen=True)
class FrictionLaw:
    """Coefficient of friction over its value without slip, as a function f of the slip speed s in m/s.

    | `kind` | f(s) |
    | --- | --- |
    | exponential | l + (1 − l) 2^(−s/h) (Polach 2005) |
    | rational | l + (1 − l)/(1 + s/h) (CONTACT, Vollebregt & Schuttelaars 2012) |
    | linear | l + (1 − l) max(0, 1 − s/2h) |
    | table | linear between the points of `table`, constant beyond the last |

    with the `limit` l and the slip speed `half_slip` h at which half of the loss has happened. With `memory` (m), friction
    follows its law only while the surfaces slide: df/dt = −max(s, s₀)/d_c (f − f(s)) with d_c = `memory` and
    s₀ = `memory_slip` (m/s), from f = 1 at the leading edge.
    """

    kind: LawName
    limit: float = 1.0
    half_slip: float = 1.0
    table: tuple[tuple[float, float], ...] = ()
    memory: float = 0.0
    memory_slip: float = 1e-3

    def factor(self, speed: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """f and df/ds (s/m) at slip speeds in m/s."""
        loss, scaled = 1.0 - self.limit, speed / self.half_slip
        if self.kind == "exponential":
            falling = loss * np.exp2(-scaled)
            return self.limit + falling, -np.log(2.0) / self.half_slip * falling
        if self.kind == "rational":
            falling = loss / (1.0 + scaled)
            return self.limit + falling, -falling / (1.0 + scaled) / self.half_slip
        if self.kind == "linear":
            falls = scaled < 2.0
            return np.where(falls, 1.0 - 0.5 * loss * scaled, self.limit), np.where(falls, -0.5 * loss / self.half_slip, 0.0)
        speeds, factors = np.array(self.table).T
        slopes = np.append(np.diff(factors) / np.diff(speeds), 0.0)
        interval = np.clip(np.searchsorted(speeds, speed, side="right") - 1, 0, None)
        return np.interp(speed, speeds, factors), slopes[interval]

    @property
    def lowest(self) -> float:
        """The smallest factor at any slip speed."""
        return min(factor for _, factor in self.table) if self.table else min(1.0, self.limit)

    @property
    def steepest(self) -> float:
        """The largest |df/ds| at any slip speed, in s/m."""
        if self.table:
            return float(np.abs(self.factor(np.array([speed for speed, _ in self.table]))[1]).max())
        return float(np.abs(self.factor(np.zeros(1))[1][0]))
