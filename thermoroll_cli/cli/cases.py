"""`thermoroll validate`, `init` and `schema`: everything about case files that needs no solver."""

from __future__ import annotations

import difflib
import json
import re
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from thermoroll_cli.cli import options, streams
from thermoroll_cli.cli.tables import align
from thermoroll_cli.files.case import Case, CaseError
from thermoroll_cli.files.case_schema import case_schema
from thermoroll_cli.files.case_source import EXAMPLES
from thermoroll_cli.problem.kinds import kind_of
from thermoroll_cli.studies.worn.service import positions_of
from thermoroll_cli.tools.atomic import write_bytes

TEMPLATES = {
    "wheel-rail": "a wheel on a rail",
    "worn-rail": "a wheel on a measured rail profile",
    "ball-bearing": "a ball in a grooved raceway, with spin",
    "bearing": "a ball bearing with all its balls",
    "roller": "a roller with a logarithmic crown",
    "line-contact": "two spur gears, as all bodies that are long across rolling",
    "traction-drive": "two rollers near their largest force",
    "twin-disc": "two discs that turn and get hot",
    "twin-disc-wear": "two discs that wear",
    "wheelset": "both wheels of a wheelset on a track",
    "locomotive": "a wheel on a dirty rail, with falling friction",
    "article": "the article's spheres, faster than any machine",
}
"""Templates of `init`, the first by default; a new one is a file `files/templates/NAME.toml` and a line here."""
Template = StrEnum("Template", {name.replace("-", "_"): name for name in TEMPLATES})  # type: ignore[misc]
_FIRST = next(iter(Template))
_OFFERED = "\n".join((f"\b\nThe case to start from; {_FIRST} if not given:",
                      *(f"{name}: {about}" for name, about in TEMPLATES.items())))
"""Lines that are not to be broken."""
_PACKAGE = Path(__file__).parents[1]


def validate(
    cases: options.Cases,
    settings: options.Settings = None,
    as_json: options.AsJson = False,
    quiet: options.Quiet = False,
    verbose: options.Trace = False,
) -> None:
    """Check cases and report all their errors.

    Values that are allowed and yet doubtful are reported as warnings, which do not change the exit code.
    """
    options.check_standard_input(cases)
    overrides = options.parse_overrides(settings)
    errors: list[CaseError] = []
    for path in cases:
        error, warnings = None, []
        try:
            case = options.read_case(path, overrides)
            with options.solvable(case, str(path)):
                task = case.task
                warnings = list(kind_of(task).warnings(task))
                if case.settings.wear is not None and case.settings.wear.positions:
                    positions_of(case, str(path))
        except CaseError as cause:
            error = cause
            errors.append(cause)
        if as_json:
            streams.write_json(options.invalid_record(str(path), error, [] if quiet else warnings))
        elif error is None and not quiet:
            streams.write(f"{path}: valid")
            for warning in warnings:
                streams.note(f"{path}: warning: {warning}")
    if errors:
        raise typer.Exit(streams.report_invalid(errors, ""))


def _examples(incomplete: str = "") -> list[str]:
    """Names of the cases of the documents that begin like this."""
    return sorted(path.stem for path in EXAMPLES.glob("*.toml") if path.stem.startswith(incomplete))


def init(
    file: Annotated[Path | None, typer.Argument(
        metavar="[FILE]", show_default=False,
        help="Case file to write, by default case.toml, of an example cases/NAME.toml; - is standard output.")] = None,
    template: Annotated[Template | None, typer.Option("--template", metavar="NAME", help=_OFFERED, show_default=False)] = None,
    example: Annotated[str, typer.Option(
        "--example", metavar="NAME", show_default=False, autocompletion=_examples,
        help="A case of the documents, cases/NAME.toml, with the files that it reads.")] = "",
    examples: Annotated[bool, typer.Option("--examples", help="List the cases of the documents, with their titles.")] = False,
    force: Annotated[bool, typer.Option("--force", help="Overwrite an existing file.")] = False,
    quiet: options.Quiet = False,
    verbose: options.Trace = False,
) -> None:
    """Write a case with comments, to be edited."""
    names = _examples()
    if template and example:
        raise typer.BadParameter("--template is another case to start from", param_hint="--example")
    if examples and (file or template or example):
        raise typer.BadParameter("lists cases, and writes none", param_hint="--examples")
    if examples:
        titles = (Case.read(EXAMPLES / f"{name}.toml").settings.title for name in names)
        streams.write(*align([*zip(names, titles, strict=True)]))
        return
    if example and example not in names:
        near = difflib.get_close_matches(example, names, 1)
        advice = f"did you mean {near[0]}?" if near else "--examples lists them"
        raise typer.BadParameter(f"no case is called {example}; {advice}", param_hint="--example")
    text = (EXAMPLES / f"{example}.toml").read_text(encoding="utf-8") if example else template_text((template or _FIRST).value)
    file = file or Path(f"cases/{example}.toml" if example else "case.toml")
    if str(file) == "-":
        streams.write(text.rstrip("\n"))
        return
    if file.is_dir():
        raise IsADirectoryError(f"{file} is a folder; give the name of the case file, such as {file / 'case.toml'}")
    contents = {file: text.encode()}
    if example:
        named = sorted({*re.findall(r'"([\w.-]+)"', text)} & {path.name for path in EXAMPLES.iterdir()})
        contents |= {file.parent / name: (EXAMPLES / name).read_bytes() for name in named}
        if file.parent == Path("cases"):
            file.parent.mkdir(exist_ok=True)
    # Examples share files: one that is the same already is no loss.
    if there := next((path for path, new in contents.items() if path.exists() and not force
                      and (path == file or path.read_bytes() != new)), None):
        raise FileExistsError(f"{there} exists; --force overwrites it")
    for path, content in contents.items():
        write_bytes(path, content)
    if not quiet:
        streams.note(f"wrote {', '.join(map(str, contents))}; try: thermoroll run {file}")


def template_text(name: str) -> str:
    """The template `name` as the text of a case file."""
    return (_PACKAGE / "files" / "templates" / f"{name}.toml").read_text(encoding="utf-8")


def schema() -> None:
    """Print the JSON schema of case files."""
    streams.write(json.dumps(case_schema(), indent=2, ensure_ascii=True, allow_nan=False))
