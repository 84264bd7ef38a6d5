"""The layers import in one direction only, and the command line stays light."""

from __future__ import annotations

import ast
import gc
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

import thermoroll_cli
from thermoroll_cli.files.case_model import Settings
from thermoroll_cli.files.case_schema import entry_at, known_keys
from thermoroll_cli.many_contacts.wheelset.wheelset_problem import SIDES
from thermoroll_cli.problem.kinds import MODULES as MODULES_OF_KINDS
from thermoroll_cli.problem.kinds import At, every_kind, found_at
from thermoroll_cli.problem.problem import BODIES

PACKAGE = Path(thermoroll_cli.__file__).parent
ROOT = PACKAGE.parent

PACKAGES = (
    {"tools"}, {"problem", "physics.numerics"}, {"exact"}, {"physics.halfspace"},
    {"physics.contact", "physics.rolling", "physics.heat", "physics.stress"},
    {"one_contact.steady_state"}, {"one_contact.refinement"},
    {"many_contacts.wheelset", "many_contacts.bearing"}, {"many_contacts.history"},
    {"files", "plots"}, {"kinds"}, {"python_api", "peer"},
    {"studies.sweeps"}, {"studies.creep_table", "studies.worn"}, {"cli"}, {"", "__main__"},
)  # fmt: skip
"""Packages of thermoroll_cli from the bottom up. One imports only from itself and from those below it: packages of one row do
not know each other. Modules at the root count as packages of their own; "" is thermoroll_cli itself."""

RANK = {package: rank for rank, row in enumerate(PACKAGES) for package in row}

FOREIGN: dict[str, set[str]] = {
    "pydantic": {"files"}, "pydantic_core": {"files"}, "tomllib": {"files"}, "tomli_w": {"files"}, "filelock": {"tools"},
    "h5py": {"files", "studies.sweeps", "studies.creep_table", "studies.worn"}, "typer": {"cli"}, "jinja2": {"cli"},
    "matplotlib": {"plots"}, "pyfftw": {"physics.numerics", "files"}, "distributed": {"tools"},
    "SurfaceTopography": {"files"},
}  # fmt: skip
"""Libraries that belong to certain layers: solvers know nothing of TOML, HDF5 or terminals, the command line nothing
of FFTs."""

LIGHT = {"numpy", "scipy", "h5py", "pyfftw", "matplotlib", "pydantic", "pydantic_core", "rich", "tomli_w", "distributed"}


@cache
def parsed(path: Path) -> ast.Module:
    tree = ast.parse(path.read_text())
    gc.freeze()  # half of the time is that of looking for garbage among all trees before
    return tree


@cache
def imports(path: Path, *, top_level: bool = False) -> tuple[str, ...]:
    """Names of all modules that a file imports; only those imported when the file itself is, if `top_level`."""
    found: list[str] = []
    for node in _statements(parsed(path).body, executed=top_level):
        if isinstance(node, ast.Import):
            found += (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, "imports within the package are absolute"
            # `from thermoroll_cli import files` imports thermoroll_cli.files
            found += (f"{node.module}.{alias.name}" for alias in node.names)
    return tuple(found)


def _statements(body: list[ast.stmt], *, executed: bool) -> Iterator[ast.AST]:
    """All statements, or those that are `executed` when the file is imported."""
    for node in body:
        typing_only = executed and isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test)
        if typing_only or (executed and isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)):
            continue
        yield node
        for part in ("body", "orelse", "finalbody", "handlers", "cases"):
            yield from _statements(getattr(node, part, []), executed=executed)


MODULES = sorted(PACKAGE.rglob("*.py"))


def package_of(path: Path) -> str:
    """The package of a module, or its own name if it stands at the root."""
    parts = path.relative_to(PACKAGE).with_suffix("").parts
    return "" if parts[0] == "__init__" else parts[0] if parts[0] in RANK else ".".join(parts[:2])


def name(path: Path) -> str:
    return path.relative_to(PACKAGE).as_posix()


def test_imports_point_in_one_direction() -> None:
    for path in MODULES:
        own = package_of(path)
        assert own in RANK or path.name == "__init__.py", f"{own} is no package: give it a place in PACKAGES"
        for imported in imports(path):
            parts = imported.split(".")
            known = {parts[1], ".".join(parts[1:3])} & RANK.keys() - {own} if parts[0] == "thermoroll_cli" else set()
            if known:
                assert RANK[known.pop()] < RANK[own], f"{name(path)} must not import {imported}"
            elif parts[0] in FOREIGN:
                assert own in FOREIGN[parts[0]], f"{name(path)}: {parts[0]} does not belong in {own}"


INSIDE_FUNCTIONS = {"cli", "kinds", "python_api", "", "__main__"}
OPTIONAL = {"pandas", "xarray", "distributed", "pyfftw", "SurfaceTopography"}


def test_imports_stand_at_the_top() -> None:
    """Only commands, kinds of problems, the package itself and optional packages are imported when they are needed."""
    for path in MODULES:
        late = set(imports(path)) - set(imports(path, top_level=True))
        unexpected = {module for module in late if module.split(".")[0] not in OPTIONAL}
        assert package_of(path) in INSIDE_FUNCTIONS or not unexpected, f"{name(path)}: {unexpected}"


