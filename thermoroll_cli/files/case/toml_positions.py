"""Where each key of a TOML text stands, so that an error can point at it (tomllib keeps no positions)."""

from __future__ import annotations

import bisect
import re
import tomllib
from dataclasses import dataclass
from functools import lru_cache

KeyPath = tuple[str | int, ...]

_BLANK = re.compile(r"[ \t]*")
_BLANK_OR_COMMENT = re.compile(r"(?:[ \t\n]|#[^\n]*)*")
_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")
_SCALAR = re.compile(r"[^,\]}\n#]+")
_STRING = re.compile(
    r'"""(?:\\.|[^\\])*?"""(?:"{0,2})'
    r"|'''.*?'''(?:'{0,2})"
    r'|"(?:\\.|[^"\\\n])*"'
    r"|'[^'\n]*'",
    re.DOTALL,
)


@dataclass(frozen=True)
class Span:
    """A stretch of characters on one line; line and column count from 1."""

    line: int
    column: int
    length: int


@dataclass(frozen=True)
class Entry:
    """Where a key stands, and its value. A table has its header in both."""

    key: Span
    value: Span


@lru_cache(maxsize=4)
def locate_keys(text: str) -> dict[KeyPath, Entry]:
    """Map every key path of `text` (valid TOML with \\n line ends) to its place.

    A table that is never named on its own (`a.b = 1`) stands where its first key does. Positions serve messages
    only: text this scanner cannot follow leaves keys without a place and raises nothing.
    """
    scanner = _Scanner(text)
    try:
        scanner.document()
    except (_Lost, IndexError, RecursionError, ValueError):
        pass
    return scanner.entries


@dataclass(frozen=True)
class Duplicate:
    """A key or table that a text has twice: its path, and where it stands the first and the second time."""

    path: KeyPath
    first: Span
    second: Span


def find_duplicate(text: str) -> Duplicate | None:
    """The first key or table that `text`, otherwise valid TOML, has a second time; None if there is none to be found."""
    scanner = _Scanner(text)
    try:
        scanner.document()
    except (_Lost, IndexError, RecursionError, ValueError):
        pass
    return scanner.duplicate


class _Lost(Exception):
    """The scanner met something that is not TOML as it knows it."""


class _Scanner:
    def __init__(self, text: str) -> None:
        self.text = text
        self.position = 0
        self.entries: dict[KeyPath, Entry] = {}
        self.duplicate: Duplicate | None = None
        self._written: dict[KeyPath, Span] = {}
        self._line_starts = [0, *(match.end() for match in re.finditer("\n", text))]

    def document(self) -> None:
        prefix: KeyPath = ()
        tables_seen: dict[KeyPath, int] = {}
        while True:
            self._skip(_BLANK_OR_COMMENT)
            if self.position >= len(self.text):
                return
            if self.text[self.position] != "[":
                self._key_and_value(prefix)
                continue
            start = self.position
            many = self.text.startswith("[[", start)
            self.position += 2 if many else 1
            prefix = _within_latest(self._dotted_key(), tables_seen, many)
            self.position += 2 if many else 1
            if many:
                index = tables_seen.get(prefix, 0)
                tables_seen[prefix] = index + 1
                prefix = (*prefix, index)
            header = self._span(start, self.position)
            self._once(prefix, header)
            self._record(prefix, header, header)

    def _key_and_value(self, prefix: KeyPath) -> None:
        start = self.position
        path = (*prefix, *self._dotted_key())
        end = start + len(self.text[start : self.position].rstrip())
        if self.text[self.position] != "=":
            raise _Lost
        self.position += 1
        self._skip(_BLANK)
        value_start = self.position
        key = self._span(start, end)
        self._once(path, key)
        # recorded before the value is read, so that a value the scanner cannot follow still has its key
        self._record(path, key, key)
        self._value(path)
        value_end = value_start + len(self.text[value_start : self.position].rstrip())
        self.entries[path] = Entry(key, self._span(value_start, value_end))

    def _dotted_key(self) -> KeyPath:
        parts: list[str] = []
        while True:
            self._skip(_BLANK)
            quoted = self._match(_STRING)
            parts.append(next(iter(tomllib.loads(f"{quoted} = 0"))) if quoted else self._require(_BARE_KEY))
            self._skip(_BLANK)
            if self.text[self.position] != ".":
                return tuple(parts)
            self.position += 1

    def _value(self, path: KeyPath) -> None:
        if self._match(_STRING):
            return
        opening = self.text[self.position]
        if opening not in "[{":
            self._require(_SCALAR)
            return
        closing = "]" if opening == "[" else "}"
        self.position += 1
        index = 0
        while True:
            self._skip(_BLANK_OR_COMMENT)
            if self.text[self.position] == closing:
                self.position += 1
                return
            if opening == "{":
                self._key_and_value(path)
            else:
                start = self.position
                self._value((*path, index))
                span = self._span(start, self.position)
                self.entries[(*path, index)] = Entry(span, span)
            index += 1
            self._skip(_BLANK_OR_COMMENT)
            if self.text[self.position] == ",":
                self.position += 1

    def _once(self, path: KeyPath, place: Span) -> None:
        """Take note of what is written in so many words, and of the first that is written again."""
        first = self._written.setdefault(path, place)
        if first is not place and self.duplicate is None:
            self.duplicate = Duplicate(path, first, place)

    def _record(self, path: KeyPath, key: Span, value: Span) -> None:
        for depth in range(1, len(path)):
            self.entries.setdefault(path[:depth], Entry(key, key))
        self.entries[path] = Entry(key, value)

    def _span(self, start: int, end: int) -> Span:
        line = bisect.bisect_right(self._line_starts, start) - 1
        stop = self.text.find("\n", start)
        length = min(end, stop if stop >= 0 else len(self.text)) - start
        return Span(line + 1, start - self._line_starts[line] + 1, max(length, 1))

    def _match(self, pattern: re.Pattern[str]) -> str:
        match = pattern.match(self.text, self.position)
        if match is None:
            return ""
        self.position = match.end()
        return match.group()

    def _skip(self, pattern: re.Pattern[str]) -> None:
        self._match(pattern)

    def _require(self, pattern: re.Pattern[str]) -> str:
        found = self._match(pattern)
        if not found:
            raise _Lost
        return found


def _within_latest(path: KeyPath, tables_seen: dict[KeyPath, int], many: bool) -> KeyPath:
    """`path` of a header, with the index of the latest table wherever it leads through an array of tables."""
    full: KeyPath = ()
    for depth, part in enumerate(path, start=1):
        full = (*full, part)
        if full in tables_seen and not (many and depth == len(path)):
            full = (*full, tables_seen[full] - 1)
    return full
