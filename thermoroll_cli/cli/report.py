"""`thermoroll report` and the option `--report`: one HTML file with all that there is to say of a result, which loads nothing
and runs no scripts."""

from __future__ import annotations

import base64
import re
import tempfile
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import jinja2
import typer
from PIL import Image

from thermoroll_cli import __version__
from thermoroll_cli.cli import options, streams
from thermoroll_cli.cli.results import check_no_cases
from thermoroll_cli.cli.tables import assembly_rows, swept_text, warnings_by_kind
from thermoroll_cli.files.case import Case
from thermoroll_cli.files.table_file import history_beside, read_stored
from thermoroll_cli.many_contacts.wheelset.conicity import NUMBERS, Conicity
from thermoroll_cli.plots import pictures
from thermoroll_cli.plots.conicity_figure import draw_conicity
from thermoroll_cli.plots.sweep_figures import numbers, rows_of, words_of
from thermoroll_cli.problem.columns import Columns
from thermoroll_cli.problem.names import (
    ALL_SCALARS,
    ASSEMBLY_SCALARS,
    DIAGRAMS,
    HISTORY_SCALARS,
    LINE_PROBLEM_SCALARS,
    PROBLEM_SCALARS,
    column_of,
    unit_of,
)
from thermoroll_cli.problem.result import Result
from thermoroll_cli.problem.scalar_errors import (
    computed,
    isothermal_text,
    listed_scalars,
    meaning_in,
    number,
    repeats,
    row_of,
    scalar_text,
    worth_showing,
)
from thermoroll_cli.studies.sweeps.table_picture import draw_table
from thermoroll_cli.tools.atomic import write_bytes

DPI = 150
MOST_ROWS = 100
"""Rows of the table of a sweep; a reader of more has the file."""
METHOD = ("The steady state of two elastic bodies that roll on each other with dry friction, after Yu and Suh: half-spaces, "
          "discretised by rectangular elements on grids of rising fineness; pressure, tractions, frictional heat and thermal "
          "expansion are iterated until they agree.")  # fmt: skip
METHOD_OVER_TIME = ("Two elastic bodies in contact with dry friction while inputs change: half-spaces, with rectangular "
                    "elements; each step is a steady problem that remembers displacements and heat of those before it.")
VERSIONS = {"program_version": "thermoroll", "python_version": "Python", "numpy_version": "NumPy", "scipy_version": "SciPy",
            "fftw_version": "FFTW", "h5py_version": "h5py"}  # fmt: skip
"""Attributes of a result file that a report names."""

Draw = Callable[[Path, tuple[str, ...]], object]
"""Writes pictures in these formats into a folder."""


class ReportTable(NamedTuple):
    """Cells of text. Columns `values` are never broken; columns `names` are for those who write programs."""

    rows: Sequence[Sequence[str]]
    header: Sequence[str] = ()
    caption: str = ""
    values: Sequence[int] = ()
    names: Sequence[int] = ()


class Picture(NamedTuple):
    """A picture with its content as `address`, `width` mm wide."""

    name: str
    address: str
    width: float


@dataclass(frozen=True)
class Section:
    """All that a report says of one result, in the order in which it says it; `estimated`: some of its numbers have a ±."""

    title: str
    what: Sequence[str]
    failure: str = ""
    warnings: Sequence[str] = ()
    tables: Sequence[ReportTable] = ()
    pictures: Sequence[Picture] = ()
    case: str = ""
    method: str = METHOD
    skipped: Sequence[str] = ()
    versions: str = ""
    estimated: bool = True


