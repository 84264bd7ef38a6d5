"""What documents claim: their size, their commands, the files they name, and the site made of them."""

from __future__ import annotations

import importlib
import importlib.util
import itertools
import json
import os
import re
import statistics
import subprocess
import sys
from pathlib import Path

import pytest

from scripts import closed_forms
from scripts.benchmark.contact import ratios
from scripts.figures.figures_documents import claims, declared, markdown
from tests.support.browser import opened
from tests.support.command_line import PATIENCE
from thermoroll_cli.files.case import Case
from thermoroll_cli.plots.pictures import KINDS

ROOT = Path(__file__).parents[2]
PAGES = sorted((ROOT / "docs").glob("*.md"))
FOLDERS = sorted(path.parent.relative_to(ROOT / "thermoroll_cli").as_posix()
                 for path in (ROOT / "thermoroll_cli").rglob("*/__init__.py"))
PACKAGES = [Path(folder).name for folder in FOLDERS if len(list((ROOT / "thermoroll_cli" / folder).glob("*.py"))) > 1]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_modules_and_cases_that_are_named_exist(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    modules = re.findall(rf"`(?:thermoroll_cli/)?((?:{'|'.join(FOLDERS)})/[\w/]+\.py)`", text)
    missing = [name for name in modules if not (ROOT / "thermoroll_cli" / name).exists()]
    cases = re.findall(r"\bcases/([\w*]+\.(?:toml|h5))", text)
    missing += [name for name in cases if not list((ROOT / "cases").glob(name))]
    scripts = re.findall(r"python -m (scripts[\w.]+)", text)
    missing += [name for name in scripts if importlib.util.find_spec(name) is None]
    assert not missing


def test_tests_that_notice_faults_are_still_there() -> None:
    """Whoever renames or removes one of them finds another that notices its fault, by `python -m scripts.faults`."""
    page = (ROOT / "docs" / "faults.md").read_text(encoding="utf-8")
    named = re.findall(r"([\w/]+\.py) · (test_\w+)", page)
    assert len(named) > 60
    for file, test in named:
        assert f"def {test}(" in (ROOT / "tests" / file).read_text(encoding="utf-8"), f"{file} · {test}"


def test_the_flow_diagram_shows_every_package() -> None:
    page = (ROOT / "docs" / "developing.md").read_text(encoding="utf-8")
    (diagram,) = re.findall(r"^## The flow of one contact\n(.*?)^A state", page, re.DOTALL | re.MULTILINE)
    table = page.partition("## The flow of one contact")[0]
    assert [package for package in PACKAGES if not re.search(rf"\b{package}\b", diagram)] == []
    assert [package for package in PACKAGES if f"`{package}`" not in table and package != "result"] == []


def test_lists_begin_after_an_empty_line() -> None:
    """GitHub is content without one, MkDocs is not."""
    for page in (*PAGES, ROOT / "README.md"):
        text = re.sub(r"```.*?```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
        lines = text.splitlines()
        for before, line in itertools.pairwise(lines):
            assert not (line.startswith("- ") and before and before[0] not in "- "), f"{page.name}: {line}"


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of the site, built without a warning, with the picture of a coarse contact."""
    pytest.importorskip("mkdocs")
    pytest.importorskip("latex2mathml")
    folder = tmp_path_factory.mktemp("documents") / "site"
    environment = {**os.environ, "NO_MKDOCS_2_WARNING": "1", "OPENBLAS_NUM_THREADS": "1", "GALLERY_GRID": "8",
                   "GALLERY_CASES": "wheel_rail_s*.toml"}
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", str(folder)]
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, timeout=PATIENCE)
    assert done.returncode == 0 and "WARNING" not in done.stderr, done.stderr
    return folder


@pytest.mark.slow
def test_the_site_has_all_cases_and_names(site: Path) -> None:
    gallery = (site / "gallery.html").read_text(encoding="utf-8")
    assert "cases/wheel_rail_sliding.toml" in gallery
    assert (site / "gallery" / "wheel_rail_sliding.png").stat().st_size > 5_000
    reference = (site / "reference.html").read_text(encoding="utf-8")
    assert "frictional heat" in (site / "index.html").read_text(encoding="utf-8")
    for name in ("Case", "Result", "Solver", "solve", "sweep", "read_result", "CreepForceTable"):
        assert re.search(rf'<h2 id="thermoroll_cli[\w.]*\.{name}"', reference), name
        assert f'doc-object-name doc-class-name">{name}<' in reference or f'doc-function-name">{name}<' in reference, name


@pytest.mark.slow
def test_the_gallery_has_every_case() -> None:
    pytest.importorskip("mkdocs")
    pages = importlib.import_module("scripts.site_pages")
    cases = sorted((ROOT / "cases").glob("*.toml"))
    sections = pages.gallery(cases, 16).split("\n## ")[1:]
    assert sorted(pages.KINDS) == [case.stem for case in cases]
    for case in cases:
        picture, kind = pages.KINDS[case.stem], Case.read(case).settings.kind
        assert picture in (kind.answer.pictures or KINDS) or (picture == "history" and kind.journal)
    for stem, section in zip(pages.KINDS, sections, strict=True):
        assert f'id="{stem}"' in section and "\nthermoroll " in section and section.endswith(f"(gallery/{stem}.png)\n")


@pytest.mark.slow
def test_the_site_needs_no_server(site: Path, tmp_path: Path) -> None:
    """Opened from disk: search answers, equations are typeset without scripts, nothing is asked of a server."""
    pages = {path.name: path.read_text(encoding="utf-8") for path in site.glob("*.html")}
    for name, text in pages.items():
        assert not re.findall(r'(?:src|<link[^>]* href)="(?:https?:)?//[^"]*', text), name
        assert "arithmatex" not in text, name
    assert "404.html" not in pages, "its links break below a folder"
    assert "<i>γ</i><sub>st</sub>" in pages["frames.html"] and "<code>gamma_st</code>" in pages["frames.html"]
    source = (ROOT / "docs" / "physics.md").read_text(encoding="utf-8")
    assert pages["physics.html"].count('class="equation"') == source.count("$$") // 2 > 20
    assert "\\" not in "".join(re.findall(r"<math.*?</math>", pages["physics.html"], re.DOTALL))
    found = opened(f"{(site / 'index.html').as_uri()}?q=spin", tmp_path, "--dump-dom")
    assert not found.console and not found.requests
    results = re.search(r"(\d+) matching documents", found.dom)
    assert results is not None and int(results[1]) > 5
    assert "physics.html" in found.dom.partition("matching documents")[2]


@pytest.mark.slow
def test_closed_forms_are_met() -> None:
    """`python -m scripts.closed_forms` on a coarse grid, and its table in the documents."""
    page = (ROOT / "docs" / "verification.md").read_text(encoding="utf-8")
    for check in closed_forms.checks(20):
        assert f"| {check.name} | {check.quantity} |" in page
        assert check.computed == pytest.approx(check.exact, rel=0.04), check


def test_claims_of_the_readme() -> None:
    """`python -m scripts.figures.figures_documents` writes the table beside CONTACT; the sentence below it quotes the fits."""
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    assert f"<!-- table measured claims -->\n{markdown(claims())}<!-- end -->" in readme
    numbers = json.loads((ROOT / "docs" / "figures" / "numbers.json").read_text(encoding="utf-8"))
    rows = {"measured_roller_rig": 1, "measured_twin_disc": 1, "eurosprinter": 2}
    found = [100.0 * float(numbers[name]["table"]["rows"][row][3]) for name, row in rows.items()]
    least, most = re.search(r"within (\S+) to (\S+) % of the load", readme).groups()  # type: ignore[union-attr]
    assert (f"{min(found):.1f}", f"{max(found):.1f}") == (least, most)


def test_claims_of_the_paper() -> None:
    """Its ratio of processor times and its difference of creep forces are those behind the table of the README."""
    paper = " ".join((ROOT / "paper" / "paper.md").read_text(encoding="utf-8").split())
    bench = json.loads((ROOT / "scripts" / "benchmark" / "results.json").read_text(encoding="utf-8"))
    faster = [row["solve"] for row in ratios(bench["contact"]["measured"])["128"]]
    median, least, most = (f"1/{value:.0f}" for value in (statistics.median(faster), min(faster), max(faster)))
    assert f"{median} of the processor time (median; {least} to {most})" in paper
    (agreement,) = re.findall(r"\| creep forces, seven isothermal cases \| within (\S+) ", markdown(claims()))
    assert f"within {agreement} of the limit of friction" in paper


def test_tables_of_what_is_declared_are_those_of_the_package() -> None:
    """`python -m scripts.figures.figures_documents` writes them."""
    pages = "".join(page.read_text(encoding="utf-8") for page in PAGES)
    for name, found in declared().items():
        assert f"<!-- table declared {name} -->\n{markdown(found)}<!-- end -->" in pages, name
