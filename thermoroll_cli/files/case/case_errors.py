"""What is wrong with a case, told the way a good compiler tells it."""

from __future__ import annotations

import unicodedata
from collections.abc import Sequence
from dataclasses import dataclass

from thermoroll_cli.files.case.toml_positions import Span

_SNIPPET_WIDTH = 100


@dataclass(frozen=True)
class Finding:
    """One error: where it is, which key and value, what is allowed, what would help.

    `source` names the file (or `--set`), `span` the place in it (None: nowhere in particular), `line_text` the whole
    line the span lies on.
    """

    message: str
    key: str = ""
    value: str = ""
    allowed: str = ""
    hint: str = ""
    source: str = ""
    span: Span | None = None
    line_text: str = ""

    def render(self, colour: bool = False) -> str:
        """The finding as text: a headline `file:line:column: error: …`, the line with a caret, and what is allowed."""
        bold, red, blue, plain = ("\x1b[1m", "\x1b[1;31m", "\x1b[34m", "\x1b[0m") if colour else ("", "", "", "")
        place = self.source if self.span is None else f"{self.source}:{self.span.line}:{self.span.column}"
        subject = " = ".join(part for part in (self.key, self.value) if part)
        headline = f"{subject}: {self.message}" if subject else self.message
        lines = [f"{bold}{printable(place)}: {red}error:{plain} {bold}{printable(headline)}{plain}"]
        if self.span is not None:
            number = str(self.span.line)
            text, before, marked = _clip(self.line_text, self.span)
            margin = " " * len(number)
            lines.append(f"  {blue}{number} |{plain} {text}")
            lines.append(f"  {blue}{margin} |{plain} {' ' * before}{red}{'^' * marked}{plain}")
        if self.allowed:
            lines.append(f"  allowed: {printable(self.allowed)}")
        if self.hint:
            lines.append(f"  help: {printable(self.hint)}")
        return "\n".join(lines)

    def record(self) -> dict[str, str | int | None]:
        """The finding as plain JSON types, for editors and scripts."""
        return {
            "file": self.source,
            "line": self.span.line if self.span else None,
            "column": self.span.column if self.span else None,
            "key": self.key,
            "value": self.value,
            "message": self.message,
            "allowed": self.allowed,
            "hint": self.hint,
        }


class CaseError(Exception):
    """A case cannot be used. `findings` has every error found, in the order of the file."""

    def __init__(self, findings: Sequence[Finding]) -> None:
        self.findings = tuple(sorted(findings, key=_place))
        super().__init__("\n".join(finding.render() for finding in self.findings))


def printable(text: str) -> str:
    """`text` without control characters: a case file must not be able to steer the terminal."""
    return "".join(character if character.isprintable() else "\N{REPLACEMENT CHARACTER}" for character in text)


def _place(finding: Finding) -> tuple[bool, int, int]:
    span = finding.span
    return (span is None, span.line, span.column) if span else (True, 0, 0)


def _clip(line: str, span: Span) -> tuple[str, int, int]:
    """The part of `line` around `span` that fits a terminal, the width in front of the span, and of the span."""
    start = span.column - 1
    first = max(0, start - _SNIPPET_WIDTH // 2) if len(line) > _SNIPPET_WIDTH else 0
    # A tab is shown as one space, so that the caret below stands where it should on any terminal.
    shown = printable(line.replace("\t", " ")[first : first + _SNIPPET_WIDTH])
    marked = shown[start - first : start - first + span.length]
    text = ("…" if first else "") + shown + ("…" if first + _SNIPPET_WIDTH < len(line) else "")
    return text.rstrip(), _width(shown[: start - first]) + bool(first), max(1, _width(marked))


def _width(text: str) -> int:
    """Columns `text` takes on a terminal: East Asian wide characters take two, combining ones none."""

    return sum(
        0 if unicodedata.combining(character) else 2 if unicodedata.east_asian_width(character) in "WF" else 1
        for character in text
    )