def report(
    results: Annotated[
        list[Path], typer.Argument(metavar="RESULT.h5...", help="Result files of run; sweep.csv or sweep.h5 of sweep.")
    ],
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="FILE.html", help="File to write; see below for the default.")
    ] = None,
    quiet: options.Quiet = False,
    verbose: options.Trace = False,
) -> None:
    """Write results as one HTML file, to be sent, read and printed.

    It has warnings, scalars with their errors, pictures, the case, and the versions. It loads nothing from anywhere and runs no
    scripts. The default is NAME_report.html beside a result, and report.html beside the first of several.
    """
    check_no_cases(results)
    first = results[0]
    target = output or first.with_name(f"{first.stem}_report.html" if len(results) == 1 else "report.html")
    if target.suffix.lower() not in (".html", ".htm"):
        raise typer.BadParameter(f"{target} is no HTML file: end its name with .html", param_hint="--output")
    # All of them are read before the first picture is drawn.
    stored = [(read_stored(path), history_beside(path)) for path in results]
    options.check_writable(target.parent)
    write(target, [of_columns(found, path.stem) if not isinstance(found, Result) else
                   of_result(found, path.stem) if history is None else of_history(found, history, path.stem)
                   for (found, history), path in zip(stored, results, strict=True)])  # fmt: skip
    if not quiet:
        streams.write(str(target))


def write(path: Path, sections: Sequence[Section]) -> Path:
    """Replace the file at `path` by a report, and return the path. Raises OSError."""
    template = jinja2.Environment(autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True).from_string(
        Path(__file__).with_name("report.html").read_text(encoding="utf-8"))
    title = sections[0].title + (f" and {len(sections) - 1} more" if len(sections) > 1 else "")
    text = template.render(title=title, sections=sections, version=__version__)
    # Half a character, which a title may hold, has no place in UTF-8.
    write_bytes(path, text.encode("utf-8", "backslashreplace"))
    return path


def pictures_of(draw_in: Draw) -> tuple[Picture, ...]:
    """The pictures that `draw_in` writes: as SVG up to 150 kB, else as PNG, as maps of many elements."""
    shown = []
    with tempfile.TemporaryDirectory() as place:
        draw_in(folder := Path(place), ("png", "svg"))
        for path in sorted(folder.glob("*.png"), key=lambda path: path.stat().st_mtime_ns):
            with Image.open(path) as image:
                width = round(25.4 * image.width / float(image.info["dpi"][0]))
            vector = path.with_suffix(".svg")
            small = vector.stat().st_size <= 150_000
            content = base64.b64encode((vector if small else path).read_bytes()).decode("ascii")
            name = path.stem.removeprefix("picture_").replace("_", " ")
            shown.append(Picture(name, f"data:image/{'svg+xml' if small else 'png'};base64,{content}", width))
    return tuple(shown)


def picture(name: str, draw: Callable[[Path], object]) -> tuple[Picture, ...]:
    """The only picture of a section, which `draw` writes to a file; its name may hold what no file has, as of rad/mm."""
    shown = pictures_of(lambda folder, formats: [draw(folder / f"picture.{each}") for each in formats])
    return tuple(one._replace(name=name) for one in shown)


def of_result(result: Result, name: str) -> Section:
    """What a report says of a contact or an assembly; `name` stands for a title that there is not."""
    kinds = [kind for kind in pictures.kinds_of(result) if kind != "summary"]  # the report is one
    kinds += result.kind.answer.report_pictures
    problem, work, skipped = result.problem, result.work, result.work.get("skipped", {})
    if not result.assembly and problem.line:    # whose cut along rolling has the curves of all its fields
        kinds = [kind for kind in kinds if kind not in ("pressure", "traction", "heat_flux", "temperature")]
    if result.assembly:
        count = len(result.contacts)
        what = [f"{result.kind.answer.sentence}, with {count} patch{'' if count == 1 else 'es'} of contact."]
    else:
        load = f"load {problem.force_text(problem.normal_force)}" if problem.approach is None else (
            f"approach {number(1e6 * problem.approach)} µm")
        if problem.vertical is not None:
            load = f"vertical force {number(problem.vertical)} N"
        heat = "without heat" if not problem.heating.heat else "with frictional heat" + (
            " and thermal expansion" if result.coupled is not result.isothermal else ", which does not change the contact here")
        friction = problem.friction
        bodies = "cylinders, a line contact per mm of length" if problem.line else "bodies in rolling contact"
        at = f"{result.last_of[0].upper()}{result.last_of[1:]}, of two" if result.last_of else "Two"
        what = [f"{at} {bodies}: {load}, "
                + (f"coefficient of friction {number(friction.coefficient)}" if friction.law is None
                   else f"friction after the law {friction.law.kind}")
                + f", speed {number(problem.motion.speed)} m/s, {heat}."]  # fmt: skip
    if grid := work.get("grid"):
        what.append(f"Finest grid: {' × '.join(map(str, grid))} elements{' for each patch' if result.assembly else ''}.")

    def draw_in(folder: Path, formats: tuple[str, ...]) -> None:
        pictures.draw(result, folder / "picture", kinds=kinds, formats=formats, dpi=DPI)

    return Section(
        problem.title or name, what, "" if result.converged else result.reason, result.warnings, _tables(result),
        pictures_of(draw_in), result.case_text,
        METHOD_OVER_TIME if HISTORY_SCALARS.keys() & result.coupled.scalars.keys() else METHOD,
        skipped=[f"Left out: {'; '.join(f'{stage} ({why})' for stage, why in skipped.items())}."] if skipped else [],
        versions=versions(result.attributes))  # fmt: skip


