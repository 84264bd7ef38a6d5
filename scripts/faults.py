"""Small faults in the package, one at a time, and which test notices each: `docs/faults.md`.

    python -m scripts.faults [--seed S] [--count N] [--only TEXT] [--package REVISION] [--suite REVISION] [--jobs J] [--table]

A fault turns +, *, a comparison or and/or into its opposite, drops a minus or a `not`, or multiplies a number by 1.2. The
same seed draws the same faults from the same package, so two suites (`tests/` of two revisions) can be compared. All faults are
planted at once in a copy of the package, and the environment variable FAULT chooses one. Each file of tests runs once without a
fault, which tells which places it reaches; a fault then meets the files that reach it, those of its own package first, until a
test fails. A test that fails without a fault is no witness.
"""

from __future__ import annotations

import argparse
import ast
import copy
import os
import random
import re
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[1]
PACKAGE = "thermoroll_cli"
OPPOSITE: dict[type, type] = {ast.Add: ast.Sub, ast.Mult: ast.Div, ast.Lt: ast.GtE, ast.Gt: ast.LtE, ast.And: ast.Or,
                              ast.Eq: ast.NotEq}  # fmt: skip
OPPOSITE |= {after: before for before, after in OPPOSITE.items()}
ENDLESS = 60.0, 6.0
"""A file of tests is stopped after so many processor seconds, and so many times those that it takes without a fault."""
NO_TESTS = 5
"""pytest's exit code if it has found none."""
SWITCH = '''\
"""Which fault is present, and which places have been reached."""
import os

WANTED, REACHED, seen = int(os.environ.get("FAULT", 0)), os.environ.get("FAULTS_REACHED"), set()


def present(number):
    if REACHED and number not in seen:
        seen.add(number)
        with open(REACHED, "a") as file:
            file.write(f"{number}\\n")
    return number == WANTED
'''


class Fault(NamedTuple):
    """A place of a file of the package, the `place`-th of those that can change, and what the fault makes of it."""

    number: int
    file: str
    place: int
    line: int
    change: str


@dataclass
class TestFile:
    """A file of tests as it runs without a fault: its seconds, the numbers of faults that it reaches, its tests that fail."""

    path: str
    seconds: float = 0.0
    reached: set[int] = field(default_factory=set)
    failing: list[str] = field(default_factory=list)


# --- faults ----------------------------------------------------------------------------------------------------------


def places(tree: ast.Module) -> Iterator[ast.expr]:
    """Expressions within functions that a fault can change; those that join texts are left out."""
    for function in ast.walk(tree):
        if isinstance(function, ast.FunctionDef | ast.AsyncFunctionDef):
            nodes = (node for part in function.body for node in ast.walk(part))
            yield from (node for node in nodes if isinstance(node, ast.expr) and _changeable(node))


def _changeable(node: ast.expr) -> bool:
    match node:
        case ast.BinOp():
            return type(node.op) in OPPOSITE and not any(map(_is_text, (node.left, node.right)))
        case ast.Compare(ops=[operator]):
            return type(operator) in OPPOSITE
        case ast.Constant(value=float(value)):
            return value != 0.0
        case ast.UnaryOp():
            return isinstance(node.op, ast.Not | ast.USub)
    return isinstance(node, ast.BoolOp)


def _is_text(node: ast.expr) -> bool:
    return isinstance(node, ast.JoinedStr) or (isinstance(node, ast.Constant) and isinstance(node.value, str))


def changed(node: ast.expr) -> ast.expr:
    """`node` with its fault."""
    node = copy.deepcopy(node)
    match node:
        case ast.BinOp() | ast.BoolOp():
            node.op = OPPOSITE[type(node.op)]()
        case ast.Compare():
            node.ops = [OPPOSITE[type(node.ops[0])]()]
        case ast.Constant(value=float(value)):
            node.value = 1.2 * value
        case ast.UnaryOp():
            return node.operand
    return node


def draw(root: Path, seed: int, count: int, only: str = "") -> list[Fault]:
    """`count` places among all of the package below `root` (whose paths contain `only`), each as likely as another."""
    files = sorted(file for file in (root / PACKAGE).rglob("*.py") if only in str(file.relative_to(root)))
    trees = {file: list(places(ast.parse(file.read_text(encoding="utf-8")))) for file in files}
    pool = [(file, index) for file, nodes in trees.items() for index in range(len(nodes))]
    drawn = random.Random(seed).sample(pool, min(count, len(pool)))
    faults = []
    for number, (file, index) in enumerate(drawn, 1):
        node = trees[file][index]
        change = f"{ast.unparse(node)} → {ast.unparse(changed(node))}"
        faults.append(Fault(number, file.relative_to(root).as_posix(), index, node.lineno, change))
    return faults


class _Planted(ast.NodeTransformer):
    """Each of `faulty` (number and changed expression per node) becomes `changed if present(number) else itself`."""

    def __init__(self, faulty: dict[ast.expr, tuple[int, ast.expr]]) -> None:
        self.faulty = faulty

    def visit(self, node: ast.AST) -> ast.AST:
        original = self.generic_visit(node)
        if not isinstance(node, ast.expr) or node not in self.faulty:
            return original
        number, fault = self.faulty[node]
        present = ast.parse(f"__import__('fault_switch').present({number})", mode="eval").body
        return ast.IfExp(present, fault, original)  # type: ignore[arg-type]


