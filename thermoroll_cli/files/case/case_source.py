"""The text of a case and what overrides it, before anything is checked."""

from __future__ import annotations

import copy
import difflib
import os
import re
import sys
import tomllib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

from thermoroll_cli.files.case.case_errors import CaseError, Finding
from thermoroll_cli.files.case.case_hints import broken_syntax
from thermoroll_cli.files.case.toml_positions import Duplicate, Entry, KeyPath, Span, find_duplicate, locate_keys
from thermoroll_cli.interruption import waiting

SIZE_LIMIT = 1 << 16
"""Bytes a case file may have. Real ones have a thousand or two; anything larger is some other file given by mistake."""

STANDARD_INPUT = "-"

_HDF5_SIGNATURE = b"\x89HDF\r\n\x1a\n"
_LOOSE_NUMBER = re.compile(r"[-+]?(?:(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?|(?i:inf(?:inity)?))")
# tomllib takes quadratic time over a key of many parts.
_ENDLESS_KEY = re.compile(r"(?<![\w-])(?:[\w-]++[ \t]*+\.[ \t]*+){33}")
_SHOWN_VALUE_LENGTH = 40

# One of these replaces the other: a case that says `grid` can be run with `--set numerics.accuracy=1e-3`.
_RIVALS: tuple[tuple[KeyPath, KeyPath], ...] = (
    (("numerics", "grid"), ("numerics", "accuracy")),
    (("creepage", "longitudinal"), ("force", "longitudinal_N")),
    (("creepage", "lateral"), ("force", "lateral_N")),
    *((("geometry", f"{body}_radius_y_mm"), ("geometry", f"{body}_profile")) for body in ("lower", "upper")),
    *((("geometry", f"{body}_profile", key), ("geometry", f"{body}_profile", rival)) for body in ("lower", "upper")
      for key, rival in (("points_mm", "file"), ("points_mm", "kind"), ("file", "kind"))),
    *((("thermal", body, "convection_W_m2K"), ("thermal", body, "thermal_resistance_K_W")) for body in ("lower", "upper")),
)


@dataclass(frozen=True)
class Override:
    """A key given beside the case file: `text` is how it was written there, `origin` what errors call that place."""

    path: KeyPath
    value: Any
    text: str
    origin: str = "--set"

    @property
    def place(self) -> str:
        return f"{self.origin} {self.text}"

    @classmethod
    def parse(cls, text: str) -> Override:
        """`key=value` with a dotted key and a TOML value; what is not a TOML value is taken as text.

        Raises ValueError if there is no key or no `=`.
        """
        key, equals, written = text.partition("=")
        if not equals or not key.strip():
            raise ValueError(f'"{text}" is not of the form key=value, for example load.normal_N=80')
        path = tuple(part.strip() for part in key.split("."))
        if not all(path):
            raise ValueError(f'"{text}": a key has the form table.key, for example load.normal_N=80')
        return cls(path, _toml_value(written.strip()), text)


@dataclass(frozen=True)
class CaseSource:
    """A parsed case text with its overrides applied to `content`; knows where every key was written where the
    content is that of the text (`located`)."""

    name: str
    text: str
    content: dict[str, Any]
    overrides: tuple[Override, ...] = ()
    located: bool = True

    def finding(self, path: KeyPath, message: str, *, allowed: str = "", hint: str = "", at_key: bool = False) -> Finding:
        """An error about `path`, placed at its value (or its key), or at the nearest table around it."""
        key = ".".join(str(part) for part in path)
        # What was set last counts; a table is meant by what was set in it only if the text does not have it.
        within = [item for item in reversed(self.overrides) if item.path[: len(path)] == path]
        override = next((item for item in within if item.path == path or path not in self.entries), None)
        if override is not None:
            value = _shorten(override.text.partition("=")[2].strip()) if override.path == path and not at_key else ""
            return Finding(message, key, value, allowed, hint, source=override.place)
        known = next((path[:depth] for depth in range(len(path), 0, -1) if path[:depth] in self.entries), None)
        if known is None:
            return Finding(message, key, "", allowed, hint, source=self.name)
        entry = self.entries[known]
        exact = known == path and entry.value != entry.key
        span = entry.value if exact and not at_key else entry.key
        line_text = self._lines[span.line - 1]
        value = _shorten(line_text[span.column - 1 :][: span.length]) if exact and not at_key else ""
        return Finding(message, key, value, allowed, hint, self.name, span, line_text)

    def overridden(self, overrides: Sequence[Override]) -> CaseSource:
        """The same text with `overrides` applied besides those it has; cheaper than parsing it again. Raises CaseError."""
        content = copy.deepcopy(self.content)
        apply_overrides(content, overrides)
        return replace(self, content=content, overrides=(*self.overrides, *overrides))

    def line_of(self, path: KeyPath) -> str:
        """` (line 12)` for a key of the text, nothing for one that is not in it."""
        return f" (line {self.entries[path].key.line})" if path in self.entries else ""

    @cached_property
    def entries(self) -> dict[KeyPath, Entry]:
        """Where each key stands, looked up when the first error asks."""

        return locate_keys(self.text) if self.located else {}

    @cached_property
    def _lines(self) -> list[str]:
        return self.text.split("\n")


