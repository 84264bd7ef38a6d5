"""The text of a case and the settings that override it, before anything is checked."""

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
from pathlib import Path
from typing import Any

from thermoroll_cli.files.case_errors import CaseError, Finding, KeyPath, Place, Places, Span, shortened, syntax_error
from thermoroll_cli.files.case_model import EXCLUSIVE
from thermoroll_cli.tools.atomic import ReadError, read_bytes

SIZE_LIMIT = 1 << 16
"""Bytes a case file may have. Real ones have a thousand or two; anything larger is some other file given by mistake."""

STANDARD_INPUT = "-"

_PACKAGE = Path(__file__).parents[1]
EXAMPLES = next((folder for folder in (_PACKAGE / "cases", _PACKAGE.parent / "cases") if folder.is_dir()), _PACKAGE)
"""The cases of the documents: in the package where it was installed, beside it in a checkout."""

_LOOSE_NUMBER = re.compile(r"[-+]?(?:(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?|(?i:inf(?:inity)?))")
# tomllib needs quadratic time for a key of many parts.
_ENDLESS_KEY = re.compile(r"(?<![\w-])(?:[\w-]++[ \t]*+\.[ \t]*+){33}")

@dataclass(frozen=True)
class Override:
    """A key given beside the case file: `text` is its spelling there, `origin` the name of that place in errors."""

    path: KeyPath
    value: Any
    text: str
    origin: str = "--set"

    @property
    def place(self) -> str:
        return f"{self.origin} {self.text}"

    @classmethod
    def parse(cls, text: str) -> Override:
        """`key=value` with a dotted key and a TOML value; anything else is a text.

        Raises ValueError if there is no key or no `=`.
        """
        key, equals, written = text.partition("=")
        if not equals or not key.strip():
            raise ValueError(f'"{text}" is not of the form key=value, for example load.normal_N=80')
        if not all(part.strip() for part in key.split(".")):
            raise ValueError(f'"{text}": a key has the form table.key, for example load.normal_N=80')
        return cls(key_path(key), toml_value(written.strip()), text)


def key_path(key: str) -> KeyPath:
    """The path of a dotted key; a number counts tables `[[name]]` from 0: `material.layers.0.thickness_um`."""
    return tuple(int(part) if part.strip().isdecimal() else part.strip() for part in key.split("."))


@dataclass(frozen=True)
class CaseSource:
    """A parsed case text with its overrides applied to `content`; knows where every key was written where the
    content is that of the text (`located`)."""

    name: str
    text: str
    content: dict[str, Any]
    overrides: tuple[Override, ...] = ()
    located: bool = True

    def get(self, path: KeyPath) -> Any:
        """The value at `path`; None where there is none."""
        value: Any = self.content
        for part in path:
            inside = part in value if isinstance(value, dict) else isinstance(value, list) and isinstance(part, int)
            value = value[part] if inside else None
        return value

    def finding(self, path: KeyPath, message: str, *, allowed: str = "", hint: str = "", at_key: bool = False) -> Finding:
        """An error about `path`, placed at its value (or its key), or at the nearest table around it."""
        key = ".".join(str(part) for part in path)
        # The last setting counts; a table is meant by what was set in it only if the text does not have it.
        within = [item for item in reversed(self.overrides) if item.path[: len(path)] == path]
        override = next((item for item in within if item.path == path or path not in self.places), None)
        if override is not None:
            value = shortened(override.text.partition("=")[2].strip()) if override.path == path and not at_key else ""
            return Finding(message, key, value, allowed, hint, source=override.place)
        known = next((path[:depth] for depth in range(len(path), 0, -1) if path[:depth] in self.places), None)
        if known is None:
            given = self.get(path)
            value = "" if at_key or given is None or isinstance(given, dict) else shortened(repr(given))
            return Finding(message, key, value, allowed, hint, source=self.name)
        place = self.places[known]
        exact = known == path and place.value != place.key
        span = place.value if exact and not at_key else place.key
        line_text = self.text.split("\n")[span.line - 1]
        value = shortened(line_text[span.column - 1 :][: span.length]) if exact and not at_key else ""
        return Finding(message, key, value, allowed, hint, self.name, span, line_text)

    def overridden(self, overrides: Sequence[Override]) -> CaseSource:
        """The same text with `overrides` applied besides those it has; cheaper than parsing it again. Raises CaseError."""
        content = copy.deepcopy(self.content)
        apply_overrides(content, overrides)
        return replace(self, content=content, overrides=(*self.overrides, *overrides))

    def line_of(self, path: KeyPath) -> str:
        """` (line 12)` for a key of the text, nothing for one that is not in it."""
        return f" (line {self.places[path].key.line})" if path in self.places else ""

    @cached_property
    def places(self) -> dict[KeyPath, Place]:
        """Where each key stands, looked up when the first error asks."""
        return Places(self.text).found if self.located else {}


