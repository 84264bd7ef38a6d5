"""From measurements to a case: the values of some keys with which computed scalars come closest to measured ones.

Least squares over the residuals (computed − measured)/σ, σ the measured standard deviation or the largest measured value of the
scalar; trust-region reflective steps (Branch, Coleman and Li 1999, SIAM J. Sci. Comput. 21, by SciPy), on a coarse grid first.
Around the solution the model is taken as linear: the 95 % interval of a value is t √(s² (JᵀJ)⁻¹) with Student's t of the
degrees of freedom (Seber and Wild 1989, Nonlinear Regression, 5.1), combined with how far the estimated errors of
discretisation move the value, as of one sign at all points and as independent of each other."""

from __future__ import annotations

import contextlib
import datetime
import hashlib
import json
import math
import os
import pathlib
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import chain, combinations, repeat
from typing import Any

import numpy as np
from scipy.optimize import least_squares
from scipy.special import stdtrit

from thermoroll_cli.files.case import Case, CaseError
from thermoroll_cli.files.case_line import is_line
from thermoroll_cli.files.case_schema import allowed_values, entry_at
from thermoroll_cli.files.case_source import CaseSource, Override, key_path
from thermoroll_cli.plots.fit_figures import Figure, fit_figure
from thermoroll_cli.plots.sweep_figures import words_of
from thermoroll_cli.problem.names import PER_LENGTH, PLACES, known_as, unit_of
from thermoroll_cli.problem.scalar_errors import number, with_error
from thermoroll_cli.studies.sweeps.measured import OVER_LOAD, Measured, at_place, scalar_in
from thermoroll_cli.studies.sweeps.points import Axis, Base, Points, key_of
from thermoroll_cli.studies.sweeps.sweep import summaries
from thermoroll_cli.tools.arrays import Array, Mask
from thermoroll_cli.tools.atomic import write_bytes
from thermoroll_cli.tools.journal import ALTERNATIVES
from thermoroll_cli.tools.runner import Processes, check_main_guard

COARSE = 32
"""Elements of the longer side of the grid on which a fit begins."""
STEP = 1e-2
"""Step of the differences, in the logarithm or in the start's value: far above what solvers leave (1e-5), small enough that the
iteration gains two digits a step."""
DECADE = 10.0
"""A positive value whose range spans this factor is fitted as its logarithm."""
CLOSE = {"coarse": 1e-2, "fine": 1e-3}
"""Relative change of the values with which each stage ends. With 1e-4 on the fine grid: up to 1.4 times the cases, for values
that differ by less than 2e-3 of their intervals."""
SOLVED = 1e-4
"""Share of the computed values that the fit leaves at least: solvers are not closer, and exact data determine no more."""
MOST_STEPS = 40
CORRELATED, DEPENDENT = 0.95, 1e-6
"""Two values correlated more than that are not told apart; nor what changes the residuals by this share of the others."""
AT_BOUND = 1e-3
"""A value as near to the end of its range is at it, in the logarithm or in the start's value."""
BAND_PROBABILITY = 0.95


