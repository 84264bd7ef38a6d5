"""CONTACT's own suite (github.com/eve70a/CONTACT, folders `examples` and `testbank`) imported, solved and compared.

    python -m scripts.peers PATH [--only WORD] [--grid N] [--halved PROGRAM] [--contact PROGRAM] [--write]

prints a row for each input file with an output beside it: its cases, how many can be written, and how many forces of these
differ from CONTACT's, on the elements of its suite, by up to 0.2 %, 1 % and 3 % of the largest component; then the reasons of
the cases that are left out. With --halved CONTACT's PROGRAM runs each file on elements half as long, too: a case
is then a match if its difference is below 0.2 % plus three times what that changes. With --contact instead the processor
seconds of each file that is written as a whole, here and with CONTACT's PROGRAM. --write puts the tables
into docs/verification.md."""

from __future__ import annotations

import argparse
import resource
import shutil
import subprocess
import tempfile
import time
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from scripts.figures.figures_documents import fill, markdown
from thermoroll_cli.cli.import_command import imported, solved
from thermoroll_cli.files.case import Override
from thermoroll_cli.files.case_errors import CaseError
from thermoroll_cli.peer.deck import Lines, cases_in
from thermoroll_cli.peer.reference import Forces, output_beside, reference_forces

ROOT = Path(__file__).parents[1]
BOUNDS = (0.002, 0.01, 0.03)
CHANGES = 3.0
"""A match differs by up to the first bound plus so many times what CONTACT changes by when it halves its elements."""
LONGEST = 600.0
"""Seconds for a file on halved elements; cases that are not done by then count by the first bound alone."""
HEADER = [
    "file",
    "cases",
    "written",
    "compared",
    *(f"within {100 * bound:g} %" for bound in BOUNDS),
    "match",
    "largest difference",
    "not solved",
]


def difference(force: Sequence[float], reference: Sequence[float]) -> float:
    """The largest difference of a component over the largest component of the reference."""
    scale = max(map(abs, reference))
    return max(abs(ours - theirs) for ours, theirs in zip(force, reference, strict=True)) / scale if scale else float("nan")


class Halved(Lines):
    """Lines of an input file in which elements become half as long as soon as their line is read, and in steady rolling the
    distance of a step."""

    first: tuple[int, ...] = ()

    def read(self, names: str, kinds: str, what: str = "") -> dict[str, Any]:
        begin, found = self.number, super().read(names, kinds, what)
        halves: tuple[str, ...] = ()
        if names == "FIRST SECOND":
            self.first = (*self.first[-2:], found["FIRST"])
        elif names.startswith("MX MY"):
            halves = ("DX", "DY")[: 1 + (found["MY"] > 1)]
        elif names.startswith("DX DS DQREL"):
            halves = ("DX", "DS")
        elif names.startswith("CHI DQ") and self.first[0] // 1000 % 10 == 3:
            halves = ("DQ",)
        new = {name: 0.5 * value if name in halves else value for name, value in found.items()}
        if names.startswith("MX MY"):
            new |= {"MX": 2 * found["MX"], "MY": 2 * found["MY"] if found["MY"] > 1 else 1}
        if new != found:
            nothing = ["%"] * (self.number - begin - 1)
            self.lines[begin : self.number] = [*nothing, " ".join(map(str, new.values()))]
        return found


def on_halved_elements(deck: Path, path: Path, program: Path, folder: Path) -> dict[int, Forces]:
    """The forces of CONTACT on elements half as long, from a copy of `path` in `folder`."""
    lines = Halved(str(deck), deck.read_text(errors="replace").splitlines())
    for _ in cases_in(lines):
        pass
    copy = shutil.copytree(path, folder / "halved", ignore=shutil.ignore_patterns("*.ref_out", "*.out"))
    there = copy / deck.relative_to(path).with_suffix(".inp")
    there.write_text("\n".join(lines.lines))
    try:
        subprocess.run([program.resolve(), "2", there.stem], cwd=there.parent, stdout=subprocess.DEVNULL, timeout=LONGEST)
    except subprocess.TimeoutExpired:
        print("  ", deck.stem, f"on halved elements: not all cases in {LONGEST:g} s", flush=True)
    return reference_forces(there.with_suffix(".out"))


