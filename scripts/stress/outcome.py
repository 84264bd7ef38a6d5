"""What became of one random case."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Pair:
    """Estimated and true error of one scalar on `grid` elements per side, over the scalar's `error_scale`."""

    grid: int
    scalar: str
    estimate: float
    true: float


@dataclass(frozen=True)
class Outcome:
    """What became of the case of `seed` of a `population`.

    It converged, or has a `reason`; `excused` says that it need not converge. `broken` tells of crashes and of what does not
    hold of the result. `work` counts applications of the tangential operator on the finest grid, `seconds` are of processor
    time."""

    converged: bool = False
    reason: str = ""
    excused: bool = False
    broken: tuple[str, ...] = ()
    work: int = 0
    pairs: tuple[Pair, ...] = ()
    population: str = ""
    seed: int = 0
    seconds: float = 0.0

    def __str__(self) -> str:
        what = "; ".join(self.broken) or self.reason or "converged"
        excused = " (excused)" if self.excused else ""
        return f"{self.population} {self.seed} ({self.work} applications, {self.seconds:.1f} s): {what}{excused}"