@dataclass(frozen=True)
class Free:
    """A key whose value is sought: its `start` in the case and its range from `low` to `high`, in the unit of the key."""

    key: str
    start: float
    low: float
    high: float

    @classmethod
    def parse(cls, text: str, case: CaseSource) -> Free:
        """KEY or KEY=LOW:HIGH, which begins at the value in `case`, or in the middle of the range where the case has none.
        Without a range the whole one of the key is meant. Raises ValueError: not a key that takes a number, neither a value in
        the case nor a range, no range, a start outside of it."""
        key, equals, written = (part.strip() for part in text.partition("="))
        entry = entry_at(key_path(key))
        if "minimum" not in entry or entry.get("type") != "number":
            takes = f"takes one range of numbers: it is {allowed_values(key_path(key))}" if entry else "a case has"
            raise ValueError(f'"{key}" is not a key that {takes}')
        low, high = float(entry["minimum"]), float(entry["maximum"])
        if equals:
            ends = written.split(":")
            try:
                lowest, highest = (float(end) for end in ends)
            except ValueError:
                raise ValueError(f'"{text}" is not of the form KEY or KEY=LOW:HIGH') from None
            if not low <= lowest < highest <= high:
                raise ValueError(f'"{text}": LOW must be below HIGH, and {key} {allowed_values(key_path(key))}')
            low, high = lowest, highest
        value = case.get(key_path(key))
        if not isinstance(value, int | float):
            if not equals:
                raise ValueError(f"{key} has no value in {case.name}: give a range, {key}=LOW:HIGH, or write a value there for "
                                 "the fit to begin with")
            value = math.sqrt(low * high) if low > 0.0 and high / low >= DECADE else 0.5 * (low + high)
        if not low <= value <= high:
            raise ValueError(f"{key} begins at {value:g}, outside of its range from {low:g} to {high:g}")
        if value == 0.0 and not equals:
            raise ValueError(f"{key} begins at 0: give its range, {key}=LOW:HIGH")
        return cls(key, float(value), low, high)

    @classmethod
    def parse_all(cls, texts: Iterable[str], case: Case) -> list[Free]:
        """Those of a whole case, with all its defaults. Raises as `parse`."""
        resolved = CaseSource(case.name, "", json.loads(case.to_json()))
        return [cls.parse(text, resolved) for text in texts]

    @property
    def logarithmic(self) -> bool:
        return self.start > 0.0 and self.low >= 0.0 and (self.low == 0.0 or self.high / self.low >= DECADE)

    @property
    def unit(self) -> float:
        """What a change by 1 means where the value itself is fitted."""
        return abs(self.start) or self.high - self.low

    def coordinate(self, value: float) -> float:
        """The number that is fitted in place of a value."""
        if self.logarithmic:
            return math.log(value) if value > 0.0 else -math.inf
        return value / self.unit

    def value(self, coordinate: float) -> float:
        wanted = math.exp(coordinate) if self.logarithmic else coordinate * self.unit
        return min(max(wanted, self.low), self.high)

    def half_width(self, value: float, half: float) -> float:
        """The uncertainty in the unit of the key that belongs to `half` of an interval of the fitted number."""
        return value * math.expm1(half) if self.logarithmic else half * self.unit

    @property
    def widest(self) -> float:
        """Half of an interval that says nothing any more: a factor of e, or half of the range."""
        return 1.0 if self.logarithmic else 0.5 * (self.high - self.low) / self.unit


@dataclass(frozen=True)
class Parameter:
    """A value that was found, with half of its 95 % interval; nan if the data do not determine it. `doubt` says so in words,
    and of an interval that contains 0."""

    value: float
    uncertainty_95: float
    doubt: str = "not determined"

    @property
    def text(self) -> str:
        """The value with its interval."""
        return with_error(self.value, self.uncertainty_95) if math.isfinite(self.uncertainty_95) else number(self.value, 4)

    @property
    def remark(self) -> str:
        """The doubt in brackets, to follow the value."""
        return f" ({self.doubt})" if self.doubt else ""


