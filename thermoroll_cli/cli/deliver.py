"""The ending of every command that computes: files, pictures and page of what it found, what is printed, and the exit code."""

from __future__ import annotations

from abc import ABC, abstractmethod
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


class Outcome(ABC):
    """What a command has found for the case `name`. The names of its files begin with `stem`.

    - `reason`: why it did not converge, "" if it did;
    - `warnings`: doubts about it;
    - `also`: what was written besides the files of `write`, in words."""

    name: str
    stem: str
    reason: str = ""
    warnings: Sequence[str] = ()
    also: str = ""

    @abstractmethod
    def write(self, folder: Path) -> Iterable[Path]:
        """Write its files, and return their paths. Raises OSError."""

    @abstractmethod
    def record(self) -> Mapping[str, Any] | None:
        """What `--json` prints of it; None if that has been printed."""

    @abstractmethod
    def lines(self) -> Iterable[str]:
        """What is printed of it without `--json`."""

    def draw(self, to: Ending) -> Iterable[Path]:
        """Write its pictures, and return their paths. Raises OSError, and NoPicture, which says why there is one less."""
        return ()

    def pictures(self, folder: Path) -> Iterable[str]:
        """The names without ending of all pictures that it may write into `folder`."""
        return (self.stem,)

    def section(self, folder: Path) -> Section | None:
        """What a report says of it, once its files are in `folder`; None if there is no report of it."""
        return None


def deliver(found: Outcome, to: Ending) -> ExitCode:
    """End a command with what it has found, as the user asks, and return its exit code. What goes wrong as files are written
    does not keep it from printing."""
    code, files, pictures = ExitCode.NOT_CONVERGED if found.reason else ExitCode.FINE, list[Path](), list[Path]()
    pages, missing = list[Path](), list[str]()
    try:
        files += found.write(to.folder)
        try:
            pictures += found.draw(to) if to.plots != "none" else ()
        except NoPicture as cause:
            missing.append(f"  no picture: {cause}")
        if to.report and (section := found.section(to.folder)) is not None:
            from thermoroll_cli.cli import report as page

            pages.append(page.write(to.folder / f"{found.stem}_report.html", [section]))
    except OSError as cause:
        streams.error(f"{found.name}: {cause}")
        code = ExitCode.INPUT_OUTPUT
    if files and not to.quiet:
        known = (to.folder / f"{each}.{ending}" for each in found.pictures(to.folder) for ending in options.ImageFormat)
        options.report_stale(known, pictures)
    if not to.as_json and not to.quiet:
        _print(found, to, missing, [*files, *pages, *pictures], pictures)
    elif to.as_json and (record := found.record()) is not None:
        streams.write_json({"name": found.name, **record, "files": [*files, *pictures, *pages]})
    if to.as_json or to.quiet:
        for warning in found.warnings if to.as_json and not to.quiet else ():
            streams.note(f"thermoroll: {found.name}: warning: {warning}")
        if found.reason:
            streams.note(f"thermoroll: {found.name} did not converge: {found.reason}")
    return code


def _print(found: Outcome, to: Ending, missing: Sequence[str], written: Sequence[Path], pictures: Sequence[Path]) -> None:
    """Print what was found, its warnings and reason, and which files and `pictures` were `written`."""
    width = streams.width()
    warned = [line for warning in found.warnings for line in folded(f"warning: {warning}", width)]
    streams.write(*found.lines(), *missing, *streams.in_colour(warned, streams.YELLOW),
                  *streams.in_colour(folded(found.reason, width) if found.reason else [], streams.RED))
    shown = list[str]()
    for ending in dict.fromkeys(path.suffix for path in written):
        same = [path for path in written if path.suffix == ending]
        kind = "pictures" if same[0] in pictures else "files"
        shown += map(str, same) if len(same) <= FEW else [f"{len(same)} {kind} {to.folder / found.stem}_*{ending}"]
    if shown:
        streams.write(f"  wrote {', '.join(shown)}{found.also}")