def plant(root: Path, faults: Sequence[Fault]) -> None:
    """Write the package below `root` with all faults, each of which is present if the variable FAULT is its number."""
    (root / "fault_switch.py").write_text(SWITCH, encoding="utf-8")
    for name in {fault.file for fault in faults}:
        tree = ast.parse((root / name).read_text(encoding="utf-8"))
        nodes = list(places(tree))
        faulty = {nodes[fault.place]: (fault.number, changed(nodes[fault.place])) for fault in faults if fault.file == name}
        (root / name).write_text(ast.unparse(ast.fix_missing_locations(_Planted(faulty).visit(tree))), encoding="utf-8")


# --- tests -----------------------------------------------------------------------------------------------------------


def _pytest(root: Path, *arguments: str, limit: int | None = None, **variables: str) -> subprocess.CompletedProcess[str]:
    settings = {"PYTHONPATH": str(root), "OPENBLAS_NUM_THREADS": "1", "PYTHONDONTWRITEBYTECODE": "", **variables}

    def limited() -> None:
        os.nice(5)
        if limit is not None:
            resource.setrlimit(resource.RLIMIT_CPU, (limit, limit))

    return subprocess.run([sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-rfE", *arguments], cwd=root,
                          env={**os.environ, **settings}, preexec_fn=limited, capture_output=True, text=True)  # fmt: skip


def _failed(done: subprocess.CompletedProcess[str]) -> list[str]:
    """Names of the tests that failed."""
    return [name.split(" - ")[0] for name in re.findall(r"^(?:FAILED|ERROR) (tests/.*)$", done.stdout, re.MULTILINE)]


def without_fault(root: Path, path: str) -> TestFile:
    """A file of tests, run without a fault."""
    reached, begun = root / "reached" / path.replace("/", "."), time.monotonic()
    done = _pytest(root, path, FAULTS_REACHED=str(reached))
    numbers = {int(line) for line in reached.read_text().split()} if reached.exists() else set()
    return TestFile(path, time.monotonic() - begun, numbers if done.returncode != NO_TESTS else set(), _failed(done))


def noticed_by(root: Path, fault: Fault, files: Sequence[TestFile]) -> str | None:
    """The first test that fails with a fault; None if none does."""
    folders = Path(fault.file).parts[1:-1]

    def order(file: TestFile) -> tuple[bool, float]:
        return Path(file.path).parts[1] not in folders, file.seconds

    for file in sorted((each for each in files if fault.number in each.reached), key=order):
        deselected = [word for name in file.failing for word in ("--deselect", name)]
        limit = int(ENDLESS[0] + ENDLESS[1] * file.seconds)
        done = _pytest(root, "-x", *deselected, file.path, limit=limit, FAULT=str(fault.number))
        if done.returncode not in (0, NO_TESTS):
            return next(iter(_failed(done)), f"{file.path}, which ends with {done.returncode}").partition("[")[0]
    return None


def copied(folder: Path, package: str, suite: str) -> Path:
    """A working tree of the revision `package` with the tests of the revision `suite`."""
    root = folder / "copy"
    git = ["git", "-C", str(ROOT)]
    subprocess.run([*git, "worktree", "add", "--quiet", "--detach", str(root), package], check=True)
    revision = subprocess.run([*git, "rev-parse", suite], check=True, capture_output=True, text=True).stdout.strip()
    inside = ["git", "-C", str(root)]
    subprocess.run([*inside, "rm", "-r", "--quiet", "tests"], check=True)
    subprocess.run([*inside, "checkout", "--quiet", revision, "--", "tests"], check=True)
    (root / "reached").mkdir()
    return root


def _row(fault: Fault, witness: str | None) -> str:
    name = witness.removeprefix("tests/").replace("::", " · ") if witness else "**nobody**"
    place = f"{fault.file.removeprefix(PACKAGE + '/')}:{fault.line}"
    change = fault.change if len(fault.change) <= 100 else fault.change[:97] + "…"
    return f"| {fault.number} | `{place}` | `{change.replace('|', '¦')}` | {name} |"


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=40)
    parser.add_argument("--only", default="", help="draw from files whose path contains this")
    parser.add_argument("--package", default="HEAD", metavar="REVISION", help="the package in which faults are planted")
    parser.add_argument("--suite", default="HEAD", metavar="REVISION", help="the tests")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    options = parser.parse_args(arguments)
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(options.jobs) as pool:
        root = copied(Path(folder), options.package, options.suite)
        try:
            faults = draw(root, options.seed, options.count, options.only)
            plant(root, faults)
            names = sorted(path.relative_to(root).as_posix() for path in (root / "tests").rglob("test_*.py"))
            files = list(pool.map(lambda name: without_fault(root, name), names))
            print(*(f"fails without a fault: {name}" for file in files for name in file.failing), sep="\n", file=sys.stderr)
            noticed = 0
            print("| | place | fault | noticed by |\n|---:|---|---|---|")
            for fault, witness in zip(faults, pool.map(lambda each: noticed_by(root, each, files), faults), strict=True):
                noticed += witness is not None
                print(_row(fault, witness), flush=True)
            print(f"\n{noticed} of {len(faults)} are noticed.")
        finally:
            subprocess.run(["git", "-C", str(ROOT), "worktree", "remove", "--force", str(root)], check=True)


if __name__ == "__main__":
    main()
