"""What a package index and a source distribution get."""

from __future__ import annotations

import importlib.metadata
import re
import shutil
import subprocess
import sys
import tarfile
import tomllib
from pathlib import Path

import pytest

import thermoroll_cli

ROOT = Path(thermoroll_cli.__file__).parent.parent
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


def test_the_index_page_needs_nothing_beside_it() -> None:
    """An index shows no relative pictures and follows no relative links."""
    page = (ROOT / PROJECT["readme"]).read_text(encoding="utf-8")
    assert re.findall(r"\]\((?!https?:)|<img", page) == []
    opening = page.split("\n\n")[1]
    assert opening in (ROOT / "README.md").read_text(encoding="utf-8"), "the same first words as the README"


def test_metadata_is_complete() -> None:
    assert {"authors", "maintainers", "keywords", "classifiers", "license", "requires-python"} <= set(PROJECT)
    assert "Typing :: Typed" in PROJECT["classifiers"] and (ROOT / "thermoroll_cli" / "py.typed").exists()
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert f"version: {thermoroll_cli.__version__}\n" in citation and f"license: {PROJECT['license']}\n" in citation


def test_the_source_distribution_has_everything(tmp_path: Path) -> None:
    """All that is under version control: documents, cases, tests with their data, scripts. Built without a network."""
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
    program = "import sys; from setuptools import build_meta; build_meta.build_sdist(sys.argv[1])"
    subprocess.run([sys.executable, "-c", program, str(tmp_path)], cwd=source, check=True, capture_output=True)
    (archive,) = tmp_path.glob("*.tar.gz")
    with tarfile.open(archive) as packed:
        names = {name.partition("/")[2] for name in packed.getnames()}
    assert tracked - names == set()
    assert {"docs/python.md", "cases/wheel_rail.toml", "tests/reference/README.md", "thermoroll_cli/py.typed"} <= names