def row_of(
    deck: Path, name: str, overrides: Sequence[Override], left_out: Counter[str], folder: Path, finer: Mapping[int, Forces]
) -> tuple[list[str], list[int]]:
    """The row of one input file, and its numbers; reasons of cases that are left out are counted in `left_out`. Results go
    into `folder`; `finer` are the forces on halved elements."""
    try:
        cases = imported(deck)
    except CaseError as cause:
        left_out[f"the file ends in an error: {cause.findings[0].message}"] += 1
        return [name, *["0"] * (len(HEADER) - 3), "", "the file"], [0] * (len(HEADER) - 3)
    left_out.update(each.reason for each in cases if each.case is None)
    beside = output_beside(deck)
    reference = reference_forces(beside) if beside else {}
    differences, unsolved, matches = [], [], 0
    for each in (each for each in cases if each.case is not None):
        try:
            row = solved(each, reference, overrides, folder)
        except Exception as cause:
            # A fault of one case is to be seen, and the others too.
            unsolved.append(f"{each.number} ({type(cause).__name__})")
            continue
        if row["status"] != "converged":
            unsolved.append(str(each.number))
        elif row["reference"]:
            differences.append((difference(row["force"], row["reference"]), each.number))
            change = difference(finer[each.number].whole, reference[each.number].whole) if each.number in finer else 0.0
            matches += differences[-1][0] <= BOUNDS[0] + CHANGES * change
        print("  ", name, row, flush=True)
    counts = [
        len(cases),
        sum(each.case is not None for each in cases),
        len(differences),
        *(sum(error <= bound for error, _ in differences) for bound in BOUNDS),
        matches if finer else 0,
    ]
    worst = f"{100 * max(differences)[0]:.2g} % (case {max(differences)[1]})" if differences else ""
    known = [*map(str, counts[:-1]), str(matches) if finer else ""]
    return [name, *known, worst, ", ".join(unsolved)], counts


def seconds_of(deck: Path, path: Path, program: Path, folder: Path) -> list[str]:
    """File, cases, and the processor seconds of all of them here, from reading to results, and of `program` in a copy of `path`
    in `folder`; nothing if a case is left out."""
    begun = time.process_time()
    cases = imported(deck)
    if any(each.case is None for each in cases):
        return []
    for each in cases:
        solved(each, {}, [], folder)
    here = time.process_time() - begun
    copy = folder / "copy"
    shutil.copytree(path, copy)
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    there = copy / deck.relative_to(path)
    subprocess.run([program.resolve(), "2", there.stem], cwd=there.parent, check=True, stdout=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    theirs = after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime
    return [deck.stem, str(len(cases)), f"{here:.2g}", f"{theirs:.2g}"]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("path", type=Path)
    parser.add_argument("--only", default="", help="only files whose name has this word")
    parser.add_argument("--grid", type=int, default=0, help="elements per side; as imported if left out")
    parser.add_argument("--halved", type=Path, metavar="PROGRAM", help="CONTACT's executable: its elements halved, too")
    parser.add_argument("--contact", type=Path, metavar="PROGRAM", help="CONTACT's executable: compare times")
    parser.add_argument("--write", action="store_true", help="write the tables into docs/verification.md")
    options = parser.parse_args()
    decks = sorted(
        deck
        for ending in ("*.inp", "*.ref_inp")
        for deck in options.path.rglob(ending)
        if output_beside(deck) and options.only in str(deck)
    )
    if options.contact:
        times = []
        for deck in decks:
            with tempfile.TemporaryDirectory() as folder:
                times.append(seconds_of(deck, options.path, options.contact, Path(folder)))
        table = {"header": ["file", "cases", "processor s", "CONTACT's"], "rows": [row for row in times if row]}
        print(markdown(table))
        if options.write:
            fill(ROOT / "docs", {"peers": {"times": table}})
        return
    overrides = [Override.parse(f"numerics.grid={options.grid}")] if options.grid else []
    left_out: Counter[str] = Counter()
    rows, sums = [], [0] * (len(HEADER) - 3)
    for deck in decks:
        with tempfile.TemporaryDirectory() as folder:
            finer = on_halved_elements(deck, options.path, options.halved, Path(folder)) if options.halved else {}
            row, counts = row_of(deck, deck.stem, overrides, left_out, Path(folder), finer)
        rows.append(row)
        sums = [one + other for one, other in zip(sums, counts, strict=False)]
    tables = {
        "suite": {"header": HEADER, "rows": [*(row for row in rows if row[2] != "0"), ["all", *map(str, sums), "", ""]]},
        "reasons": {
            "header": ["left out for", "cases"],
            "rows": [[reason, str(count)] for reason, count in left_out.most_common()],
        },
    }
    print(*(markdown(table) for table in tables.values()), sep="\n")
    if options.write:
        fill(ROOT / "docs", {"peers": tables})


if __name__ == "__main__":
    main()
