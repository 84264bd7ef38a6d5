"""Finished items: a file of JSON lines that only grows, from which tables are written and work is resumed."""

from __future__ import annotations

import contextlib
import json
import os
import pathlib
import shutil
from collections.abc import Callable, Collection, Iterator, Mapping
from types import MappingProxyType, TracebackType
from typing import Any, Self

from filelock import FileLock, Timeout

from thermoroll_cli.tools.atomic import WriteError, write_bytes

Record = Mapping[str, Any]
"""One finished item: its `key`, and whatever the task writes. One with `"solved": false` is tried again
when work is resumed."""


class JournalError(OSError):
    """A journal cannot be opened: another process has it open, or it is of something else. The message names it."""


ALTERNATIVES = "--force begins anew, another place (-o) keeps both; nothing was touched"
"""What to do about other work where a command would write."""


class Journal(Mapping[str, dict[str, Any]]):
    """The records of finished items by their keys, read from the file when asked for.

    The first line holds `identity`, what is being computed. Every further line is one record, written in a single call after
    the file that it belongs to; the latest record of a key counts. A killed program leaves at most a torn last line, which
    is dropped, as is one that lacks one of the `fields` of all records. While a journal is open, no other process can open it.
    One that is begun anew keeps the last one aside until it has a record, and puts it back where it fails before; `lost` says
    of one with records which work would be lost that is not done again, "" if none (not asked: no work counts).

    Raises JournalError, WriteError.
    """

    def __init__(self, path: pathlib.Path, identity: Mapping[str, Any], *, resume: bool,
                 fields: Collection[str] = (), lost: Callable[[Mapping[str, Record]], str] | None = None) -> None:  # fmt: skip
        self.path, self._fields = path, {"key", *fields}
        self._places: dict[str, tuple[int, int]] = {}
        first = json.dumps({"program": "thermoroll", **identity}, sort_keys=True).encode() + b"\n"
        # A file beside the journal: a locked file cannot be written by other processes on every system.
        self._lock = FileLock(path.with_name(f".{path.name}.lock"), timeout=0)
        try:
            self._file = open(path, "a+b", buffering=0)
        except OSError as cause:
            raise WriteError(path, cause) from cause
        try:
            self._take_lock()
            self._file.seek(0)
            if resume and os.path.getsize(path):
                if self._file.read(len(first)) != first:
                    raise JournalError(f"{path}: of another {identity['kind']}, or another version; use another place, or "
                                       "leave --resume out")
            else:
                if lost is not None:
                    self._check_loss(first, identity["kind"], lost)
                if os.path.getsize(path):
                    shutil.copyfile(path, self._last)
                self._file.truncate(0)
                append_line(path, first)
            self._end = len(first)
            self.update()
            self._file.truncate(self._end)
        except BaseException:
            self._close()
            raise

    def _check_loss(self, first: bytes, kind: str, lost: Callable[[Mapping[str, Record]], str]) -> None:
        """Raises JournalError where the file has records that are not to be lost."""
        begins = self.path.read_bytes()[: len(first)]
        self._end = len(begins.partition(b"\n")[0]) + 1
        self.update()
        what = lost(self) if begins == first else f"{self.path} is of another {kind}, or of another version"
        if self and what:
            also = "--resume keeps it and goes on, " if begins == first else ""
            raise JournalError(f"{what}: {also}{ALTERNATIVES}")
        self._places.clear()

    def _take_lock(self) -> None:
        try:
            self._lock.acquire()
        except Timeout:
            raise JournalError(f"another process works in {self.path.parent} ({self.path.name} is in use); use another "
                               "folder") from None
        except (OSError, NotImplementedError):  # a file system without locks
            pass

    def _close(self) -> None:
        self._file.close()
        if self._lock.is_locked:
            # Before it is released: afterwards the file may be the next process's.
            with contextlib.suppress(OSError):
                os.unlink(self._lock.lock_file)
            self._lock.release()

    @property
    def _last(self) -> pathlib.Path:
        """Where the last journal is, which this one takes the place of."""
        return self.path.with_name(f"{self.path.name}.bak")

    def replaced(self) -> set[str]:
        """The names of the files in the records of the journal that this one takes the place of."""
        names = set[str]()
        if self._last.exists():
            for line in self._last.read_bytes().splitlines():
                with contextlib.suppress(ValueError, KeyError, TypeError):
                    names.add(str(json.loads(line)["file"]))
        return names

    def update(self) -> list[str]:
        """The keys of the records that have come since the last call, in their order; keys are kept in that of their latest
        records."""
        keys = []
        with open(self.path, "rb") as stream:
            stream.seek(self._end)
            for line in stream:
                if not line.endswith(b"\n"):
                    break
                # A line that a full disk has cut in two counts as none.
                with contextlib.suppress(ValueError):
                    record = json.loads(line)
                    if isinstance(record, dict) and record.keys() >= self._fields:
                        key = str(record["key"])
                        self._places.pop(key, None)
                        self._places[key] = self._end, len(line)
                        keys.append(key)
                self._end += len(line)
        return keys

    def keep(self, record: Record, files: Mapping[str, bytes] = MappingProxyType({})) -> None:
        """Write the contents of `files` under their names beside the journal, then the record with their lengths as `bytes`.
        Raises WriteError."""
        keep(self.path, record, files)

    def __getitem__(self, key: str) -> dict[str, Any]:
        """The record of `key`; also after the journal is closed."""
        place, length = self._places[key]
        with open(self.path, "rb", buffering=0) as stream:
            stream.seek(place)
            record: dict[str, Any] = json.loads(stream.read(length))
        return record

    def __contains__(self, key: object) -> bool:
        return key in self._places

    def __iter__(self) -> Iterator[str]:
        return iter(self._places)

    def __len__(self) -> int:
        return len(self._places)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None) -> None:
        if self._last.exists():
            if value is not None and not self.update() and not self:
                os.replace(self._last, self.path)
            else:
                self._last.unlink()
        self._close()


def keep(path: pathlib.Path, record: Record, files: Mapping[str, bytes]) -> None:
    """Do the same as `Journal.keep` for the journal at `path`, from any process. Raises WriteError."""
    for name, content in files.items():
        write_bytes(path.parent / name, content)
    if files:
        record = {**record, "bytes": {name: len(content) for name, content in files.items()}}
    append_line(path, json.dumps(record).encode() + b"\n")


def is_whole(folder: pathlib.Path, record: Record) -> bool:
    """Whether a `record` has files, and all are there as long as they were written. Reading 100,000 of them would take half an
    hour."""
    try:
        lengths = record.get("bytes") or {}
        return bool(lengths) and all(os.path.getsize(folder / name) == length for name, length in lengths.items())
    except OSError:
        return False


def append_line(path: pathlib.Path, line: bytes) -> None:
    try:
        # One call, so that lines of several processes do not mix.
        with open(path, "ab", buffering=0) as stream:
            while line:
                line = line[stream.write(line) :]
    except OSError as cause:
        raise WriteError(path, cause) from cause
