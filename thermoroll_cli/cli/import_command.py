"""`thermoroll import`: cases of CONTACT."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import typer

from thermoroll_cli.cli import options
from thermoroll_cli.cli.deliver import Ending, Outcome, deliver
from thermoroll_cli.cli.progress import PointsProgress
from thermoroll_cli.cli.streams import ExitCode
from thermoroll_cli.files.case import Case, CaseError, Override
from thermoroll_cli.peer.convert import DeckAxes, EarlierCase, LeftOut, converted, without
from thermoroll_cli.peer.deck import read_deck
from thermoroll_cli.peer.reference import Forces, output_beside, reference_forces
from thermoroll_cli.problem.geometry import Unsolvable
from thermoroll_cli.python_api import solve
from thermoroll_cli.tools.atomic import write_bytes


class Imported(NamedTuple):
    """A case of CONTACT by its `number`: the case here with the axes of its forces, or the reason why there is none; and
    what it is `without`."""

    number: int
    case: Case | None = None
    axes: DeckAxes | None = None
    reason: str = ""
    without: str = ""


def import_(
    file: Annotated[Path, typer.Argument(metavar="FILE.inp", help="Input file of CONTACT.")],
    output: Annotated[Path, typer.Option("--output", "-o", metavar="DIR", help="Folder for the cases.")] = options.RESULTS,
    case: Annotated[int | None, typer.Option("--case", min=1, metavar="N", help="Only this case of the file.")] = None,
    run: Annotated[
        bool, typer.Option("--run", help="Solve the cases into DIR/FILE_N.h5; with FILE.out or FILE.ref_out, forces beside it.")
    ] = False,
    settings: options.Settings = None,
    as_json: options.AsJson = False,
    quiet: options.Quiet = False,
) -> None:
    """Write the cases of an input file of CONTACT as cases DIR/FILE_N.toml, and say which cannot be written and why.

    Profiles are referred to where they are. --set changes the cases that --run solves, not those that are written. The exit
    code is 3 if no case can be written.
    """
    if settings and not run:
        raise typer.BadParameter("changes the cases that --run solves, not those that are written", param_hint="--set")
    with options.recorded(file, as_json):
        found = imported(file, case)
    written, files = [each.case for each in found if each.case is not None], list[Path]()
    overrides, compared = options.parse_overrides(settings), list[dict[str, Any]]()
    if written:
        options.check_writable(output)
    for one in written:
        files.append(output / f"{one.name}.toml")
        write_bytes(files[-1], one.text.encode())
    if run:
        beside = output_beside(file)
        reference = reference_forces(beside) if beside else {}
        with PointsProgress(len(written), quiet=quiet) as progress:
            for each in found:
                if each.case is not None:
                    compared.append(solved(each, reference, overrides, output))
                    progress.step(f"{each.case.name}: {compared[-1]['status']}")
        files += [path for one in written if (path := output / f"{one.name}.h5").exists()]
    code = deliver(Written(file, output, found, files, compared if run else None), Ending(output, as_json, quiet=quiet))
    raise typer.Exit(code if written else ExitCode.INVALID_CASE)


@dataclass
class Written(Outcome):
    """The cases that were `found` in an input `file`, the `files` that have been written into `folder`, and the forces of those
    that were solved beside those of CONTACT (`compared`; None: none was to be)."""

    file: Path
    folder: Path
    found: Sequence[Imported]
    files: Sequence[Path]
    compared: Sequence[Mapping[str, Any]] | None

    def __post_init__(self) -> None:
        self.name, self.stem = self.file.name, self.file.stem
        failed = sum(row["status"] != "converged" for row in self.compared or ())
        self.reason = f"{failed} of {len(self.compared or ())} cases" if failed else ""
        self.written = [each.case.name for each in self.found if each.case is not None]

    def write(self, folder: Path) -> Sequence[Path]:
        return self.files

    def pictures(self, folder: Path) -> tuple[str, ...]:
        return ()

    def record(self) -> Mapping[str, Any]:
        return {"cases": len(self.found), "written": self.written,
                "left_out": [{"case": each.number, "reason": each.reason} for each in self.found if each.case is None],
                "without": [{"case": each.number, "without": each.without} for each in self.found if each.without],
                **({} if self.compared is None else {"compared": self.compared})}

    def lines(self) -> Iterator[str]:
        yield f"{self.file}: {len(self.written)} of {len(self.found)} cases written to {self.folder}"
        yield from (f"  case {each.number}: {each.reason}" for each in self.found if each.case is None)
        yield from (f"  case {each.number}: written without {each.without}" for each in self.found if each.without)
        for row in self.compared or ():
            yield (f"  case {row['case']}: {row['status']}, force {_shown(row['force'])} N"
                   + (f", CONTACT {_shown(row['reference'])} N" if row["reference"] else "")
                   + (f": {row['reason']}" if "reason" in row else ""))


def imported(file: Path, only: int | None = None) -> list[Imported]:
    """All cases of the input file, or case `only`. Raises CaseError."""
    cases = read_deck(file)
    if only is not None and only > len(cases):
        raise typer.BadParameter(f"{file} has {len(cases)} cases", param_hint="--case")
    found: list[Imported] = []
    before: dict[tuple[int, int, int], EarlierCase] = {}
    for each in cases:
        name = f"{file.stem}_{each.number}"
        try:
            content, axes = converted(each, file, before.get(each.contact))
            found.append(Imported(each.number, Case.from_dict(content, name=name), axes, without=without(each)))
            before[each.contact] = EarlierCase(name, axes)
        except LeftOut as cause:
            found.append(Imported(each.number, reason=str(cause)))
        except CaseError as cause:
            finding = cause.findings[0]
            if finding.source == str(file):
                raise
            allowed = f" (allowed: {finding.allowed})" if finding.allowed else ""
            found.append(Imported(each.number, reason=f"{finding.headline}{allowed}"))
        if found[-1].case is None:
            before.pop(each.contact, None)
    return [each for each in found if only is None or each.number == only]


def solved(each: Imported, reference: Mapping[int, Forces], overrides: Sequence[Override], folder: Path) -> dict[str, Any]:
    """Status and forces of a case with `overrides` beside those of CONTACT, in its axes. The result is written into `folder`,
    where a case over time finds the state that it begins with."""
    assert each.case is not None and each.axes is not None
    theirs = reference.get(each.number)
    row: dict[str, Any] = {"case": each.number, "status": "invalid", "force": None,
                           "reference": theirs and (theirs.patches if each.axes.in_patches else theirs.whole)}
    try:
        result = solve(Case.parse(each.case.text, name=str(folder / each.case.name), overrides=overrides))
    except CaseError as cause:
        return {**row, "reason": cause.findings[0].headline}
    except Unsolvable as cause:
        return {**row, "reason": str(cause)}
    result.save(folder / f"{each.case.name}.h5")
    summary = result.summary()
    row |= {"status": summary["status"], "force": each.axes.force(summary, [patch.record for patch in result.contacts])}
    return row if result.converged else {**row, "reason": result.reason}


def _shown(force: list[float] | None) -> str:
    return "none" if force is None else "[" + ", ".join(f"{part:.4g}" for part in force) + "]"