def test_kinds_name_what_exists_below_them() -> None:
    """Places that they import when asked, which `imports` does not see."""
    assert {*MODULES_OF_KINDS} == {path.stem for path in (PACKAGE / "kinds").glob("[a-z]*.py")}
    for kind in every_kind():
        given = [value.place for part in type(kind).__mro__ for value in vars(part).values() if isinstance(value, At)]
        for place in (*given, *kind.answer.figures.values()):
            assert callable(found_at(place)), place
            known = {place.split(".")[0], ".".join(place.split(".")[:2])} & RANK.keys()
            assert RANK[known.pop()] < RANK["kinds"], place


def test_the_command_line_starts_light() -> None:
    for path in MODULES:
        heavy = {imported for imported in imports(path, top_level=True) if imported.split(".")[0] in LIGHT}
        listing = name(path) in ("__init__.py", "__main__.py", "cli/main.py", "cli/commands.py", "cli/streams.py")
        assert not listing or not heavy, f"{name(path)}: import {heavy} with the command"


@pytest.mark.parametrize(("folder", "forbidden"), [
    ("tests", "tests"), ("scripts", "tests"), ("thermoroll_cli", "tests"), ("thermoroll_cli", "scripts")])  # fmt: skip
def test_what_is_shared_has_a_place_of_its_own(folder: str, forbidden: str) -> None:
    """Tests and scripts share through tests/support; the package uses neither."""
    for path in sorted((ROOT / folder).rglob("*.py")):
        for part in re.findall(rf"(?m)^ *(?:from|import) {forbidden}\b(?:\.| import )?(\w*)", path.read_text()):
            assert part == "support" and folder != "thermoroll_cli", f"{path}: {forbidden}.{part}"


def test_package_folders_do_nothing_on_import() -> None:
    for init in PACKAGE.rglob("*/__init__.py"):
        tree = ast.parse(init.read_text())
        assert all(isinstance(node, ast.Expr) for node in tree.body), f"{name(init)} does more than describe"


# --- what the repository speaks of is in the repository --------------------------------------------------------------


def texts() -> Iterator[tuple[str, str]]:
    """Every file of the project that people read, without this one."""
    for folder, kinds in (("thermoroll_cli", ".py"), ("tests", ".py .md"), ("scripts", ".py"),
                          ("docs", ".md"), ("cases", ".toml"), (".", ".md .toml")):
        paths = (ROOT / folder).iterdir() if folder == "." else (ROOT / folder).rglob("*")
        for path in paths:
            if path.suffix in kinds.split() and path != Path(__file__).resolve():
                yield path.relative_to(ROOT).as_posix(), path.read_text()


def test_documents_that_are_named_exist() -> None:
    """Also without their folder: `numerics.md` alone is docs/numerics.md."""
    there = {path.name for path in (*ROOT.glob("*.md"), *ROOT.glob("[dp]*/*.md"), *ROOT.glob("tests/**/*.md"))}
    there |= {"index.md", "gallery.md", "reference.md"}  # made with the site
    named = ((where, found) for where, text in texts() for found in re.findall(r"\b([\w-]+\.md)\b", text))
    assert not [(where, found) for where, found in named if found not in there]


def test_tests_that_are_named_exist() -> None:
    """Files with their folder or without; functions in the file that they are said to be in, or in the last one named."""
    there = {path.relative_to(ROOT).as_posix(): path.read_text() for path in ROOT.glob("tests/**/test_*.py")}
    missing = []
    for where, text in texts():
        if not where.endswith(".md"):
            continue
        content = ""
        for name, function in re.findall(r"`((?:tests/[\w/]*)?test_\w+\.py)?(?:::)?(test_\w+)?`", text):
            if name:
                content = next((found for path, found in there.items() if Path(path).name == Path(name).name), "")
            if (name and not content) or (function and f"def {function}(" not in content):
                missing.append((where, name, function))
    assert not missing


def test_experiments_pass_options_and_patch_nothing() -> None:
    """What an experiment changes is in `SolverOptions`; names of the package are left alone."""
    for path in (ROOT / "scripts").rglob("*.py"):
        assert "setattr(" not in path.read_text() and "monkeypatch" not in path.read_text(), path


DOTTED = re.compile(rf"(?<![\w./\[])(?:{'|'.join((*Settings.model_fields, *BODIES, *SIDES))})(?:\.[\w…]+)+")


def messages() -> Iterator[str]:
    """Texts of the package that are no docstrings; values put into them are `…`."""
    for path in MODULES:
        if path.parent.name == "result":
            continue  # names in files of results
        tree = parsed(path)
        nodes = list(ast.walk(tree))
        own = {id(node.value) for node in nodes if isinstance(node, ast.Expr)}
        inner = {id(part) for node in nodes if isinstance(node, ast.JoinedStr) for part in node.values}
        for node in nodes:
            if isinstance(node, ast.JoinedStr):
                yield "".join(str(part.value) if isinstance(part, ast.Constant) else "…" for part in node.values)
            elif isinstance(node, ast.Constant) and isinstance(node.value, str) and not {id(node)} & (own | inner):
                yield node.value


@pytest.mark.slow
def test_keys_that_messages_name_exist() -> None:
    def keys(path: tuple[str | int, ...]) -> Iterator[str]:
        yield ".".join(map(str, path))
        inner = (0,) if "items" in entry_at(path) else ()
        for key in (*known_keys(path), *inner):
            yield from keys((*path, key))

    known = {name for table in Settings.model_fields for name in keys((table,))}
    named = {key.rstrip(".") for text in messages() for key in DOTTED.findall(text)}
    assert len(named) > 40
    for key in named:
        pattern = re.compile(r"(^|\.)" + re.escape(key).replace("…", r"[\w.]+"))
        assert any(pattern.search(name) for name in known), f"{key} is no key"