def read_source(path: str | os.PathLike[str], overrides: Sequence[Override] = ()) -> CaseSource:
    """Read the case file at `path`, `-` for standard input. Raises CaseError if it cannot be read or is not TOML."""
    stdin = os.fspath(path) == STANDARD_INPUT
    name = "<stdin>" if stdin else os.fspath(path)
    if stdin and sys.stdin is None:
        raise CaseError([Finding("standard input is closed", source=name)])
    try:
        raw = read_bytes(sys.stdin.buffer if stdin else path, SIZE_LIMIT, "a case file")
    except ReadError as cause:
        hint = "" if os.path.exists(name) else _similar_file(name)
        raise CaseError([Finding(str(cause), source=name, hint=hint)]) from None
    if raw.startswith(b"\x89HDF\r\n\x1a\n"):
        hint = "thermoroll plot, export and compare read result files; thermoroll run --from solves one again"
        raise CaseError([Finding("this is an HDF5 file, not a case file", source=name, hint=hint)])
    try:
        return parse_source(raw.decode("utf-8-sig"), name, overrides)  # some editors put a mark in front
    except UnicodeDecodeError as cause:
        line_start = raw.rfind(b"\n", 0, cause.start) + 1
        column = len(raw[line_start : cause.start].decode("utf-8-sig")) + 1
        line_text = raw[line_start:].split(b"\n", 1)[0].decode("utf-8", "replace")
        raise CaseError([Finding(f"not UTF-8 text: byte 0x{raw[cause.start]:02x}", hint="save the file with the encoding UTF-8",
                                 source=name, span=Span(raw.count(b"\n", 0, cause.start) + 1, column, 1),
                                 line_text=line_text)]) from None


def parse_source(text: str, name: str, overrides: Sequence[Override] = ()) -> CaseSource:
    """Parse `text` and apply `overrides`. Raises CaseError if it is not TOML."""
    text = text.replace("\r\n", "\n")
    try:
        if _ENDLESS_KEY.search(text):
            raise ValueError
        content = tomllib.loads(text)
    except tomllib.TOMLDecodeError as cause:
        raise CaseError([syntax_error(name, text, str(cause))]) from None
    except (RecursionError, ValueError):
        # ValueErrors of another kind: an integer of thousands of digits, and the endless key.
        message = "not a case: nested too deeply, or numbers too long"
        raise CaseError([Finding(message, source=name)]) from None
    if not content and not overrides:
        raise CaseError([Finding("there is nothing in it", source=name, hint="thermoroll init writes a case to start from")])
    source = CaseSource(name, text, content, tuple(overrides))
    apply_overrides(content, overrides)
    return source


def case_name(path: str | os.PathLike[str]) -> str:
    """The name of the results of the case at `path`: the file name without its last suffix."""
    name = os.fspath(path)
    return "stdin" if name == STANDARD_INPUT else os.path.splitext(os.path.basename(name))[0]


def apply_overrides(content: dict[str, Any], overrides: Iterable[Override]) -> None:
    """Set the keys of `overrides` in `content`; of two keys that exclude each other the overriding one stays.

    Raises CaseError for a key inside something that is no table.
    """
    given = {item.path for item in overrides}
    pairs = [(key_path(first), key_path(second)) for first, second, _ in EXCLUSIVE]
    for override in overrides:
        for mine, rival in (*pairs, *((second, first) for first, second in pairs)):
            # A table is given by any key in it.
            if override.path[: len(mine)] == mine and not any(path[: len(rival)] == rival for path in given):
                rival_table: Any = content
                for part in rival[:-1]:
                    rival_table = rival_table.get(part) if isinstance(rival_table, dict) else None
                if isinstance(rival_table, dict):
                    rival_table.pop(rival[-1], None)
        table: Any = content
        for step in override.path[:-1]:
            if isinstance(table, list):
                table = table[step] if isinstance(step, int) and step < len(table) else None
            else:
                table = table.setdefault(step, {})
            if not isinstance(table, dict | list):
                raise CaseError([Finding(f"{step} is a value, not a table", source=override.place)])
        if isinstance(table, list):
            raise CaseError([Finding(f"{override.path[-1]} stands in several tables: say in which", source=override.place)])
        table[override.path[-1]] = override.value


def _similar_file(name: str) -> str:
    """A hint instead of a missing case file: how a case of the documents is written, or a file that is called like it."""
    folder, base = os.path.split(name)
    try:
        if base.endswith(".toml") and (EXAMPLES / base).is_file():
            return f"thermoroll init --example {os.path.splitext(base)[0]} writes cases/{base}"
        files = [entry for entry in os.listdir(folder or ".") if entry.endswith(".toml")]
    except (OSError, ValueError):
        return ""
    # The names alone are compared: the ending that all have in common would make any two of them similar.
    stems = {os.path.splitext(file)[0]: file for file in files}
    near = difflib.get_close_matches(os.path.splitext(base)[0], stems, n=1)
    return f"did you mean {os.path.join(folder, stems[near[0]])}?" if near else ""


def toml_value(text: str) -> Any:
    """The TOML value that `text` stands for; anything else is a text."""
    try:
        parsed = tomllib.loads(f"value = {text}")
        if set(parsed) == {"value"}:
            return parsed["value"]
    except (tomllib.TOMLDecodeError, RecursionError, ValueError):
        pass
    # Shells and scripts print numbers that TOML does not know, such as .5 and INF
    return float(text) if _LOOSE_NUMBER.fullmatch(text) else text