def read_source(path: str | os.PathLike[str], overrides: Sequence[Override] = ()) -> CaseSource:
    """Read the case file at `path`, `-` for standard input. Raises CaseError if it cannot be read or is not TOML."""
    name = os.fspath(path)
    if name == STANDARD_INPUT:
        name = "<stdin>"
    return parse_source(_decode(name, _read_bytes(path, name)), name, overrides)


def parse_source(text: str, name: str, overrides: Sequence[Override] = ()) -> CaseSource:
    """Parse `text` and apply `overrides`. Raises CaseError if it is not TOML."""
    text = text.replace("\r\n", "\n")
    try:
        if _ENDLESS_KEY.search(text):
            raise ValueError
        content = tomllib.loads(text)
    except tomllib.TOMLDecodeError as cause:
        raise CaseError([_syntax_error(name, text, str(cause))]) from None
    except (RecursionError, ValueError):
        # ValueErrors of another kind: an integer of thousands of digits, and the endless key.
        message = "not a case: nested too deeply, or numbers too long"
        raise CaseError([Finding(message, source=name)]) from None
    if not content and not overrides:
        raise CaseError([Finding("there is nothing in it", source=name, hint="thermoroll init writes a case to start from")])
    source = CaseSource(name, text, content, tuple(overrides))
    apply_overrides(content, overrides)
    return source


def apply_overrides(content: dict[str, Any], overrides: Iterable[Override]) -> None:
    """Set the keys of `overrides` in `content`; of two keys that exclude each other the overriding one stays.

    Raises CaseError for a key inside something that is no table.
    """
    given = {item.path for item in overrides}
    for override in overrides:
        for mine, rival in (*_RIVALS, *((b, a) for a, b in _RIVALS)):
            # A table is given by any key in it.
            if override.path[: len(mine)] == mine and not any(path[: len(rival)] == rival for path in given):
                rival_table: Any = content
                for part in rival[:-1]:
                    rival_table = rival_table.get(part) if isinstance(rival_table, dict) else None
                if isinstance(rival_table, dict):
                    rival_table.pop(rival[-1], None)
        table: Any = content
        for part in override.path[:-1]:
            table = table.setdefault(part, {})
            if not isinstance(table, dict):
                finding = Finding(f"{part} is a value, not a table", source=override.place)
                raise CaseError([finding])
        table[override.path[-1]] = override.value


