"""What a newcomer meets first: cases, README, Makefile, CI; what a package index and a source distribution get."""

from __future__ import annotations

import importlib.metadata
import os
import re
import shutil
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from pathlib import Path

import pytest

import thermoroll_cli
from tests.support.command_line import THERMAL
from thermoroll_cli.files.case import Case

ROOT = Path(thermoroll_cli.__file__).parent.parent
CASES = sorted((ROOT / "cases").glob("*.toml"))
README = (ROOT / "README.md").read_text()


@pytest.mark.parametrize("path", CASES, ids=lambda path: path.stem)
def test_cases_are_valid_and_say_what_to_expect(path: Path) -> None:
    case = Case.read(path)
    assert case.settings.title
    comment = "".join(line for line in case.text.splitlines() if line.startswith("#"))
    assert "Expect" in comment


def test_table_1_is_as_printed_with_steel_s_diffusivity() -> None:
    settings = Case.read(ROOT / "cases" / "table1.toml").settings
    assert settings.model_dump(exclude_none=True)["material"] == tomllib.loads(THERMAL)["material"]
    assert set(settings.geometry.model_dump(exclude_unset=True).values()) == {30.0}
    assert (settings.load.normal_N, settings.load.friction_coefficient, settings.rolling.speed_m_s) == (65.0, 0.3, 1.0)


def test_the_readme_says_how_to_run_and_exit_codes_are_listed() -> None:
    assert "make run" in README and "make test" in README
    page = (ROOT / "docs" / "commands.md").read_text(encoding="utf-8")
    for code in ("0", "1", "2", "3", "4", "5", "6"):
        assert f"\n| {code} | " in page


def test_ci_runs_make_check_and_make_test() -> None:
    script = ROOT / ".ci" / "run"
    assert os.access(script, os.X_OK)
    lines = [line for line in script.read_text().splitlines() if line and not line.startswith("#")]
    assert lines[-2:] == ["make check", 'PYTEST_ADDOPTS="-W error" make test']


def test_hooks_and_editors_agree_with_make_check() -> None:
    makefile = (ROOT / "Makefile").read_text()
    values = dict(re.findall(r"^(\w+) := (.*)$", makefile, re.MULTILINE))
    (recipe,) = re.findall(r"^check: .*\n((?:\t.*\n)+)", makefile, re.MULTILINE)
    for name in ("PACKAGES", "BIN", "VENV"):
        recipe = recipe.replace(f"$({name})", values[name])
    hooks = re.findall(r"entry: (.*)", (ROOT / ".pre-commit-config.yaml").read_text())
    assert hooks == [line.strip() for line in recipe.splitlines()][:2]
    length = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["ruff"]["line-length"]
    assert f"max_line_length = {length}\n" in (ROOT / ".editorconfig").read_text()