@dataclass(frozen=True)
class Fit:
    """Outcome of a fit.

    - `parameters`: by key; `correlation`: between the fitted numbers, by key and key;
    - `rms`: of computed less measured values, by scalar, in its unit; `computed`: the computed values, by scalar, (points,),
      and `band`: half of their 95 % band, empty without a solution;
    - `case`: the case with the values found; `measured`: the points that count;
    - `converged`, `reason`, `warnings`, `degrees_of_freedom`; `solved`: the number of solved cases."""

    case: Case
    measured: Measured
    parameters: Mapping[str, Parameter]
    correlation: Mapping[str, Mapping[str, float]]
    rms: Mapping[str, float]
    computed: Mapping[str, Array]
    band: Mapping[str, Array]
    degrees_of_freedom: int
    reason: str
    warnings: tuple[str, ...]
    solved: int

    @property
    def converged(self) -> bool:
        return not self.reason

    def record(self) -> dict[str, Any]:
        """The outcome in plain JSON types; null for what the data do not determine."""
        def known(value: float) -> float | None:
            return value if math.isfinite(value) else None

        return {
            "status": "converged" if self.converged else "not_converged", "reason": self.reason,
            "parameters": {key: {"value": found.value, "uncertainty_95": known(found.uncertainty_95), "doubt": found.doubt}
                           for key, found in self.parameters.items()},
            "correlation": {key: {other: known(value) for other, value in row.items()}
                            for key, row in self.correlation.items()},
            "rms": dict(self.rms), "points": len(self.measured), "degrees_of_freedom": self.degrees_of_freedom,
            "warnings": list(self.warnings)}  # fmt: skip

    def save(self, folder: pathlib.Path, name: str, asked: Mapping[str, Any] | None = None) -> list[pathlib.Path]:
        """Write NAME_fit.toml and NAME_fit.json, with what was `asked`, into `folder`, and return their paths. Raises
        OSError."""
        case, record = folder / f"{name}_fit.toml", folder / f"{name}_fit.json"
        rms = ", ".join(f"{scalar} {value:.3g}" for scalar, value in self.rms.items())
        head = [f"Fitted to {len(self.measured)} points of {self.measured.source} on {datetime.date.today().isoformat()};",
                f"root mean square of computed less measured: {rms}."]
        head += [f"{key} = {number(found.value, 6)}"
                 + (f" ± {found.uncertainty_95:.2g}, 95 %" if math.isfinite(found.uncertainty_95) else "") + found.remark
                 for key, found in self.parameters.items()]
        text = "".join(f"# {' '.join(line.split())}\n" for line in head) + "\n" + self.case.to_toml()
        write_bytes(case, text.encode())
        content = {"name": name, **self.record(), **({"asked": asked} if asked else {})}
        write_bytes(record, (json.dumps(content, indent=1, ensure_ascii=False) + "\n").encode())
        return [case, record]

    def figure(self) -> Figure:
        """The measured points, the curve with its band, and the residuals, as a matplotlib figure."""
        measured = self.measured
        varying = [key for key, column in measured.varied.items() if np.ptp(column) > 0.0]
        over = varying[0] if len(varying) == 1 and self.band else ""
        unit, factor = measured.written.get(over, ("", 1.0))
        places = measured.varied[over] / factor if over else np.arange(1.0, len(measured) + 1.0)
        found = [f"{words_of(key).partition(' (')[0]} {one.text} {unit_of(key)}".rstrip() + one.remark
                 for key, one in self.parameters.items()]
        words = f"{words_of(over).partition(' (')[0]} ({unit})" if over and unit else words_of(over) if over else ""
        return fit_figure(self.case.settings.title, places, words, measured.values, measured.deviations, self.computed,
                          self.band, found, converged=self.converged)


