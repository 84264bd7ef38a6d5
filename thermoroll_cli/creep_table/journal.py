"""What of a table is solved already: an append-only file beside it, whose torn end is no loss."""

from __future__ import annotations

import json
import os
import pathlib
import struct
import zlib
from collections.abc import Mapping
from typing import Any

import numpy as np

from thermoroll_cli.arrays import Array
from thermoroll_cli.files.atomic import WriteError
from thermoroll_cli.files.result.hdf5 import ResultFileError

HEAD = struct.Struct("<IIIQ")
"""Number of the task, CRC-32 of its content, rows, columns."""


class Journal:
    """Arrays of finished tasks by their numbers. `identity` tells the table apart."""

    def __init__(self, path: pathlib.Path, identity: Mapping[str, Any], *, resume: bool) -> None:
        """Raises ResultFileError where `path` is of another table, WriteError."""
        self._path = path
        self.found: dict[int, Array] = {}
        first = json.dumps(identity, sort_keys=True).encode() + b"\n"
        try:
            content = path.read_bytes() if resume and path.exists() else b""
            if content and not content.startswith(first):
                raise ResultFileError(f"{path}: of another table; remove it, or leave --resume out")
            whole = self._read(content, len(first)) if content else 0
            with open(path, "r+b" if content else "wb") as stream:
                if not content:
                    stream.write(first)
                else:
                    stream.truncate(whole)
        except ResultFileError:
            raise
        except OSError as cause:
            raise WriteError(path, cause) from cause

    def _read(self, content: bytes, place: int) -> int:
        """Read all whole records from `place` on; where they end."""
        while place + HEAD.size <= len(content):
            number, checksum, rows, columns = HEAD.unpack_from(content, place)
            end = place + HEAD.size + 8 * rows * columns
            part = content[place + HEAD.size : end]
            if end > len(content) or zlib.crc32(part) != checksum:
                break
            self.found[number] = np.frombuffer(part).reshape(rows, columns)
            place = end
        return place

    def add(self, number: int, values: Array) -> None:
        """Keep the array (rows, columns) of a task. Raises WriteError."""
        content = np.ascontiguousarray(values, dtype=float).tobytes()
        head = HEAD.pack(number, zlib.crc32(content), *values.shape)
        try:
            with open(self._path, "ab", buffering=0) as stream:
                stream.write(head + content)
                os.fsync(stream.fileno())
        except OSError as cause:
            raise WriteError(self._path, cause) from cause
        self.found[number] = values