def test_make_explains_a_missing_python(tmp_path: Path) -> None:
    (tmp_path / "Makefile").write_text((ROOT / "Makefile").read_text())
    (tmp_path / "pyproject.toml").write_text("")
    done = subprocess.run(["make", "run", "PYTHON="], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode != 0
    assert "Python 3.11 or newer" in done.stderr
    assert not (tmp_path / ".venv").exists()


def test_version_and_licence() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert project["license"] == "BSD-3-Clause AND Apache-2.0"
    texts = [(ROOT / name).read_text(encoding="utf-8") for name in project["license-files"]]
    assert any("BSD 3-Clause" in text for text in texts) and any("Apache License" in text for text in texts)
    for profile in ("MBench_S1002_v3.prw", "MBench_UIC60_v3.prr"):
        assert (ROOT / "cases" / profile).exists() and profile in (ROOT / "NOTICE.md").read_text()
    assert "BSD 3-Clause" in (ROOT / "LICENSE").read_text()
    assert "GPL" in README and "FFTW" in (ROOT / "NOTICE.md").read_text()
    assert f"## {thermoroll_cli.__version__}" in (ROOT / "CHANGELOG.md").read_text()
    assert all(">=" in requirement for requirement in project["dependencies"])


def test_the_conda_recipe_needs_what_the_package_needs() -> None:
    recipe = (ROOT / "packaging" / "meta.yaml").read_text(encoding="utf-8")
    assert f'set version = "{thermoroll_cli.__version__}"' in recipe and f"license: {PROJECT['license']}\n" in recipe
    run = re.findall(r"(?m)^    - ([\w-]+) (>=[\d.]+)$", recipe)
    needed = {tuple(re.fullmatch(r"([\w-]+)(>=[\d.]+)", text).groups()) for text in PROJECT["dependencies"]}  # type: ignore[union-attr]
    assert {(name.removesuffix("-base"), version) for name, version in run} == needed | {("python", PROJECT["requires-python"])}


PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


def test_an_index_can_follow_the_links_of_the_readme(tmp_path: Path) -> None:
    """It shows no relative pictures and follows no relative links: the workflow of a release makes them absolute."""
    assert PROJECT["readme"] == "README.md"
    workflow = (ROOT / ".github" / "workflows" / "release.yml").read_text(encoding="utf-8")
    (step,) = re.findall(r"run: \|\n((?: {10}.*\n)+)", workflow)
    shutil.copy(ROOT / "README.md", tmp_path)
    places = {"GITHUB_SERVER_URL": "https://github.com", "GITHUB_REPOSITORY": "somebody/thermoroll", "GITHUB_REF_NAME": "v1"}
    subprocess.run(["bash", "-ec", step], cwd=tmp_path, env={**os.environ, **places}, check=True)
    page = (tmp_path / "README.md").read_text(encoding="utf-8")
    assert re.findall(r"\]\((?!https://)|<img", page) == []
    assert re.search(r"!\[[^]]+\]\(https://github.com/somebody/thermoroll/raw/v1/docs/figures/", page)
    assert "](https://github.com/somebody/thermoroll/blob/v1/docs/tutorial.md)" in page


def test_metadata_is_complete() -> None:
    assert {"authors", "maintainers", "keywords", "classifiers", "license", "requires-python"} <= set(PROJECT)
    assert "Typing :: Typed" in PROJECT["classifiers"] and (ROOT / "thermoroll_cli" / "py.typed").exists()
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert f"version: {thermoroll_cli.__version__}\n" in citation and "license: BSD-3-Clause\n" in citation


@pytest.mark.slow
def test_the_source_distribution_has_everything(tmp_path: Path) -> None:
    """All that is under version control: documents, cases, tests with their data, scripts; and a wheel the cases of the
    documents. Built without a network."""
    if not (ROOT / ".git").exists() or shutil.which("git") is None:
        pytest.skip("no version control here that tells what belongs to it")
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True)
    if listed.returncode != 0:
        pytest.skip(f"git: {listed.stderr}")  # the folder belongs to somebody else
    if int(importlib.metadata.version("setuptools").partition(".")[0]) < 77:
        pytest.skip("needs setuptools 77 (make test installs it)")
    tracked = {name for name in listed.stdout.split("\0") if name and (ROOT / name).is_file()}
    source = tmp_path / "source tree"
    for name in tracked:
        (source / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, source / name)
    for kind in ("sdist", "wheel"):
        program = f"import sys; from setuptools import build_meta; build_meta.build_{kind}(sys.argv[1])"
        subprocess.run([sys.executable, "-c", program, str(tmp_path)], cwd=source, check=True, capture_output=True)
    (archive,) = tmp_path.glob("*.tar.gz")
    with tarfile.open(archive) as packed:
        names = {name.partition("/")[2] for name in packed.getnames()}
    assert tracked - names == set()
    assert {"docs/tutorial.md", "cases/wheel_rail.toml", "tests/reference/README.md", "thermoroll_cli/py.typed"} <= names
    (wheel,) = tmp_path.glob("*.whl")
    with zipfile.ZipFile(wheel) as packed:
        packages = {name for name in tracked if name.startswith("thermoroll_cli/")}
        cases = {f"thermoroll_cli/{name}" for name in tracked if name.startswith("cases/")}
        assert packages | cases == {name for name in packed.namelist() if name.startswith("thermoroll_cli/")}