def of_history(result: Result, history: Columns, name: str) -> Section:
    """What a report says of a contact over time: the curves of its `history`, and its last state."""
    last, curves = of_result(result, name), of_columns(replace(history, attributes=result.attributes), name)
    return replace(last, what=[*curves.what, *last.what], tables=[*last.tables, *curves.tables], method=curves.method,
                   pictures=(*curves.pictures, *last.pictures))


def _tables(result: Result) -> list[ReportTable]:
    row, both = row_of(result.summary()), result.isothermal is not result.coupled
    names = listed_scalars(row, result.problem)
    if result.assembly:
        single, sides, patches = assembly_rows(result, names, verbose=False)
        if result.kind.answer.columns:
            beside = ReportTable(sides[1:], sides[0], result.kind.answer.columns_title, range(len(sides[0])))
        else:
            of_sides = [(re.sub(", left wheel|left ", "", ASSEMBLY_SCALARS[row[0].replace("_SIDE", "_left")].meaning),
                         *row[1:], row[0]) for row in sides[1:]]  # fmt: skip
            beside = ReportTable(of_sides, ("both sides", "left", "right", "unit", "name"), values=(1, 2, 3), names=(4,))
        contact_scalars = result.kind.answer.of_contacts
        return [ReportTable(_rows(row, single, both=False), ("", "value", "unit", "name"), values=(1, 2), names=(3,)),
                *([beside] if sides else []),
                *([ReportTable([(contact_scalars[row[0]].meaning, *row[1:], row[0]) for row in patches[1:]],
                         (*patches[0][:-1], "unit", "name"), "Patches of contact", range(1, len(patches[0])),
                         (len(patches[0]),))] if patches else [])]  # fmt: skip
    header = ("", "value", *(("without thermal expansion",) if both else ()), "unit", "name")
    known = [name for name in PROBLEM_SCALARS | LINE_PROBLEM_SCALARS if computed(row.get(name)) and name not in names]
    return [ReportTable(_rows(row, names, both=both), header, values=range(1, len(header) - 1), names=(len(header) - 1,)),
            ReportTable(_rows(row, known, both=False), ("", "value", "unit", "name"), "Known before solving", (1, 2), (3,))]


def _rows(row: Mapping[str, Any], names: Iterable[str], *, both: bool) -> list[tuple[str, ...]]:
    shown = [name for name in names if computed(row.get(name)) and not repeats(name, row)]
    return [(meaning_in(row, name) + (" (no limit)" if name in row.get("unbounded", ()) else ""),
             scalar_text(name, row), *((isothermal_text(name, row),) if both else ()), unit_of(name), name)
            for name in shown]  # fmt: skip


