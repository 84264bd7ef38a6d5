"""The ending of every command that computes: files, pictures and page, what is printed, and the exit code."""

from __future__ import annotations

import glob
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from thermoroll_cli.cli import options, streams
from thermoroll_cli.cli.streams import ExitCode
from thermoroll_cli.cli.tables import folded

if TYPE_CHECKING:
    from thermoroll_cli.cli.report import Section

FEW = 3
"""Files of one type that are listed by name."""


class NoPicture(Exception):
    """Why something is not drawn."""


class Ending(NamedTuple):
    """What a user asks of the ending of a command."""

    folder: Path
    as_json: bool = False
    plots: str = "all"
    formats: Sequence[options.ImageFormat] | None = None
    dpi: float | None = None
    report: bool = False
    quiet: bool = False

    def drawn(self, stem: str, draw: Callable[[Path], Path | str]) -> list[Path]:
        """One picture in the file types that are asked for, each of which `draw` writes. Raises NoPicture where it returns a
        text that says why it does not."""
        targets = [self.folder / f"{stem}.{ending}" for ending in options.image_formats(self.formats)]
        for target in targets:
            if isinstance(why_not := draw(target), str) and why_not:
                raise NoPicture(why_not)
        return targets


def deliver(
    to: Ending, name: str, stem: str, *, write: Callable[[], Iterable[Path]], record: Mapping[str, Any] | None,
    lines: Callable[[], Iterable[str]], draw: Callable[[], Iterable[Path]] | None = None,
    section: Callable[[], Section] | None = None,
    reason: str = "", warnings: Sequence[str] = (), drawable: Callable[[], Iterable[str]] | None = None, also: str = "",
) -> ExitCode:
    """End a command with what it has found for the case `name`, and return its exit code. Files of it begin with `stem`.

    `write` writes its files, `draw` its pictures (NoPicture says why there is one less), `section` makes its page; `drawable`
    has the names of all pictures that it may write, `stem` alone if not given. `record` is printed with `--json` (None: it has
    been), `lines` without, and what was written `also` behind the files. What goes wrong as files are written does not keep it
    from printing.
    """
    code, files, pictures = ExitCode.NOT_CONVERGED if reason else ExitCode.FINE, list[Path](), list[Path]()
    pages, missing = list[Path](), list[str]()
    try:
        files += write()
        try:
            pictures += draw() if draw is not None and to.plots != "none" else ()
        except NoPicture as cause:
            missing.append(f"  no picture: {cause}")
        if to.report and section is not None:
            from thermoroll_cli.cli import report as page

            pages.append(page.write(to.folder / f"{stem}_report.html", [section()]))
    except OSError as cause:
        streams.error(f"{name}: {cause}")
        code = ExitCode.INPUT_OUTPUT
    # Without files that are called like pictures matplotlib is not imported for their names.
    if files and not to.quiet and (drawable is None or any(to.folder.glob(f"{glob.escape(stem)}_*.*"))):
        known = (to.folder / f"{each}.{ending}" for each in (drawable or (lambda: (stem,)))() for ending in options.ImageFormat)
        options.report_stale(known, pictures)
    if to.as_json and record is not None:
        streams.write_json({"name": name, **record, "files": [*files, *pictures, *pages]})
    elif not (to.as_json or to.quiet):
        width = streams.width()
        said = [line for warning in warnings for line in folded(f"warning: {warning}", width)]
        streams.write(*lines(), *missing, *streams.in_colour(said, streams.YELLOW),
                      *streams.in_colour(folded(reason, width) if reason else [], streams.RED))
        written, shown = [*files, *pages, *pictures], list[str]()
        for ending in dict.fromkeys(path.suffix for path in written):
            same = [path for path in written if path.suffix == ending]
            kind = "pictures" if same[0] in pictures else "files"
            shown += map(str, same) if len(same) <= FEW else [f"{len(same)} {kind} {to.folder / stem}_*{ending}"]
        if shown:
            streams.write(f"  wrote {', '.join(shown)}{also}")
    if to.as_json or to.quiet:
        for warning in warnings if to.as_json and not to.quiet else ():
            streams.note(f"thermoroll: {name}: warning: {warning}")
        if reason:
            streams.note(f"thermoroll: {name} did not converge: {reason}")
    return code
