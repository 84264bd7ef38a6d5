"""Seeded outlines as people have them and profiles seldom are: noses and grooves, closed sections, the other hand, numbers with
few decimals, other units, upside down. A wheelset on them is solved, or refused with a reason, with pictures and conicity."""

from __future__ import annotations

import contextlib
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from scripts.stress.outcome import Outcome
from scripts.stress.profile_files import SHIPPED, wheel_rail
from scripts.stress.wheelsets import EXCUSES, RAILS, ROOT, violations
from thermoroll_cli import CaseError, conicity
from thermoroll_cli.files.profile_file import read_outline
from thermoroll_cli.many_contacts.wheelset.first_contact import facts_of
from thermoroll_cli.many_contacts.wheelset.wheelset_problem import WheelsetProblem
from thermoroll_cli.many_contacts.wheelset.wheelset_result import solve_wheelset
from thermoroll_cli.plots import style
from thermoroll_cli.plots.conicity_figure import draw_conicity
from thermoroll_cli.plots.wheelset_figures import section_figure
from thermoroll_cli.problem.geometry import Unsolvable
from thermoroll_cli.problem.problem import Numerics

Points = np.ndarray


@dataclass(frozen=True)
class Odd:
    """An outline of a rail as text with its keys, and of what kind it is."""

    kind: str
    text: str
    keys: dict[str, Any]
    shift: float


def random_outline(seed: int) -> Odd:
    """The outline of `seed`, always the same."""
    rng = np.random.default_rng([97, seed])
    kind = ("nose", "groove", "closed", "other hand", "rounded", "units")[seed % 6]
    keys: dict[str, Any] = {}
    points = {"nose": _nose, "groove": _groove, "closed": _closed}.get(kind, _rail)(rng)
    if kind == "other hand":
        # The gauge side ends above the gauge height, or the whole is mirrored, with its key or without.
        top = points[np.argmin(points[:, 1]), 0]
        points = points[points[:, 0] > top - rng.uniform(2.0, 30.0)]
        keys = {} if rng.random() < 0.5 else {"mirror": bool(rng.random() < 0.5)}
    if rng.random() < 0.3:
        points = points * [1.0, -1.0]
        keys |= {} if rng.random() < 0.3 else {"flip": bool(rng.random() < 0.7)}
    decimals = int(rng.integers(1, 5)) if kind == "rounded" else 6
    if kind == "rounded" and rng.random() < 0.5:
        keys["smoothing_mm"] = float(rng.uniform(1.0, 6.0))
    across, up = 1.0, 1.0
    if kind == "units":
        names = {"m": 1e-3, "mm": 1.0, "um": 1e3}
        unit, other = (str(rng.choice(list(names))) for _ in range(2))
        across, up = names[unit], names[other]
        keys |= {"unit": unit, "height_unit": other} if rng.random() < 0.7 else {}
    if rng.random() < 0.3:
        points = points[::-1]
    lines = (f"{across * round(float(y), decimals)!r} {up * round(float(z), decimals)!r}" for y, z in points)
    return Odd(kind, "\n".join(lines), keys, float(rng.uniform(-6.0, 6.0)))


def _rail(rng: np.random.Generator) -> Points:
    return np.array(read_outline(ROOT / RAILS[rng.integers(len(RAILS))][0]).content)


def _nose(rng: np.random.Generator) -> Points:
    """A nose of 8 to 40 mm with sloping faces, rounded or sharp, here and there beside a shelf."""
    width, fall, radius = float(rng.uniform(8.0, 40.0)), float(rng.uniform(15.0, 45.0)), float(rng.choice([0.0, 2.0, 8.0]))
    slope = float(rng.uniform(2.0, 8.0))
    y = np.linspace(-5.0 - fall / slope, width + fall / slope, int(rng.integers(40, 400)))
    outside = np.hypot(np.maximum(np.maximum(-y, y - width), 0.0), 0.3 * radius) - 0.3 * radius
    z = slope * outside + (y - 0.5 * width) ** 2 / (2.0 * float(rng.uniform(30.0, 300.0)))
    if rng.random() < 0.6:
        shelf = y[-1] + np.arange(1.0, float(rng.uniform(10.0, 60.0)), 1.0)
        y, z = np.concatenate((y, shelf)), np.concatenate((z, 0.0 * shelf + z[-1]))
    return np.stack((y, z), axis=1)


def _groove(rng: np.random.Generator) -> Points:
    """A V or a round groove between edges, as of a flangeway or a groove rail without its head."""
    steep = np.tan(np.radians(rng.uniform(20.0, 80.0, 2)))
    depth, y = float(rng.uniform(5.0, 40.0)), np.linspace(-1.0, 1.0, int(rng.choice([3, 41])))
    if rng.random() < 0.5:
        return np.stack((np.where(y < 0.0, y * depth / steep[0], y * depth / steep[1]), -depth * np.abs(y)), axis=1)
    half = float(rng.uniform(20.0, 50.0))
    y = np.linspace(-half, half, 101)
    return np.stack((y, -(y**2) / (2.0 * float(rng.uniform(30.0, 200.0)))), axis=1)


def _closed(rng: np.random.Generator) -> Points:
    """The section of a whole rail, or of its head alone, begun anywhere, either way round."""
    upper = _rail(rng)
    upper = upper[np.argsort(upper[:, 0])]
    upper[:, 1] -= upper[:, 1].min()
    low = float(upper[:, 1].max())
    web, foot, height = float(rng.uniform(6.0, 10.0)), float(rng.uniform(60.0, 80.0)), float(rng.uniform(120.0, 180.0))
    head = [[web, low + 10.0], [-web, low + 10.0]]
    whole = [[web, low + 10.0], [web, height - 30.0], [foot, height - 12.0], [foot, height], [-foot, height],
             [-foot, height - 12.0], [-web, height - 30.0], [-web, low + 10.0]]  # fmt: skip
    points = np.concatenate((upper, np.array(whole if rng.random() < 0.6 else head)))
    points = np.roll(points, int(rng.integers(len(points))), axis=0)
    return np.concatenate((points, points[:1])) if rng.random() < 0.7 else points


def check(odd: Odd) -> Outcome:
    """What a command does with the outline: reads, shows, solves, draws, and finds the conicity, or refuses it for a reason."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "rail.csv"
        path.write_text(odd.text, encoding="utf-8")
        try:
            case = wheel_rail(SHIPPED[0], {"file": str(path), **odd.keys}, -70.0).with_values(
                {"wheelset.lateral_shift_mm": odd.shift, "numerics.grid": 16})
            for key, record in case.profiles.items():
                case.readings[key].words(record)
            task = case.task
            assert isinstance(task, WheelsetProblem)
            with contextlib.suppress(Unsolvable):
                draw_conicity(Path(folder) / "conicity.png", conicity(case, [1.0, 3.0]), "", 20.0)
            facts_of(task)
            result = solve_wheelset(replace(task, contact=replace(task.contact, numerics=Numerics((16, 16)))))
            if result.contacts:
                style.save(section_figure(result), Path(folder) / "section.png", 20.0)
        except (CaseError, Unsolvable) as cause:
            return Outcome(reason=f"{odd.kind}: {cause}", excused=True)
    excused = any(words in result.reason for words in EXCUSES) or odd.kind in ("groove", "other hand", "nose")
    return Outcome(result.converged, f"{odd.kind}: {result.reason}" if result.reason else "", excused=excused,
                   broken=violations(task, result) if result.converged else ())