def of_columns(table: Columns, name: str) -> Section:
    """What a report says of the points of a sweep, or of the states of a history."""
    columns, count = table.columns, table.count
    converged = sum(status == "converged" for status in columns["status"])
    over = "; ".join(f"{key} with {len(set(columns[key]))} values" for key in table.label)
    what = f"A sweep over {over}: {converged} of {count} points converged."
    if table.of_history:
        first, *_, last = columns[table.place]
        what = (f"A contact over {column_of(table.place)[1]}, from {number(first)} to {number(last)} {unit_of(table.place)}: "
                f"{converged} of {count} states converged.")
    points = [", ".join(f"{key} = {swept_text(columns[key][row])}" for key in table.label) for row in range(count)]
    failed = [f"{point}: {reason}" for point, status, reason in zip(points, columns["status"], columns["reason"], strict=True)
              if status != "converged"]
    # An empty cell of a table of text is nan.
    warnings = warnings_by_kind((point, [text] if isinstance(text, str) and text else [])
                                for point, text in zip(points, columns.get("warnings", [""] * count), strict=True))  # fmt: skip
    why_not = ""

    def draw(path: Path) -> None:
        nonlocal why_not
        why_not = draw_table(table, path, dpi=DPI)

    shown = picture(f"scalars over {' and '.join(map(words_of, table.label))}", draw)
    return Section(
        table.title or name, [what, *([f"There is no picture: {why_not}."] if why_not else [])],
        "; ".join(failed[:5]) + (f"; and {len(failed) - 5} more" if len(failed) > 5 else ""), list(warnings),
        [_columns_table(table)], shown, table.case_text, METHOD_OVER_TIME if table.of_history else METHOD,
        versions=versions(table.attributes))  # fmt: skip


def of_conicity(found: Conicity, case: Case) -> Section:
    """What a report says of an equivalent conicity."""
    record = found.record()
    curve = [(number(amplitude), *(number(record[name][place], 4) for name in ("conicity", "wavelength_m")))
             for place, amplitude in enumerate(record["amplitude_mm"]) if abs(amplitude - round(amplitude)) < 1e-9]
    return Section(
        case.settings.title or case.name, ["Equivalent conicity of a wheelset on its track."], warnings=found.warnings,
        tables=[ReportTable([(meaning, number(record[name], 4), name) for name, meaning in NUMBERS.items()],
                            ("", "value", "name"), values=(1,), names=(2,)),
                ReportTable(curve, ("amplitude (mm)", "conicity", "wavelength (m)"), "At whole amplitudes", range(3))],
        pictures=picture("conicity", lambda path: draw_conicity(path, found, case.settings.title)), case=case.text,
        method="After EN 15302, from the difference of the rolling radii over the lateral shift of the wheelset; "
        "nothing but profiles and gauge matters.", estimated=False)  # fmt: skip


def _columns_table(table: Columns) -> ReportTable:
    """A row for each point: the swept values and the scalars that have a diagram and change."""
    arrays = {name: numbers(column) for name, column in table.numbers.items()}
    rows = rows_of(arrays)
    drawn = [name for names in DIAGRAMS.values() for name in names
             if name in arrays and worth_showing(name, rows, table.label)]
    texts = {name: [scalar_text(name, row) if computed(row.get(name)) else "–" for row in rows] for name in drawn}
    varying = [name for name in drawn if len(set(texts[name])) > 1 or len(rows) == 1]
    varying = varying[: max(7 - len(table.label), 1)]  # a sheet of A4 holds seven columns
    body = [(*(swept_text(table.columns[key][row]) for key in table.label), *(texts[name][row] for name in varying))
            for row in range(min(len(rows), MOST_ROWS))]  # fmt: skip
    caption = f"The first {MOST_ROWS} of {len(rows)} points" if len(rows) > MOST_ROWS else ""
    headers = (f"{ALL_SCALARS[name].brief or ALL_SCALARS[name].meaning}"
               + (f" ({unit_of(name)})" if unit_of(name) else "") for name in varying)  # fmt: skip
    return ReportTable(body, (*table.label, *headers), caption, range(len(table.label) + len(varying)))


def versions(attributes: Mapping[str, Any]) -> str:
    """When and with what a result was computed; nothing where its file says nothing."""
    if not {"created", "platform", "command_line"} <= set(attributes):
        return ""
    parts = ", ".join(f"{words} {attributes[name]}" for name, words in VERSIONS.items() if name in attributes)
    when = re.sub(r"T(\d\d:\d\d).*", r" \1 UTC", str(attributes["created"]))
    return f"Computed {when} with {parts} on {attributes['platform']}: {attributes['command_line']}"
