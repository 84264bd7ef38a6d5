"""Errors of a case file as a good compiler reports them, and the places of keys in a TOML text (tomllib keeps none)."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from rich.cells import cell_len

KeyPath = tuple[str | int, ...]
Fault = tuple[KeyPath, str, str]
"""Path of a key, what is wrong with it, what is allowed."""

_STRING = r""""(?:\\.|[^"\\])*"|'[^']*'"""
_PART = re.compile(rf"[A-Za-z0-9_-]+|{_STRING}")
_DOTTED = rf"(?:[A-Za-z0-9_-]+|{_STRING})(?:[ \t]*\.[ \t]*(?:[A-Za-z0-9_-]+|{_STRING}))*"
_HEADER = re.compile(rf"[ \t]*(\[\[?[ \t]*({_DOTTED})[ \t]*\]\]?)[ \t]*(?:#.*)?$")
_ASSIGNMENT = re.compile(rf"[ \t]*({_DOTTED})[ \t]*=[ \t]*")
_INLINE_KEY = re.compile(rf"[{{,][ \t]*({_DOTTED})[ \t]*=[ \t]*({_STRING}|[^,}}]*)")
_VALUE = re.compile(rf"(?:{_STRING}|[^#])*")


@dataclass(frozen=True, order=True)
class Span:
    """Characters on one line; line and column count from 1."""

    line: int
    column: int
    length: int


class Place(NamedTuple):
    """The place of a key, and of its value (as far as it stands on the same line). A table has its header in both."""

    key: Span
    value: Span


class Places:
    """The places of the keys of a TOML text: `found`, by path, in which a number counts the tables `[[name]]` from 0.

    Text is searched line by line for `key =` below its `[header]`; keys that it cannot follow have no place. `duplicate` is the
    path of the first key or table that stands there twice, with its first and second place.
    """

    def __init__(self, text: str) -> None:
        self.found: dict[KeyPath, Place] = {}
        self.duplicate: tuple[KeyPath, Span, Span] | None = None
        self._written: dict[KeyPath, Span] = {}
        count: dict[KeyPath, int] = {}
        prefix: KeyPath = ()
        brackets, quotes = 0, ""
        for number, line in enumerate(text.split("\n"), 1):
            if quotes:  # within a text of several lines
                quotes = "" if quotes in line else quotes
            elif brackets:  # within a list of several lines
                brackets += _open_brackets(line)
            elif header := _HEADER.match(line):
                # With the number of the latest table wherever it leads through a list of tables.
                parts, prefix = _parts(header[2]), ()
                for depth, part in enumerate(parts, 1):
                    prefix = (*prefix, part)
                    if header[1].startswith("[[") and depth == len(parts):
                        count[prefix] = count.get(prefix, 0) + 1
                    if prefix in count:
                        prefix = (*prefix, count[prefix] - 1)
                span = Span(number, header.start(1) + 1, len(header[1]))
                self._record(prefix, Place(span, span))
            elif key := _ASSIGNMENT.match(line):
                path, value = (*prefix, *_parts(key[1])), line[key.end():]
                quotes = next((q for q in ('"""', "'''") if value.startswith(q) and q not in value[3:]), "")
                brackets = 0 if quotes else _open_brackets(value)
                shown = value if quotes else _VALUE.match(value)[0].rstrip()  # type: ignore[index]  # it matches anything
                self._record(path, Place(_span(number, key, 1), Span(number, key.end() + 1, max(len(shown), 1))))
                for inner in _INLINE_KEY.finditer(shown) if shown.startswith("{") else ():
                    place = Place(_span(number, inner, 1, key.end()), _span(number, inner, 2, key.end()))
                    self._record((*path, *_parts(inner[1])), place)

    def _record(self, path: KeyPath, place: Place) -> None:
        first = self._written.setdefault(path, place.key)
        if first is not place.key and self.duplicate is None:
            self.duplicate = path, first, place.key
        for depth in range(1, len(path)):
            # A table that has no header (`a.b = 1`) stands at its first key.
            self.found.setdefault(path[:depth], Place(place.key, place.key))
        self.found[path] = place


def _parts(dotted: str) -> KeyPath:
    return tuple(part[1:-1] if part[0] in "'\"" else part for part in _PART.findall(dotted))


def _open_brackets(text: str) -> int:
    plain = re.sub(_STRING, "", text).partition("#")[0]
    return sum((character in "[{") - (character in "]}") for character in plain)


def _span(line: int, match: re.Match[str], group: int, before: int = 0) -> Span:
    return Span(line, before + match.start(group) + 1, max(len(match[group].rstrip()), 1))


