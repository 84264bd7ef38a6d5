"""The layers import in one direction only, and the command line stays light."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

import thermoroll_cli

PACKAGE = Path(thermoroll_cli.__file__).parent
ROOT = PACKAGE.parent

LAYERS: dict[str, set[str]] = {
    "kernels": set(),
    "exact": set(),
    "solvers": {"kernels", "exact"},
    "model": {"kernels", "exact", "solvers"},
    "steady_state": {"kernels", "exact", "solvers", "model"},
    "assessment": {"kernels", "exact", "solvers", "model", "steady_state"},
    "subsurface": {"kernels", "exact", "solvers", "model", "steady_state", "assessment"},
    "refinement": {"kernels", "exact", "solvers", "model", "steady_state", "assessment", "subsurface"},
    "files": {"model", "refinement", "assessment"},
    "plots": {"model", "refinement", "assessment"},
    "sweep": {"model", "refinement", "assessment", "files", "plots"},
    "cli": {"model", "refinement", "assessment", "files", "plots", "sweep"},
}
"""What each layer may import besides itself:

    kernels, exact ← solvers ← model ← steady_state ← assessment ← subsurface ← refinement ← files, plots ← sweep ← cli
"""

FOREIGN: dict[str, set[str]] = {
    "pydantic": {"files"},
    "pydantic_core": {"files"},
    "tomllib": {"files"},
    "tomli_w": {"files"},
    "h5py": {"files"},
    "typer": {"cli"},
    "matplotlib": {"plots"},
    "pyfftw": {"kernels", "solvers"},
    "distributed": {"sweep"},
}
"""Libraries that belong to certain layers: solvers know nothing of TOML, HDF5 or terminals, the command line nothing
of FFTs."""

LIGHT = {"numpy", "scipy", "h5py", "pyfftw", "matplotlib", "pydantic", "pydantic_core", "rich", "tomli_w", "distributed"}


def imports(tree: ast.Module, *, top_level: bool = False) -> Iterator[str]:
    """Names of all imported modules; only those imported when the module itself is, if `top_level`."""
    for node in _executed(tree.body) if top_level else ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, "imports within the package are absolute"
            # `from thermoroll_cli import files` imports thermoroll_cli.files
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def _executed(body: list[ast.stmt]) -> Iterator[ast.AST]:
    for node in body:
        typing_only = isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test)
        if typing_only or isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            continue
        yield node
        for part in ("body", "orelse", "finalbody", "handlers"):
            yield from _executed(getattr(node, part, []))


def modules() -> list[Path]:
    return sorted(path for path in PACKAGE.rglob("*.py"))


def layer(path: Path) -> str:
    parts = path.relative_to(PACKAGE).parts
    return parts[0] if len(parts) > 1 else ""


def name(path: Path) -> str:
    return path.relative_to(PACKAGE).as_posix()


@pytest.mark.parametrize("path", [path for path in modules() if layer(path)], ids=name)
def test_imports_point_in_one_direction(path: Path) -> None:
    own = layer(path)
    assert own in LAYERS, f"{own} is no layer: give it a place in LAYERS"
    for imported in imports(ast.parse(path.read_text())):
        parts = imported.split(".")
        if parts[0] == "thermoroll_cli" and len(parts) > 1 and (PACKAGE / parts[1]).is_dir():
            assert parts[1] in LAYERS[own] | {own}, f"{own} must not import {imported}"
        elif parts[0] in FOREIGN:
            assert own in FOREIGN[parts[0]], f"{parts[0]} does not belong in {own}"


@pytest.mark.parametrize(
    "path", [path for path in modules() if layer(path) in ("", "cli") or path.name == "problem.py"], ids=name
)
def test_the_command_line_starts_light(path: Path) -> None:
    for imported in imports(ast.parse(path.read_text()), top_level=True):
        assert imported.split(".")[0] not in LIGHT, f"import {imported} where it is needed, inside the command"


@pytest.mark.parametrize(("folder", "forbidden"), [("tests", "tests"), ("scripts", "tests"), ("thermoroll_cli", "scripts")])
def test_what_is_shared_has_a_place_of_its_own(folder: str, forbidden: str) -> None:
    """Tests share through tests/support, or use what scripts use; scripts use no tests, and the package neither."""
    for path in sorted((ROOT / folder).rglob("*.py")):
        for imported in imports(ast.parse(path.read_text())):
            parts = imported.split(".")
            assert parts[0] != forbidden or (parts[1] == "support" and folder == "tests"), f"{path}: {imported}"


def test_package_folders_do_nothing_on_import() -> None:
    for init in PACKAGE.rglob("*/__init__.py"):
        if init.parent.name == "sweep":  # which is a function, too
            continue
        tree = ast.parse(init.read_text())
        assert all(isinstance(node, ast.Expr) for node in tree.body), f"{name(init)} does more than describe"


@pytest.mark.parametrize("path", [path for path in modules() if path.stat().st_size], ids=name)
def test_modules_are_documented_and_short(path: Path) -> None:
    text = path.read_text()
    assert ast.get_docstring(ast.parse(text)), "says what it is about"
    assert len(text.splitlines()) <= 400, "one idea per module, usually under 300 lines"
