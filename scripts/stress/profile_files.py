"""Seeded outlines in files of every format, with headers and spellings of instruments and programs, written and read again."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from scripts.stress.outcome import Outcome
from scripts.stress.wheelsets import MEASURED, RAILS, ROOT, WHEELS
from thermoroll_cli import Case, CaseError
from thermoroll_cli.files.csv_table import TableError
from thermoroll_cli.files.profile_file import read_outline, read_profile
from thermoroll_cli.problem.geometry import Unsolvable

SHIPPED = {"file": str(ROOT / WHEELS[0][0])}, {"file": str(ROOT / RAILS[0][0])}
"""Tables of a wheel and a rail."""
FILES = sorted(path for folder in (MEASURED, MEASURED.parent / "synthetic_profiles", ROOT / "cases")
               for path in folder.iterdir() if path.suffix.lower() in (".whl", ".ban", ".prr", ".prw", ".csv"))
WORDS = (b"", b"nan", b"-inf", b"1e308", b"1e400", b"5e-324", b"1,5", b"1.2.3", b"1_0", b"\xb5", b"\x00", b'"', b";", b"=",
         b"\x1b[31m", b"1D+02", b"ColumnDef=Y,X", b"ColumnDef=,", b"XOffset=1e300", b"YOffset=nan", b"units.len.f = 0",
         b"units.len.f = nan", b"shift.z = inf", b"bound.y.min = nan", b"rotate = nan", b"point.begin", b"spline.end")
"""Files of instruments and programs, and what may stand in them where something else should."""
SAME = 2e-4
"""Distance (mm) of a point from itself: files have four decimals, or five digits with an exponent."""


@dataclass(frozen=True)
class ProfileFile:
    """A file `name` with its `text`, and the points [y, z] (mm, z down) that it means, of a `wheel` or a rail."""

    name: str
    text: str
    points: tuple[tuple[float, float], ...]
    wheel: bool


def random_file(seed: int) -> ProfileFile:
    """A rail or a wheel with noise, of a right or a left side, in one of the formats."""
    rng = np.random.default_rng([61, seed])
    wheel = bool(rng.random() < 0.5)
    count = int(rng.integers(40, 300))
    y = np.sort(rng.uniform(-70.0, 60.0, count)) if wheel else np.linspace(-36.0, 36.0, count)
    # A flange reaches down, and a rim's face up by more than that; the sides of a rail's head reach down.
    flange = 28.0 * np.exp(-(((y + 55.0) / 9.0) ** 2)) - 0.05 * y - rng.uniform(0.0, 40.0) * (y > 55.0)
    z = (flange if wheel else 20.0 * (np.abs(y) / 36.0) ** 8 + y**2 / 600.0) + rng.normal(0.0, 4e-3, len(y))
    z = z + rng.uniform(-5.0, 5.0)
    write = [_simpack, _miniprof, _columns][int(rng.integers(3))]
    ending, text = write(rng, y, z, wheel)
    return ProfileFile(f"profile{ending}", text, tuple(zip(y.tolist(), z.tolist(), strict=True)), wheel)


def _number(value: float, kind: str) -> str:
    if kind == "fortran":
        return f"{value:.7E}".replace("E", "D")
    return f"{value:.4f}".replace(".", "," if kind == "comma" else ".")


def _rows(rng: np.random.Generator, y: np.ndarray, z: np.ndarray, separators: list[str], more: bool) -> list[str]:
    kind = str(rng.choice(["plain", "comma", "fortran"]))
    separator = str(rng.choice([each for each in separators if kind != "comma" or each != ","]))
    behind = f"{separator}{_number(1.5, kind)}" if more else ""
    return [f"{_number(one, kind)}{separator}{_number(other, kind)}{behind}" for one, other in zip(y, z, strict=True)]


def _simpack(rng: np.random.Generator, y: np.ndarray, z: np.ndarray, wheel: bool) -> tuple[str, str]:
    metres, sides, down = rng.random() < 0.3, rng.random() < 0.3, rng.random() < 0.3
    scale = 1e-3 if metres else 1.0
    values = (f"{scale * (-1.0 if sides else 1.0) * one:.8f} {scale * (-1.0 if down else 1.0) * other:.8f}"
              for one, other in zip(y, z, strict=True))  # fmt: skip
    head = ["header.begin", f"  type = {int(wheel)}", "header.end", "spline.begin", "  approx.smooth = 0.000000",
            f"  units.len.f = {'1.0D+00' if metres else '1000.'}", f"  mirror.y = {int(sides)}", f"  mirror.z = {int(down)}",
            "  point.begin"]  # fmt: skip
    return (".prw" if wheel else ".prr"), "\n".join([*head, *values, "  point.end", "spline.end"]) + "\n"


def _miniprof(rng: np.random.Generator, y: np.ndarray, z: np.ndarray, wheel: bool) -> tuple[str, str]:
    """Y of a wheel points out of it, that of a rail either up or down: its sides say which."""
    up = not wheel and rng.random() < 0.5
    rows = _rows(rng, y, -z if up else z, ["\t", " "], rng.random() < 0.5)
    old = rng.random() < 0.5
    head = ["12 MAY 2009  10:31", "Wheel 7  left", "32.58 37.11 14.71  (Sd/Sh/qR)", ""] if old else [
        '"ProgramName=Profile"', "XYPoints=" + str(len(rows)), '"ColumnDef=X,Y"', ""]
    return (".whl" if wheel else ".ban"), "\n".join([*head, *rows]) + "\n"


def _columns(rng: np.random.Generator, y: np.ndarray, z: np.ndarray, wheel: bool) -> tuple[str, str]:
    head = ["y;z"] if rng.random() < 0.5 else []
    return ".csv", "\n".join([*head, *_rows(rng, y, z, [";", "\t", ","], False)]) + "\n"


def damaged_file(seed: int) -> ProfileFile:
    """A file of `random_file`, or one of an instrument or a program, with one to four changes as hands, programs and disks
    make them."""
    rng = np.random.default_rng([67, seed])
    whole = random_file(seed)
    name, content, wheel = whole.name, whole.text.encode(), whole.wheel
    if rng.random() < 0.6:
        path = FILES[rng.integers(len(FILES))]
        name, content, wheel = f"profile{path.suffix}", path.read_bytes(), path.suffix in (".whl", ".prw")
    for _ in range(rng.integers(1, 5)):
        lines = content.split(b"\n")
        k, word = int(rng.integers(len(lines))), WORDS[rng.integers(len(WORDS))]
        match int(rng.integers(9)):
            case 0:
                words = lines[k].split() or [b""]
                words[rng.integers(len(words))] = word
                lines[k] = b" ".join(words)
            case 1:
                lines.insert(k, word)
            case 2:
                lines.insert(k, lines[rng.integers(len(lines))])
            case 3:
                del lines[k]
            case 4:
                lines = [lines[:k], lines[k:], lines[::-1]][rng.integers(3)]
            case 5:
                lines = [line.replace(b".", b",") for line in lines]
            case 6:
                lines = [(b" ", b"\t", b";", b",")[rng.integers(4)].join(line.split()) for line in lines]
            case 7:
                spoiled = bytearray(content or b"0")
                spoiled[rng.integers(len(spoiled))] ^= 1 << int(rng.integers(8))
                lines = [bytes(spoiled)]
            case _:
                lines = [content.decode("latin-1").encode(("utf-16", "utf-8-sig", "utf-16-be")[rng.integers(3)])]
        content = b"\n".join(lines)
    return ProfileFile(name, content.decode("utf-8", "surrogateescape"), (), wheel)


def check_damaged(case: ProfileFile) -> Outcome:
    """Each reader, and a wheelset with the outline, take the file or refuse it, and readers name it."""
    broken = []
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / case.name
        path.write_bytes(case.text.encode("utf-8", "surrogateescape"))
        tables = ({"file": str(path)}, SHIPPED[1]) if case.wheel else (SHIPPED[0], {"file": str(path)})
        for read in (lambda: read_outline(path), lambda: read_profile(path), lambda: wheel_rail(*tables, -70.0).task):
            try:
                read()
            except TableError as cause:
                broken += [] if case.name in str(cause) else [f"refused without its name: {cause}"]
            except (CaseError, Unsolvable):
                continue
    return Outcome(converged=not broken, broken=tuple(broken))


def wheel_rail(wheel: dict[str, Any], rail: dict[str, Any], back: float) -> Case:
    """A wheelset of tables of profiles, with y (mm) of its flange back."""
    return Case.from_dict({
        "material": {"youngs_modulus_GPa": 210.0, "poisson_ratio": 0.28}, "load": {"friction_coefficient": 0.3},
        "rolling": {"speed_m_s": 1.0}, "track": {"rail_profile": rail},
        "wheelset": {"nominal_radius_mm": 460.0, "vertical_N": 1e5, "flange_back_mm": back, "wheel_profile": wheel}})


def check(case: ProfileFile) -> Outcome:
    """The points are those that were written, and a case with them is the same one, read back from its TOML or JSON."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / case.name
        path.write_text(case.text, encoding="utf-8")
        read = np.array(read_outline(path).content)
        given = wheel_rail({"file": str(path)} if case.wheel else SHIPPED[0], SHIPPED[1] if case.wheel else {"file": str(path)},
                           min(y for y, _ in case.points) if case.wheel else -70.0)
        same = given.task == Case.parse(given.to_toml()).task == Case.from_json(given.to_json()).task
    if not same:
        return Outcome(broken=(f"{case.name}: its case is another one when it is read back",))
    wanted = np.array(case.points)
    if read.shape != wanted.shape:
        return Outcome(broken=(f"{case.name} has {len(read)} points, not {len(wanted)}",))
    apart = float(np.abs(read - wanted).max())
    return Outcome(converged=apart < SAME, broken=() if apart < SAME else (f"{case.name}: a point lies {apart:.3g} mm off",))