@dataclass
class _Model:
    """Computed values at the measured points, as a function of the fitted numbers; `processes` share the points."""

    case: Case
    free: Sequence[Free]
    measured: Measured
    processes: Processes | None
    settings: tuple[Override, ...] = ()
    solved: int = 0
    report: Callable[[int], None] = lambda count: None
    _known: dict[bytes, tuple[Array, Array, list[str]]] = field(default_factory=dict)

    def at(self, numbers: Sequence[Array]) -> list[tuple[Array, Array, list[str]]]:
        """For each vector of fitted numbers (n,): computed values and their estimated errors, both (scalars, points), and the
        reason for each point without a steady state."""
        count, place = len(self.measured), next((name for name in PLACES if name in self.measured.varied), "")
        varied = {name: column for name, column in self.measured.varied.items() if name != place}
        rows = [[*(free.value(number) for free, number in zip(self.free, vector, strict=True)),
                 *(float(column[point]) for column in varied.values())] for vector in numbers for point in range(count)]
        keys = [*(free.key for free in self.free), *varied]
        different = list(dict.fromkeys(map(tuple, rows)))
        axes = tuple(Axis(key, column) for key, column in zip(keys, zip(*different, strict=True), strict=True))
        base = Base(self.case.to_toml(), self.case.name, self.case.name)
        points = Points.of([base], axes, self.settings, listed=True, origin="fit")
        points = points.with_one_decision()
        # A vector is a batch, so that the values do not depend on who computes them.
        size = -(-len(different) // len(numbers))
        batches = [range(first, min(first + size, len(different) + 1)) for first in range(1, len(different) + 1, size)]
        try:
            solved = list((self.processes.map if self.processes else map)(summaries, repeat(points), batches))
        except BrokenProcessPool:  # killed, or out of memory, of which one process needs least
            self.processes = None
            solved = list(map(summaries, repeat(points), batches))
        outcomes = dict(zip(different, chain.from_iterable(solved), strict=True))
        self.solved += len(different)
        self.report(self.solved)
        outcome = []
        for start in range(0, len(rows), count):
            here = [outcomes[tuple(each)] for each in rows[start : start + count]]
            if place:
                at = self.measured.varied[place].tolist()
                here = [one if isinstance(one, str) else at_place(place, where, one)
                        for one, where in zip(here, at, strict=True)]
            names, values = list(self.measured.values), np.full((2, len(self.measured.values), count), math.nan)
            reasons = [one if isinstance(one, str) else one["reason"] for one in here]
            for point, summary in enumerate(here):
                if isinstance(summary, str):
                    continue
                load = float(summary.get(known_as("normal_N", summary), math.nan))
                for k, name in enumerate(names):
                    values[0, k, point] = scalar_in(name, summary, load)
                    error = summary["uncertainty"].get(known_as(OVER_LOAD.get(name, name), summary), math.nan)
                    values[1, k, point] = error / (load if name in OVER_LOAD else 1.0)
                    if math.isnan(values[0, k, point]):
                        reasons[point] = reasons[point] or f"{name} is not computed in this case"
            outcome.append((values[0], values[1], reasons))
        return outcome

    def one(self, vector: Array) -> tuple[Array, Array, list[str]]:
        """`at` for one vector, remembered: steps and derivatives ask for the same."""
        key = np.asarray(vector).tobytes()
        if key not in self._known:
            self._known[key] = self.at([vector])[0]
        return self._known[key]

    @property
    def weights(self) -> Array:
        return np.array([1.0 / self.measured.scale(name) for name in self.measured.values])

    def residuals(self, vector: Array) -> Array:
        """(computed − measured)/σ, (scalars · points,); inf, from which the step is shortened, without a steady state."""
        computed, _, reasons = self.one(vector)
        if any(reasons):
            return np.full(computed.size, math.inf)
        return np.asarray((computed - np.array(list(self.measured.values.values()))) * self.weights).ravel()

    def jacobian(self, vector: Array) -> Array:
        """Derivatives of the residuals, (scalars · points, values): one-sided differences, away from the end of a range.

        Raises ArithmeticError if there is no steady state on either side."""
        here, moved = self.one(vector)[0], []
        for k, free in enumerate(self.free):
            sign = -1.0 if vector[k] + STEP > free.coordinate(free.high) else 1.0
            moved.append(vector + sign * STEP * np.eye(len(vector))[k])
        slopes = []
        for k, (values, _, reasons) in enumerate(self.at(moved)):
            step = moved[k][k] - vector[k]
            if any(reasons):
                step = -step
                values, _, reasons = self.at([vector + step * np.eye(len(vector))[k]])[0]
            if any(reasons):
                raise ArithmeticError(f"no steady state beside {self.free[k].key} = {self.free[k].value(vector[k]):.6g}: "
                                      f"{next(filter(None, reasons))}")
            slopes.append(((values - here) / step * self.weights).ravel())
        return np.stack(slopes, axis=1)


def asked_of(case: Case, measured: Measured, free: Sequence[str]) -> dict[str, Any]:
    """What a fit is asked for, by which it is known again."""
    columns = {name: column.tolist() for part in (measured.varied, measured.values, measured.deviations)
               for name, column in part.items()}
    content = hashlib.sha256(json.dumps(columns, sort_keys=True).encode()).hexdigest()[:32]
    return {"case": key_of(case), "data": pathlib.Path(measured.source).name, "content": content, "free": list(free)}


def check_replaced(path: pathlib.Path, asked: Mapping[str, Any]) -> None:
    """Raises FileExistsError where the record of a fit at `path` is of another one than is `asked` for."""
    try:
        there = json.loads(path.read_text(encoding="utf-8")).get("asked", {})
    except (OSError, ValueError, AttributeError):  # none, or no record
        return
    if there != asked:
        what = " and ".join(words for words, keys in (("another case", ["case"]), ("other data", ["data", "content"]),
                                                      ("other free keys", ["free"]))
                            if any(there.get(key) != asked[key] for key in keys))
        raise FileExistsError(f"{path} is of a fit of {', '.join(there.get('free', ()))} to {there.get('data', 'other data')}, "
                              f"not of {', '.join(asked['free'])} to {asked['data']} ({what}): {ALTERNATIVES}")


def case_of_fit(source: CaseSource, name: str, free: Iterable[str]) -> Case:
    """The case of a text, in which keys that are `free` may be missing, though it needs them: they begin within their ranges.
    Raises CaseError, and ValueError for a key that cannot be free."""
    try:
        return Case.from_source(source, name)
    except CaseError:
        wanted = [Free.parse(text, source) for text in free]
        missing = [Override(key_path(one.key), one.start, f"{one.key}={one.low:g}:{one.high:g}", "--free")
                   for one in wanted if source.get(key_path(one.key)) is None]
        if not missing:
            raise
        return Case.from_source(source.overridden(missing), name)


def fit(
    case: Case | Mapping[str, Any] | str | os.PathLike[str],
    data: Measured | Mapping[str, Sequence[float]] | str | os.PathLike[str],
    free: Iterable[str], *, jobs: int = 1, skip_failed: bool = False, report: Callable[[int], None] = lambda count: None,
) -> Fit:
    """Find the values of some keys of a case from measurements, as `thermoroll fit` does.

    Parameters:

    - `case`: as of `solve`; the values begin at those in the case;
    - `data`: a CSV file, or a mapping or `DataFrame` of its columns: keys of the case that were varied, scalars that were
      measured (also `force_x_over_load`), and NAME_error for their standard deviations;
    - `free`: the keys, each as "KEY" or "KEY=LOW:HIGH", in the units of the keys;
    - `jobs`: processes that share the work;
    - `skip_failed`: leaves out points that have no steady state at the start, with a warning;
    - `report`: called with the number of cases solved so far.

    Returns a `Fit`.

    Raises CaseError for an invalid case or point; ValueError, with file and line, for data or keys that make no sense, fewer
    values than keys, and a point without a steady state; OSError."""
    case, measured = Case.of(case), Measured.of(data)
    wanted = Free.parse_all(free, case)
    names = [one.key for one in wanted]
    if not wanted or len(set(names)) < len(names):
        raise ValueError("name each key that is free, and each once" if wanted else "no key is free")
    if both := next((name for name in names if name in measured.varied), None):
        raise ValueError(f"{both} is free, and a column of {measured.source}")
    if jobs > 1:
        check_main_guard()
    with Processes(jobs) if jobs > 1 else contextlib.nullcontext() as processes:
        return _found(_Model(case, wanted, measured, processes, report=report), skip=skip_failed)


def _found(model: _Model, *, skip: bool) -> Fit:
    """The fit, on the coarse grid first."""
    ends = np.array([[one.coordinate(one.low), one.coordinate(one.high)] for one in model.free]).T
    # Not at an end of a range: a key that acts by its square has no slope at 0.
    inside = np.minimum(10 * STEP, 0.25 * (ends[1] - ends[0]))
    vector = np.clip([one.coordinate(one.start) for one in model.free], ends[0] + inside, ends[1] - inside)
    coarse = _coarser(model.case)
    model, warnings = _with_steady_points(replace(model, settings=coarse or _asked(model), _known={}), vector, skip=skip)
    values = len(model.measured) * len(model.measured.values)
    if values < len(model.free):
        raise ValueError(f"{model.measured.source}: {values} measured values do not determine {len(model.free)} keys")
    reason, jacobian = "", np.full((values, len(model.free)), math.nan)
    for stage in ("coarse", "fine") if coarse else ("fine",):
        more: list[str] = []
        if stage == "fine" and coarse:
            model, more = _with_steady_points(replace(model, settings=_asked(model), _known={}), vector, skip=skip)
            warnings = [*warnings, *more]
        try:
            # Values change so little on the fine grid that the slopes of the coarse one, where it ended, lead there.
            of_coarse = stage == "fine" and coarse and not more
            slopes = partial(lambda kept, _: kept.copy(), jacobian) if of_coarse else model.jacobian
            # SciPy wants the start inside of the range.
            inside = np.clip(vector, ends[0] + AT_BOUND / 10, ends[1] - AT_BOUND / 10)
            found = least_squares(model.residuals, inside, slopes, ends, xtol=CLOSE[stage], ftol=CLOSE[stage] ** 2,
                                  gtol=1e-12, max_nfev=MOST_STEPS)
        except (ArithmeticError, ValueError) as cause:
            reason = str(cause)
            break
        vector, jacobian = found.x, found.jac
        reason = "" if found.status > 0 else f"the values still change after {MOST_STEPS} steps"
    return _result(model, jacobian, vector, ends, reason, warnings)


def _coarser(case: Case) -> tuple[Override, ...]:
    """The setting of the coarse grid; nothing if the case's is as coarse."""
    grid = case.settings.numerics.grid
    sides = [grid, grid] if isinstance(grid, int) else list(grid or (2 * COARSE, 2 * COARSE))
    if max(sides) <= COARSE:
        return ()
    both = [max(8, round(side * COARSE / max(sides))) for side in sides]
    coarse = both if isinstance(grid, tuple) else both[0]
    return (Override(("numerics", "grid"), coarse, f"numerics.grid={coarse}", "fit"),)


def _asked(model: _Model) -> tuple[Override, ...]:
    """The setting by which only what was measured has to be accurate; nothing where the case has a grid, or says so itself."""
    numerics = model.case.settings.numerics
    if numerics.grid is not None or numerics.accuracy_of is not None:
        return ()
    names = [OVER_LOAD.get(name, name) for name in model.measured.values]
    if is_line(vars(model.case.settings)):
        names = [PER_LENGTH.get(name, name) for name in names]
    return (Override(("numerics", "accuracy_of"), names, f"numerics.accuracy_of={names}", "fit"),)


def _with_steady_points(model: _Model, vector: Array, *, skip: bool) -> tuple[_Model, list[str]]:
    """The model of the points that have a steady state, and a warning that names the others. Raises ValueError for one without,
    unless they are to be left out."""
    _, _, reasons = model.one(vector)
    failed = [number for number, reason in enumerate(reasons) if reason]
    if not failed:
        return model, []
    text = "; ".join(f"{model.measured.place(number)}: {reasons[number]}" for number in failed[:3])
    if not skip or len(failed) == len(reasons):
        raise ValueError(f"{text}{'; …' if len(failed) > 3 else ''}; begin with other values of "
                         f"{', '.join(one.key for one in model.free)} in the case, or leave such points out by --skip-failed")
    kept = [number for number, reason in enumerate(reasons) if not reason]
    return (replace(model, measured=model.measured.only(kept), _known={}),
            [f"points without a steady state are left out ({len(failed)}): {text}{'; …' if len(failed) > 3 else ''}"])


def _result(
    model: _Model, jacobian: Array, vector: Array, ends: Array, reason: str, warnings: Sequence[str]
) -> Fit:
    """The outcome at `vector`, with the `jacobian` of the residuals there."""
    measured, free = model.measured, model.free
    computed, errors, _ = model.one(vector)
    residuals = model.residuals(vector)
    parameters = {one.key: Parameter(one.value(number), math.nan) for one, number in zip(free, vector.tolist(), strict=True)}
    freedom, correlation, band = residuals.size - len(free), np.full((len(free), len(free)), math.nan), dict[str, Array]()
    notes = list(warnings)
    if not reason:
        try:
            student_t = float(stdtrit(freedom, 0.5 + 0.5 * BAND_PROBABILITY)) if freedom else math.nan
            unknown_errors = [name for name, row in zip(measured.values, errors, strict=True) if np.isnan(row).any()]
            if unknown_errors:
                notes.append(f"the grid gives no estimated error of {unknown_errors[0]}: the values have no intervals")
            least = SOLVED * float(np.linalg.norm(computed * model.weights))
            rest = max(float(np.linalg.norm(residuals)), least)
            covariance, correlation, lost = _covariance(jacobian, rest, freedom)
            moved, error = np.linalg.pinv(jacobian), (errors * model.weights).ravel()
            half = np.sqrt(student_t**2 * np.diag(covariance) + (moved @ error) ** 2 + moved**2 @ error**2)
            at_bound = (vector - ends[0] < AT_BOUND) | (ends[1] - vector < AT_BOUND)
            notes += _undetermined(free, vector, at_bound, half, correlation, lost, freedom)
            # Values whose negative, in its range too, fits about as well.
            most = rest * math.hypot(1.0, student_t / math.sqrt(freedom)) if freedom else rest
            for k, one in enumerate(free):
                value = one.value(vector[k])
                if value != 0.0 and not one.logarithmic and one.low <= -value <= one.high:
                    mirrored = np.where(np.arange(len(vector)) == k, -vector, vector)
                    if np.linalg.norm(model.residuals(mirrored)) <= most:
                        notes.append(f"the data do not determine the sign of {one.key}: {-value:.6g} fits as well")
            widest = np.array([one.widest for one in free])
            correlated = (np.abs(correlation - np.diag(np.diag(correlation))) > CORRELATED).any(axis=1)
            unknown = lost | at_bound | correlated | np.logical_not(half <= widest)
            parameters = {one.key: _parameter(one, number, math.nan if lost else float(width))
                          for one, number, width, lost in zip(free, vector.tolist(), half, unknown, strict=True)}
            spread = np.sqrt(np.maximum(np.einsum("ni,ij,nj->n", jacobian, covariance, jacobian), 0.0))
            band = dict(zip(measured.values, student_t * spread.reshape(computed.shape) / model.weights, strict=True))
        except ArithmeticError as cause:
            reason = str(cause)
    found = {one.key: one.value(number) for one, number in zip(free, vector, strict=True)}
    difference = computed - np.array(list(measured.values.values()))
    return Fit(
        case=model.case.with_values(found), measured=measured, parameters=parameters,
        correlation={a.key: {b.key: float(correlation[i, j]) for j, b in enumerate(free)} for i, a in enumerate(free)},
        rms={name: float(np.sqrt(np.mean(row**2))) for name, row in zip(measured.values, difference, strict=True)},
        computed=dict(zip(measured.values, computed, strict=True)), band=band, degrees_of_freedom=freedom, reason=reason,
        warnings=tuple(notes), solved=model.solved)


def _parameter(free: Free, number: float, half: float) -> Parameter:
    """The value at the fitted `number`, with `half` of the interval of that number."""
    value = free.value(number)
    width = free.half_width(value, half)
    from_zero = free.logarithmic or width < abs(value)
    return Parameter(value, width, "not determined" if math.isnan(half) else "" if from_zero else "not distinct from 0")


def _covariance(jacobian: Array, rest: float, freedom: int) -> tuple[Array, Array, Mask]:
    """s² (JᵀJ)⁻¹ with the norm of what the fit leaves as `rest`, the correlations, and which values take part in a change that
    the residuals do not notice."""
    size = np.linalg.norm(jacobian, axis=0)
    lost = size <= DEPENDENT * max(float(size.max()), 1e-300)
    scaled = jacobian / np.where(size > 0.0, size, 1.0)
    _, singular, directions = np.linalg.svd(scaled, full_matrices=False)
    for value, direction in zip(singular, directions, strict=True):
        if value <= DEPENDENT * singular.max():
            lost = lost | (np.abs(direction) > 0.1)
    inverse = np.linalg.pinv(scaled.T @ scaled, hermitian=True) / np.outer(*2 * [np.where(size > 0.0, size, 1.0)])
    spread = np.sqrt(np.diag(inverse))
    correlation = inverse / np.where(np.outer(spread, spread) > 0.0, np.outer(spread, spread), math.nan)
    variance = rest**2 / freedom if freedom else math.nan
    return variance * inverse, correlation, lost


def _undetermined(
    free: Sequence[Free], vector: Array, at_bound: Mask, half: Array, correlation: Array, lost: Mask, freedom: int
) -> list[str]:
    """A warning for each value that the data do not determine."""
    notes = [] if freedom else ["as many values as measured ones: they have no uncertainty"]
    for k, one in enumerate(free):
        value = one.value(vector[k])
        if at_bound[k]:
            notes.append(f"{one.key} = {value:.6g} is at the end of its range, from {one.low:g} to {one.high:g}")
        elif lost[k]:
            notes.append(f"the data do not determine {one.key}: computed values hardly change with it")
        elif half[k] > one.widest:
            notes.append(f"the data do not determine {one.key}: its 95 % interval is wider than "
                         f"{'a factor of e to both sides' if one.logarithmic else 'its range'}")
        elif _parameter(one, vector[k], half[k]).doubt:
            notes.append(f"the data do not tell {one.key} from 0: {value:.3g} ± {one.half_width(value, half[k]):.2g}")
    for i, j in combinations(range(len(free)), 2):
        if abs(correlation[i, j]) > CORRELATED and not (lost[i] or lost[j]):
            notes.append(f"the data do not tell {free[i].key} from {free[j].key}: their correlation is "
                         f"{correlation[i, j]:.3f}; measure at other values of what was varied, or fix one of them")
    return notes
