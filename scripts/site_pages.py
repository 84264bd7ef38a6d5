"""Pages of the site that are made when it is built (a hook of MkDocs, see mkdocs.yml): the README as its first page, a
gallery of cases/ with their pictures, and the reference of the Python interface."""

from __future__ import annotations

import io
import pathlib
import re
import tempfile
from collections.abc import Iterable
from dataclasses import replace
from typing import Any

from mkdocs.structure.files import File, Files

import thermoroll_cli
from thermoroll_cli import Case, solve
from thermoroll_cli.plots import style
from thermoroll_cli.plots.pictures import figure
from thermoroll_cli.problem.problem import Problem
from thermoroll_cli.studies.sweeps.table_picture import draw_table

ROOT = pathlib.Path(__file__).parents[1]
SENTENCES = 3
JOBS = {
    "Wheels and rails": {
        "wheel_rail": "traction", "wheel_rail_sliding": "track", "worn_rail": "profile", "two_point": "profile",
        "eurosprinter": "traction", "manchester": "section", "measured_wheelset": "section", "wheelset_wear": "section",
        "vt_fra_roller_rig": "traction", "corrugation": "history", "crossing": "gap", "wheel_flat": "gap"},
    "Bearings and coatings": {
        "angular_contact": "loads", "ball_bearing": "summary", "ball_in_groove": "traction", "crowned_roller": "profile",
        "coated_ball": "subsurface_upper", "coated_ball_heat": "summary"},
    "Gears, discs and drives": {
        "gear_pair": "traction", "rolling_start": "history", "dent": "surface", "twin_disc": "track",
        "twin_disc_lewis": "traction", "twin_disc_wear": "traction", "hot_sliding": "subsurface_upper"},
    "Polymer rollers": {"polymer_roller": "pressure", "polymer_tyre": "pressure"},
    "The article": {
        **{f"article_3_1_case_{number}": "traction" for number in range(1, 6)}, "article_4_1": "pressure",
        "article_4_2_linear": "traction", "article_4_2_spin_low": "traction", "article_4_2_spin_high": "traction",
        "article_4_2_spin_combined": "traction", "article_4_3_conformal": "pressure", "article_4_3_flat": "pressure",
        "article_4_3_non_conformal": "pressure", "table1": "traction"},
}  # fmt: skip
"""The cases of each job, with the picture that shows what each is about."""
KINDS = {stem: kind for cases in JOBS.values() for stem, kind in cases.items()}


def on_files(files: Files, config: Any) -> Files:
    """Add the pages and pictures to those of docs/."""
    grid, cases = config["extra"]["gallery_grid"], sorted((ROOT / "cases").glob(config["extra"]["gallery_cases"]))
    files.append(File.generated(config, "index.md", content=first_page()))
    files.append(File.generated(config, "reference.md", content=reference()))
    files.append(File.generated(config, "gallery.md", content=gallery(cases, grid)))
    for path in cases:
        files.append(File.generated(config, f"gallery/{path.stem}.png", content=picture(path, grid)))
    return files


def on_post_template(output: str, template_name: str, config: Any) -> str:
    """Without the site's own address there is no page for addresses that are not there: a server shows it at any depth, and its
    links would hold at the top alone."""
    return "" if template_name == "404.html" and not config["site_url"] else output


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
    """Thumbnails by job, and picture, title, the first sentences of the comment and the commands of each case."""
    found = {path.stem: path for path in cases}
    thumbnails, sections = [], []
    for job, stems in JOBS.items():
        shown = [stem for stem in stems if stem in found]
        thumbnails += [f"**{job}**\n\n<div class=\"thumbnails\">"] if shown else []
        for stem in shown:
            case = Case.read(found[stem])
            title = case.settings.title
            words, commands = summary(case.text)
            commands = commands or [f"thermoroll run cases/{stem}.toml -o results"]
            thumbnails.append(f'<a href="#{stem}"><img src="gallery/{stem}.png" alt="">{title}</a>')
            sections.append(
                f'## <span id="{stem}"></span>{title}\n\n`cases/{stem}.toml`\n\n{words}\n\n'
                "```sh\n" + "\n".join(commands) + f"\n```\n\n![{KINDS[stem]} of {stem}](gallery/{stem}.png)\n")  # fmt: skip
        thumbnails += ["</div>\n"] if shown else []
    opening = (f"# Gallery\n\nThe cases in `cases/`, each with the picture of its subject on {grid} × {grid} elements. "
               "Maps are seen from below ([frames](frames.md)).\n\n")
    return opening + "\n".join(thumbnails) + "\n" + "\n".join(sections)


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
    """The picture of what a case is about, on a `grid` per side."""
    kind = KINDS[path.stem]
    task = Case.read(path).with_values({"numerics.grid": grid}).task
    if isinstance(task, Problem) and not kind.startswith("subsurface"):
        task = replace(task, subsurface=None)
    result, file = solve(task), io.BytesIO()
    if kind == "history":
        assert result.history is not None, f"{path.stem} is over time"
        with tempfile.TemporaryDirectory() as folder:
            drawn = pathlib.Path(folder) / "history.png"
            assert draw_table(result.history, drawn, dpi=100) == ""
            return drawn.read_bytes()
    with style.applied():
        shown = figure(result, kind)
        assert shown is not None, f"{path.stem} has a picture {kind}"
        shown.savefig(file, format="png", dpi=100)
    return file.getvalue()
