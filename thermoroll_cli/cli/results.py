"""`thermoroll plot`, `compare` and `export`: commands on result files."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from thermoroll_cli.cli import options, streams
from thermoroll_cli.cli.streams import ExitCode
from thermoroll_cli.cli.tables import folded, with_remarks
from thermoroll_cli.files.result.compare import compare as compared
from thermoroll_cli.files.result.compare import compare_tables
from thermoroll_cli.files.result.export import export_csv, export_stress_path, export_vtu, export_xdmf
from thermoroll_cli.files.result.outcome import read_result, read_tree
from thermoroll_cli.problem.names import PLACES, check_scalar, known_as
from thermoroll_cli.problem.result import Result

if TYPE_CHECKING:
    from thermoroll_cli.problem.columns import Columns

Folder = Annotated[
    Path | None, typer.Option("--output", "-o", metavar="DIR", help="Folder to write to; default: beside the result.")
]
OneResult = Annotated[Path, typer.Argument(metavar="RESULT.h5", help="Result file of thermoroll run.")]
ExportFormat = StrEnum("ExportFormat", "xdmf vtu csv")
"""File types for other programs."""


def plot(
    results: Annotated[
        list[Path], typer.Argument(metavar="RESULT.h5...", help="Result files of run; NAME_history.h5; sweep.csv or sweep.h5.")
    ],
    output: Folder = None,
    formats: options.Formats = None,
    dpi: options.Dpi = None,
    normalised: options.Normalised = False,
    fields: Annotated[
        str, typer.Option("--fields", metavar="A,B", help="These pictures, or maps of these fields, instead of all kinds.")
    ] = "",
    cut_y: Annotated[float | None, typer.Option("--cut-y", metavar="MM", help="Curves along x at this y.")] = None,
    over_x: options.Over = "",
    columns: Annotated[
        str, typer.Option("--columns", metavar="A,B", help="Sweeps and histories: these scalars alone.")
    ] = "",
    together: Annotated[
        bool, typer.Option("--over", help="All in one picture: curves of sweeps or histories, centre lines of results.")
    ] = False,
    theories: options.Compare = "",
    data: options.Data = None,
    animate: Annotated[
        str, typer.Option("--animate", metavar="KEY",
                          help="A sweep or a contact over time as a GIF, with a frame for each value of this key.")
    ] = "",
    quiet: options.Quiet = False,
    verbose: options.Trace = False,
) -> None:
    """Draw the pictures of results and sweeps again."""
    from thermoroll_cli.files.table_file import history_beside, read_stored
    from thermoroll_cli.plots.pictures import draw, kinds_of
    from thermoroll_cli.studies.sweeps.measured import Measured
    from thermoroll_cli.studies.sweeps.table_picture import draw_table

    check_no_cases(results)
    endings, stems = options.image_formats(formats), [_stem(path, output) for path in results]
    if not together and (twice := next((stem for stem in stems if stems.count(stem) > 1), None)):
        raise typer.BadParameter(f"several results would write {twice}_*.{endings[0]}: draw them into folders of their own "
                                 "with -o", param_hint="RESULT.h5...")  # fmt: skip
    with options.usage("--measured"):
        measured = None if data is None else Measured.read(data)
    # All of them are read before the first picture is drawn.
    stored = [read_stored(path, with_fields=bool(animate)) for path in results]
    of_results = {"--fields": fields, "--cut-y": cut_y is not None, "--normalised": normalised}
    of_tables = {"--x": over_x, "--columns": columns, "--compare": theories, "--measured": data, "--animate": animate}
    tables = [not isinstance(one, Result) for one in stored]
    for unlike, kind, given in ((all(tables), "a table", of_results), (not any(tables), "a result", of_tables)):
        # A result over time has a table beside it.
        if (unused := next((name for name, value in given.items() if value), None)) and unlike and not any(
                map(history_beside, results)):
            raise typer.BadParameter(f"{results[0]} is {kind}, of which this option draws nothing", param_hint=unused)
    if output is not None:
        options.check_writable(output)
    if together:
        with options.usage("--over"):
            # Sweeps are all called alike: their folders are not.
            alike = len({path.stem for path in results}) < len(results)
            written = [_over(dict(zip((path.parent.resolve().name if alike else path.stem for path in results), stored,
                                      strict=True)),
                             stems[0].with_name(f"{stems[0].name}_over.{ending}"), dpi, over_x, options.words(columns))
                       for ending in endings]  # fmt: skip
        streams.write(*map(str, written if not quiet else ()))
        return
    for path, stem, result in zip(results, stems, stored, strict=True):
        try:
            if animate:
                if isinstance(result, Result):
                    raise ValueError("a single result does not move: --animate takes sweep.csv or NAME_history.h5")
                written, names = [_animated(path, stem, result, animate)], []
            elif isinstance(result, Result):
                if result.assembly and not fields and (normalised or cut_y is not None):
                    raise ValueError("--cut-y and --normalised are of the pictures of contacts, which --fields asks for here: "
                                     "--fields centreline")
                written = draw(result, stem, kinds=options.words(fields), formats=endings, dpi=dpi,
                               normalised=normalised, cut_y=None if cut_y is None else cut_y / 1e3)  # fmt: skip
                names = [f"{stem.name}_{kind}" for kind in kinds_of(result)]
                if not fields and (history := history_beside(path)) is not None:
                    names.append(f"{stem.name}_history")
                    written += [picture for ending in endings if not draw_table(
                        history, picture := stem.with_name(f"{names[-1]}.{ending}"), dpi=dpi, only=options.words(columns))]
            else:
                written, names = [stem.with_name(f"{stem.name}.{ending}") for ending in endings], [stem.name]
                for name in options.words(columns):
                    if known_as(name, result) not in result:
                        check_scalar(name)
                for doubt in result.lacks(options.words(columns)):
                    streams.note(f"thermoroll: {path}: {doubt}")
                for picture in written:
                    if why_not := draw_table(result, picture, compare=options.words(theories), dpi=dpi, measured=measured,
                                             x=over_x, only=options.words(columns)):
                        raise ValueError(why_not)
        except ValueError as cause:
            raise typer.BadParameter(f"{path}: {cause}") from None
        if not quiet:
            streams.write(*map(str, written))
            # Those of other formats may show this very result.
            stale = (stem.with_name(f"{name}.{ending}") for name in names for ending in endings)
            options.report_stale(stale if not fields else (), written)


def _over(found: Mapping[str, Result | Columns], path: Path, dpi: float | None, x: str, only: Sequence[str]) -> Path:
    """Several results, or several tables, in one picture at `path`. Raises ValueError where they do not go together."""
    from thermoroll_cli.plots import style
    from thermoroll_cli.plots.cuts import over_figure
    from thermoroll_cli.plots.run_frame import frame_of
    from thermoroll_cli.studies.sweeps.table_picture import draw_table, over_each_other

    results = {name: each for name, each in found.items() if isinstance(each, Result)}
    tables = {name: each for name, each in found.items() if not isinstance(each, Result)}
    if len(found) < 2 or (results and tables) or any(each.assembly for each in results.values()):
        raise ValueError("takes several results of contacts, or several tables of sweeps or histories, of names of their own")
    if tables:
        merged = over_each_other(tables)
        if why_not := draw_table(merged, path, dpi=dpi, x=x or merged.varied[1], only=only):
            raise ValueError(why_not)
        return path
    with style.applied():
        figure = over_figure({name: frame_of(each) for name, each in results.items()})
        if figure is None:
            raise ValueError("there is nothing to show")
        return style.save(figure, path, dpi)


def _animated(path: Path, stem: Path, table: Columns, key: str) -> Path:
    """The animation of a sweep. Raises ValueError where it has not what that needs."""
    from thermoroll_cli.plots.animation import draw_animation

    if table.of_history and key in (*PLACES,):
        if len(table.states) < 2:
            raise ValueError("it has no fields of two states: set history.fields_every, and take NAME_history.h5")
        states = table.states
        return draw_animation(stem.with_suffix(".gif"), list(states.values()), key, [table[key][row] for row in states])
    if key not in table.varied:
        raise ValueError(f"{key} was not swept, but {', '.join(table.varied)}")
    if words := [value for value in table[key] if isinstance(value, str)]:
        raise ValueError(f"{key} has words, such as {words[0]}: an animation follows a key with numbers")
    columns = table.columns
    if others := [other for other in table.varied if other != key and len(set(columns[other])) > 1]:
        raise ValueError(f"an animation follows one key, but {', '.join(others)} varies, too")
    shown = [row for row, status in enumerate(columns["status"]) if status == "converged"]
    files = [path.with_name(str(columns["file"][row])) for row in shown if "file" in columns and columns["file"][row]]
    if len(shown) < 2:
        raise ValueError("an animation needs two points that converged")
    if len(files) < len(shown):
        raise ValueError("its points have no result files to draw: run the sweep again without --scalars-only")
    return draw_animation(stem.with_suffix(".gif"), [read_result(file) for file in files], key,
                          [columns[key][row] for row in shown])


def compare(
    a: Annotated[Path, typer.Argument(metavar="A.h5", help="Result file.")],
    b: Annotated[Path, typer.Argument(metavar="B.h5", help="Result file to compare with it.")],
    rtol: Annotated[
        float,
        typer.Option("--rtol", min=0, max=1e9, metavar="R", callback=options.a_number, help="Largest relative difference."),
    ] = 1e-6,
    as_json: options.AsJson = False,
    quiet: options.Quiet = False,
    verbose: options.Verbose = False,
) -> None:
    """Compare two results, or two tables of histories or of sweeps.

    Scalar by scalar and field by field. Exit code 6 if any relative difference exceeds R. Scalars that only one file names
    are listed and do not count.
    """
    from thermoroll_cli.files.table_file import fields_node, is_table, read_table

    check_no_cases([a, b])
    if is_table(a) and is_table(b):
        one, other = (read_table(path, with_fields=True) for path in (a, b))
        with options.usage("A.h5 B.h5"):
            comparison = compare_tables(one, other, rtol, [fields_node(each.states).arrays for each in (one, other)])
    else:
        comparison = compared(read_tree(a), read_tree(b), rtol)
    if as_json:
        streams.write_json({"within": comparison.within, "rtol": rtol, "largest": comparison.largest, "notes": comparison.notes,
                            "rows": [{**vars(row), "within": row.within(rtol)} for row in comparison.rows]})
        if not comparison.within and not quiet:
            streams.error(f"{len(comparison.outside)} of {len(comparison.rows)} quantities are outside {rtol:g}")
    elif not quiet:
        # Differences above the tolerance, worst first; with `verbose` all of them, in their order.
        rows, outside, width = comparison.rows if verbose else comparison.outside, len(comparison.outside), streams.width()
        table = [("", "first", "second", "difference", "")]
        table += [(row.name, _value(row.a), _value(row.b), "–" if math.isnan(row.difference) else f"{row.difference:.1e}",
                   "; ".join(filter(None, ("outside" if verbose and not row.within(rtol) else "",
                                           "" if row.note in comparison.notes else row.note)))) for row in rows]
        verdict = f"{outside} of {len(comparison.rows)} quantities are outside" if outside else "all within"
        streams.write(*(with_remarks(table, width) if rows else ()),
                      *(line for text in comparison.notes for line in folded(f"note: {text}", width)),
                      f"{verdict} {rtol:g}; largest difference {comparison.largest:.1e}")
    raise typer.Exit(ExitCode.FINE if comparison.within else ExitCode.OUTSIDE_TOLERANCE)


def export(
    result: OneResult,
    formats: Annotated[list[ExportFormat], typer.Option("--format", help="File type. Repeatable.")],
    stress_path: Annotated[
        str | None,
        typer.Option("--stress-path", metavar="Y,Z", help="CSV: stresses along x at y = Y and depth Z, in mm."),
    ] = None,
    output: Folder = None,
    quiet: options.Quiet = False,
    verbose: options.Trace = False,
) -> None:
    """Export a result to XDMF, VTU or CSV.

    XDMF is for ParaView and points into the same HDF5 file; VTU, for programs that read VTK's files, stands by itself; CSV is
    for spreadsheets. With --stress-path the CSV file has the stresses that a material point below the surface meets instead
    (NAME_stress_path.csv). Of the table of a history or sweep, CSV has the rows.
    """
    from thermoroll_cli.files.table_file import is_table, read_table, write_csv

    check_no_cases([result])
    line = None
    if stress_path is not None:
        if "csv" not in formats:
            raise typer.BadParameter("a stress path is written as CSV: --format csv", param_hint="--stress-path")
        line = [mm / 1e3 for mm in options.numbers(stress_path, 2, "Y,Z: two numbers in mm", "--stress-path")]
    if output is not None:
        options.check_writable(output)
    stem, written = _stem(result, output), []
    table = read_table(result) if result.suffix != ".csv" and is_table(result) else None
    if table is not None and ({*formats} != {"csv"} or line is not None):
        raise typer.BadParameter(f"{result} is a table: --format csv writes its rows, and no stress path; maps of states over "
                                 "time are drawn by thermoroll plot --animate", param_hint="--format")  # fmt: skip
    for kind in dict.fromkeys(formats):
        if table is not None:
            write_csv(target := stem.with_name(f"{stem.name}.csv"), table)
            written.append(target)
        elif kind == "csv" and line is not None:
            with options.usage("--stress-path"):
                written += export_stress_path(result, stem.with_name(f"{stem.name}_stress_path.csv"), *line)
        else:
            exported = {"xdmf": export_xdmf, "vtu": export_vtu, "csv": export_csv}[kind.value]
            written += exported(result, stem.with_name(f"{stem.name}.{kind}"))
    streams.write(*map(str, written if not quiet else ()))


def check_no_cases(paths: Sequence[Path]) -> None:
    """End the program (usage) where a case is given in place of its result."""
    if case := next((path for path in paths if path.suffix == ".toml"), None):
        raise typer.BadParameter(f"{case} is a case, not a result: solve it with `thermoroll run {case}`",
                                 param_hint="RESULT.h5")  # fmt: skip


def _stem(result: Path, folder: Path | None) -> Path:
    """Path without suffix of the files made from `result`."""
    return (result.parent if folder is None else folder) / result.stem


def _value(value: float | str | None) -> str:
    if value is None or value != value:
        return "–"
    return value if isinstance(value, str) else f"{value:.8g}"
