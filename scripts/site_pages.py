"""Pages of the site that are made when it is built (a hook of MkDocs, see mkdocs.yml): the README as its first page, a
gallery of cases/ with their pictures, and the reference of the Python interface."""

from __future__ import annotations

import io
import pathlib
import re
from collections.abc import Iterable
from dataclasses import replace
from typing import Any

from mkdocs.structure.files import File, Files

import thermoroll_cli
from thermoroll_cli import Case, solve
from thermoroll_cli.plots import style
from thermoroll_cli.plots.pictures import figure
from thermoroll_cli.problem.problem import Problem

ROOT = pathlib.Path(__file__).parents[1]
SENTENCES = 3
USUAL = "traction"
KINDS = {
    "article_4_1": "pressure", "article_4_3_conformal": "pressure", "article_4_3_flat": "pressure",
    "article_4_3_non_conformal": "pressure", "ball_bearing": "summary", "coated_ball": "subsurface_upper",
    "coated_ball_heat": "summary", "crowned_roller": "profile", "hot_sliding": "subsurface_upper", "manchester": "section",
    "measured_wheelset": "section",
    "polymer_roller": "pressure", "polymer_tyre": "pressure", "twin_disc": "track", "two_point": "profile",
    "wheel_rail_sliding": "track", "worn_rail": "profile",
}  # fmt: skip
"""The picture that shows what a case is about, where that is not the traction."""


def on_files(files: Files, config: Any) -> Files:
    """Add the pages and pictures to those of docs/."""
    grid, cases = config["extra"]["gallery_grid"], sorted((ROOT / "cases").glob(config["extra"]["gallery_cases"]))
    files.append(File.generated(config, "index.md", content=first_page()))
    files.append(File.generated(config, "reference.md", content=reference()))
    files.append(File.generated(config, "gallery.md", content=gallery(cases, grid)))
    for path in cases:
        files.append(File.generated(config, f"gallery/{path.stem}.png", content=picture(path, grid)))
    return files


def first_page() -> str:
    """The README, with links that start from docs/."""
    text = (ROOT / "README.md").read_text(encoding="utf-8").replace("](docs/", "](")
    more = "The [gallery](gallery.md) shows all cases, the [reference](reference.md) all names of the Python interface."
    return text.replace("\n| question |", f"\n{more}\n\n| question |")


def reference() -> str:
    """A section for each public name of the package, from its docstring."""
    places = thermoroll_cli._PLACES
    sections = "".join(f"::: {places[name]}.{name}\n\n" for name in sorted({*places} & {*thermoroll_cli.__all__}))
    opening = "# Python reference\n\nAll names are imported from `thermoroll_cli` ([examples](read_results.md#in-python)).\n\n"
    return opening + sections


def gallery(cases: Iterable[pathlib.Path], grid: int) -> str:
    """Picture, title, the first sentences of the comment and the commands of each case."""
    sections = []
    for path in cases:
        case = Case.read(path)
        words, commands = summary(case.text)
        shown = "\n".join(commands or [f"thermoroll run cases/{path.name} -o results"])
        sections.append(
            f"## {case.settings.title}\n\n`cases/{path.name}`\n\n{words}\n\n"
            f"```sh\n{shown}\n```\n\n"
            f"![{KINDS.get(path.stem, USUAL)} of {path.stem}](gallery/{path.stem}.png)\n"
        )
    opening = (f"# Gallery\n\nThe cases in `cases/`, each with the picture of its subject on {grid} × {grid} elements. "
               "Maps are seen from below ([frames](frames.md)).\n\n")
    return opening + "\n".join(sections)


def summary(text: str) -> tuple[str, list[str]]:
    """The first sentences of a case's comment, and the commands in it."""
    comment = re.match(r"(?:#.*\n)+", text)
    assert comment is not None, "a case begins with a comment"
    lines = [line.removeprefix("#").strip() for line in comment[0].splitlines()]
    words = " ".join(line for line in lines if line and not line.startswith("thermoroll "))
    sentences = re.split(r"(?<=[.;)] )(?<!Sec\. )(?<!Fig\. )(?=[A-Z])", words)
    commands = [line for line in lines if re.match(r"thermoroll (run|sweep|wear) .*\.toml", line)]
    return "".join(sentences[:SENTENCES]).strip(" :;"), commands


def picture(path: pathlib.Path, grid: int) -> bytes:
    """The picture of what a case is about, on a `grid` per side; of a wheelset the section across the track."""
    kind = KINDS.get(path.stem, USUAL)
    task = Case.read(path).with_values({"numerics.grid": grid}).task
    file = io.BytesIO()
    with style.applied():
        if isinstance(task, Problem):
            shown = figure(solve(task if kind.startswith("subsurface") else replace(task, subsurface=None)), kind)
        else:
            shown = figure(solve(task))
        assert shown is not None, f"{path.stem} has a picture {kind}"
        shown.savefig(file, format="png", dpi=100)
    return file.getvalue()
