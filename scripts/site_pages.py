"""Pages of the site that are made when it is built (a hook of MkDocs, see mkdocs.yml): the README as its first page, a
gallery of cases/ with their pictures, and the reference of the Python interface."""

from __future__ import annotations

import io
import pathlib
import re
from dataclasses import replace
from typing import Any

from mkdocs.structure.files import File, Files

import thermoroll_cli
from thermoroll_cli import Case, solve
from thermoroll_cli.plots.pictures import figure
from thermoroll_cli.plots.wheelset_figures import section_figure
from thermoroll_cli.wheelset.wheelset_problem import WheelsetProblem
from thermoroll_cli.wheelset.wheelset_result import solve_wheelset

ROOT = pathlib.Path(__file__).parents[1]
CASES = sorted((ROOT / "cases").glob("*.toml"))
GRID = 32
"""Elements per side of the gallery's pictures."""
SENTENCES = 3


def on_files(files: Files, config: Any) -> Files:
    """Add the pages and pictures to those of docs/."""
    files.append(File.generated(config, "index.md", content=first_page()))
    files.append(File.generated(config, "reference.md", content=reference()))
    files.append(File.generated(config, "gallery.md", content=gallery()))
    for path in CASES:
        files.append(File.generated(config, f"gallery/{path.stem}.png", content=picture(Case.read(path))))
    return files


def first_page() -> str:
    """The README, with links that start from docs/."""
    text = (ROOT / "README.md").read_text(encoding="utf-8").replace("](docs/", "](")
    more = "- [Gallery](gallery.md) of cases, [reference](reference.md) of the Python interface\n"
    return text.replace("\n- [Tutorial]", f"\n{more}- [Tutorial]")


def reference() -> str:
    """A section for each public name of the package, from its docstring."""
    places = thermoroll_cli._PLACES
    sections = "".join(f"::: {places[name]}.{name}\n\n" for name in sorted(places))
    return f"# Reference\n\nAll names are imported from `thermoroll_cli`; [python.md](python.md) shows their use.\n\n{sections}"


def gallery() -> str:
    """Picture, title and the first sentences of the comment of each case."""
    sections = []
    for path in CASES:
        case = Case.read(path)
        sections.append(
            f"## {case.settings.title}\n\n`cases/{path.name}`\n\n{summary(case.text)}\n\n"
            f"![Contact pressure of {path.stem}](gallery/{path.stem}.png)\n"
        )
    opening = f"# Gallery\n\nThe cases in `cases/` with the pressure on {GRID} × {GRID} elements.\n\n"
    return opening + "\n".join(sections)


def summary(text: str) -> str:
    """The first sentences of a case's comment, without the commands in it."""
    comment = re.match(r"(?:#.*\n)+", text)
    assert comment is not None, "a case begins with a comment"
    lines = (line.removeprefix("#").strip() for line in comment[0].splitlines())
    words = " ".join(line for line in lines if line and not line.startswith("thermoroll "))
    sentences = re.split(r"(?<=[.;)] )(?<!Sec\. )(?<!Fig\. )(?=[A-Z])", words)
    return "".join(sentences[:SENTENCES]).strip(" :;")


def picture(case: Case) -> bytes:
    """The pressure of a case on a coarse grid."""
    task = case.with_values({"numerics.grid": GRID}).task
    if isinstance(task, WheelsetProblem):
        shown = section_figure(solve_wheelset(task), task.title)
    else:
        shown = figure(solve(replace(task, subsurface=None)), "pressure")
    assert shown is not None, "there is a load"
    file = io.BytesIO()
    shown.savefig(file, format="png", dpi=100)
    return file.getvalue()