def _read_bytes(path: str | os.PathLike[str], name: str) -> bytes:
    try:
        if os.fspath(path) == STANDARD_INPUT:
            if sys.stdin is None:
                raise CaseError([Finding("standard input is closed", source=name)])
            with waiting():
                raw = sys.stdin.buffer.read(SIZE_LIMIT + 1)
        else:
            with waiting(), open(path, "rb") as stream:  # it may be a pipe
                # One byte more than allowed tells a large file, and an endless one, without reading it.
                raw = stream.read(SIZE_LIMIT + 1)
    except FileNotFoundError:
        raise CaseError([Finding("no such file", source=name, hint=_similar_file(name))]) from None
    except IsADirectoryError:
        raise CaseError([Finding("this is a folder, not a case file", source=name)]) from None
    except (OSError, ValueError) as cause:  # ValueError: a NUL in the name
        reason = getattr(cause, "strerror", None) or str(cause)
        raise CaseError([Finding(f"cannot be read: {reason}", source=name)]) from None
    if raw.startswith(_HDF5_SIGNATURE):
        hint = "thermoroll plot, export and compare read result files; thermoroll run --from solves one again"
        raise CaseError([Finding("this is an HDF5 file, not a case file", source=name, hint=hint)])
    if len(raw) > SIZE_LIMIT:
        message = f"too large for a case file, which has at most {SIZE_LIMIT // 1024} KiB"
        raise CaseError([Finding(message, source=name)])
    return raw


def _decode(name: str, raw: bytes) -> str:
    try:
        return raw.decode("utf-8-sig")  # some editors put a mark in front
    except UnicodeDecodeError as cause:

        before = raw[: cause.start]
        line = before.count(b"\n") + 1
        line_start = before.rfind(b"\n") + 1
        column = len(raw[line_start : cause.start].decode("utf-8-sig")) + 1
        line_text = raw[line_start:].split(b"\n", 1)[0].decode("utf-8", "replace")
        message = f"not UTF-8 text: byte 0x{raw[cause.start]:02x}"
        hint = "save the file with the encoding UTF-8"
        finding = Finding(message, hint=hint, source=name, span=Span(line, column, 1), line_text=line_text)
        raise CaseError([finding]) from None


def _syntax_error(name: str, text: str, message: str) -> Finding:

    lines = text.split("\n")
    if message.startswith(("Cannot overwrite", "Cannot declare", "Cannot mutate", "Duplicate")):
        again = find_duplicate(text)
        if again is not None:
            return _given_twice(name, again, lines)
    place = re.search(r" \(at line (\d+), column (\d+)\)$", message)
    if place:
        line, column = int(place[1]), int(place[2])
        message = message[: place.start()]
    else:  # "(at end of document)"
        message = message.removesuffix(" (at end of document)") + " at the end of the file"
        line = len(lines) - 1 if len(lines) > 1 and not lines[-1] else len(lines)
        column = len(lines[line - 1]) + 1
    line_text = lines[line - 1] if line <= len(lines) else ""
    span = Span(line, column, 1)
    return Finding(f"broken TOML: {message}", hint=broken_syntax(line_text), source=name, span=span, line_text=line_text)


def _given_twice(name: str, again: Duplicate, lines: Sequence[str]) -> Finding:
    key, line_text = ".".join(str(part) for part in again.path), lines[again.second.line - 1]
    table = line_text.lstrip().startswith("[")
    message = f"{'this table' if table else 'this key'} is there twice, first in line {again.first.line}"
    hint = "put the keys of both into one table" if table else "keep one of them"
    return Finding(message, key, hint=hint, source=name, span=again.second, line_text=line_text)


def _similar_file(name: str) -> str:

    folder, base = os.path.split(name)
    try:
        files = [entry for entry in os.listdir(folder or ".") if entry.endswith(".toml")]
    except (OSError, ValueError):
        return ""
    # Of the names alone: the ending that all have in common would make any two of them similar.
    stems = {os.path.splitext(file)[0]: file for file in files}
    near = difflib.get_close_matches(os.path.splitext(base)[0], stems, n=1)
    return f"did you mean {os.path.join(folder, stems[near[0]])}?" if near else ""


def _toml_value(text: str) -> Any:
    try:
        parsed = tomllib.loads(f"value = {text}")
        if set(parsed) == {"value"}:
            return parsed["value"]
    except (tomllib.TOMLDecodeError, RecursionError, ValueError):
        pass
    # Shells and scripts print numbers that TOML does not know, such as .5 and INF
    return float(text) if _LOOSE_NUMBER.fullmatch(text) else text


def _shorten(text: str) -> str:
    return text if len(text) <= _SHOWN_VALUE_LENGTH else text[: _SHOWN_VALUE_LENGTH - 1] + "…"