@dataclass(frozen=True)
class Finding:
    """One error: its place, the key and value, the allowed values, and a hint.

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

    @property
    def headline(self) -> str:
        """Key, value and message."""
        subject = " = ".join(part for part in (self.key, self.value) if part)
        return f"{subject}: {self.message}" if subject else self.message

    def render(self, colour: bool = False) -> str:
        """The finding as text: a headline `file:line:column: error: …`, the line with a caret, and what is allowed."""
        bold, red, blue, plain = ("\x1b[1m", "\x1b[1;31m", "\x1b[34m", "\x1b[0m") if colour else ("", "", "", "")
        place = self.source if self.span is None else f"{self.source}:{self.span.line}:{self.span.column}"
        lines = [f"{bold}{printable(place)}: {red}error:{plain} {bold}{printable(self.headline)}{plain}"]
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
        words = {name: getattr(self, name) for name in ("key", "value", "message", "allowed", "hint")}
        line, column = (self.span.line, self.span.column) if self.span else (None, None)
        return {"file": self.source, "line": line, "column": column, **words}


class CaseError(Exception):
    """A case cannot be used.

    Attributes:

    - `findings`: every error, in the order of the file, each with `message`, `key`, `value`, `allowed` and `hint`, and with its
      `span` in the file if that is known. The text of the exception shows all of them.
    """

    def __init__(self, findings: Sequence[Finding]) -> None:
        self.findings = tuple(sorted(findings, key=lambda each: (each.span is None, each.span)))
        super().__init__("\n".join(finding.render() for finding in self.findings))


def printable(text: str, also: str = "") -> str:
    """`text` without control characters but for those in `also`: what came from outside must not be able to steer the
    terminal."""
    if text.isprintable():
        return text
    return "".join(character if character.isprintable() or character in also else "\N{REPLACEMENT CHARACTER}"
                   for character in text)


def shortened(text: str) -> str:
    """`text` as an error quotes it, in at most 40 characters."""
    return text if len(text) <= 40 else text[:39] + "…"


def _clip(line: str, span: Span) -> tuple[str, int, int]:
    """The part of `line` around `span` that fits a terminal, the width in front of the span, and of the span."""
    start = span.column - 1
    width = 100
    first = max(0, start - width // 2) if len(line) > width else 0
    # A tab is shown as one space, so that the caret below stands where it should on any terminal.
    shown = printable(line.replace("\t", " ")[first : first + width])
    marked = shown[start - first : start - first + span.length]
    text = ("…" if first else "") + shown + ("…" if first + width < len(line) else "")
    return text.rstrip(), cell_len(shown[: start - first]) + bool(first), max(1, cell_len(marked))


_SLIPS = {
    r"=\s*[-+]?\d+,\d": "a decimal number is written with a point: 0.5",
    r"=\s*(True|False|TRUE|FALSE|yes|no|on|off)\b": "TOML writes true and false, in small letters",
    r"=\s*[-+]?(Inf|INF|Infinity|infinity|∞)": "TOML writes infinity as inf, without quotes",
    r"=\s*(NaN|NAN)": "nan is not an allowed value",
    r"=\s*[-+]?\.\d": "a number needs a digit before the point: 0.5",
    r"=\s*[-+]?\d+\.(?!\d)": "a number needs a digit after the point: 1.0",
    r"=\s*[A-Za-z]": "text is written in quotes",
    r"=\s*(#.*)?$": "a value is missing after the =",
    r"=\s*[-+]?[\d.eE+-]+\s*[A-Za-z%°µ]": "a value has no unit behind it: the unit is part of the key",
    r"^\s*\w+\s*:": "TOML writes key = value",
    r"^\s*\[[^]]*$": "a table header ends with ]",
}
"""Lines that are not TOML → hint."""


def syntax_error(name: str, text: str, message: str) -> Finding:
    """The error of a `text` that tomllib refuses with `message`."""
    lines = text.split("\n")
    if message.startswith(("Cannot overwrite", "Cannot declare", "Cannot mutate", "Duplicate")):
        again = Places(text).duplicate
        if again is not None:
            path, first, second = again
            line_text = lines[second.line - 1]
            table = line_text.lstrip().startswith("[")
            message = f"{'this table' if table else 'this key'} is there twice, first in line {first.line}"
            hint = "put the keys of both into one table" if table else "keep one of them"
            return Finding(message, ".".join(map(str, path)), hint=hint, source=name, span=second, line_text=line_text)
    place = re.search(r" \(at line (\d+), column (\d+)\)$", message)
    if place:
        line, column = int(place[1]), int(place[2])
        message = message[: place.start()]
    else:  # "(at end of document)"
        message = message.removesuffix(" (at end of document)") + " at the end of the file"
        line = len(lines) - 1 if len(lines) > 1 and not lines[-1] else len(lines)
        column = len(lines[line - 1]) + 1
    line_text = lines[line - 1] if line <= len(lines) else ""
    hint = next((hint for pattern, hint in _SLIPS.items() if re.search(pattern, line_text)), "")
    return Finding(f"broken TOML: {message}", hint=hint, source=name, span=Span(line, column, 1), line_text=line_text)
