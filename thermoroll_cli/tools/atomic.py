"""Files that appear complete or not at all: a temporary name beside the target, then one rename. Errors of reading
small files become plain messages."""

from __future__ import annotations

import contextlib
import errno
import os
import pathlib
import secrets
import time
from collections.abc import Iterator
from typing import BinaryIO

ABANDONED_SECONDS = 60.0
"""A temporary file is written without a pause, and renamed at once."""


class WriteError(OSError):
    """A file could not be written; the message names it and says why. Nothing was left behind."""

    def __init__(self, path: pathlib.Path, cause: OSError) -> None:
        super().__init__(f"cannot write {path}: {cause.strerror or cause}")
        self.errno = cause.errno
        self.path = path


class ReadError(OSError):
    """A file could not be read; the message says why, and not which."""


def read_bytes(source: str | os.PathLike[str] | BinaryIO, limit: int, kind: str) -> bytes:
    """The content of a file, or of an open stream, that should be `kind` ("a case file") of at most `limit` bytes. Raises
    ReadError."""
    try:
        with (open(source, "rb", opener=_at_once) if isinstance(source, str | os.PathLike)
              else contextlib.nullcontext(source)) as stream:
            # One byte more than allowed identifies a large or endless file without reading it.
            content = stream.read(limit + 1)
    except FileNotFoundError:
        raise ReadError("no such file") from None
    except IsADirectoryError:
        raise ReadError(f"this is a folder, not {kind}") from None
    except (OSError, ValueError) as cause:  # ValueError: a NUL in the name
        raise ReadError(f"cannot be read: {getattr(cause, 'strerror', None) or cause}") from None
    if len(content) > limit:
        raise ReadError(f"too large for {kind}, which has at most {limit // 1024} KiB")
    return content


def _at_once(path: str, flags: int) -> int:
    """A file that is opened without waiting: a named pipe to which nobody writes is empty."""
    number = os.open(path, flags | getattr(os, "O_NONBLOCK", 0))
    if hasattr(os, "set_blocking"):
        os.set_blocking(number, True)
    return number


def write_bytes(path: str | os.PathLike[str], content: bytes) -> None:
    """Write `content` to `path` so that at any moment `path` holds its old content or all of the new one.

    A symbolic link is written through; a device or pipe (`/dev/stdout`) is written to directly, since it must not be replaced.

    Raises WriteError.
    """
    if not os.path.exists(path) or os.path.isfile(path) or os.path.isdir(path):
        with replacing(path) as temporary:
            # Not tempfile: its files are private (0600), results should follow the user's umask.
            temporary.write_bytes(content)
        return
    try:
        pathlib.Path(path).write_bytes(content)
    except OSError as cause:
        raise WriteError(pathlib.Path(path), cause) from cause


@contextlib.contextmanager
def replacing(path: str | os.PathLike[str]) -> Iterator[pathlib.Path]:
    """The name of a temporary file beside `path`: it replaces `path` at the end. If writing is interrupted (a full disk,
    Ctrl-C), the temporary file is removed. Raises WriteError."""
    target = pathlib.Path(os.path.realpath(path))
    # The name does not derive from the target's: that one may already be as long as the file system allows.
    temporary = target.with_name(f".thermoroll-{secrets.token_hex(8)}.part")
    try:
        if target.is_dir():
            raise IsADirectoryError(errno.EISDIR, "Is a directory")
        yield temporary
        with open(temporary, "rb+") as stream:
            os.fsync(stream.fileno())
        os.replace(temporary, target)
    except OSError as cause:
        raise cause if isinstance(cause, WriteError) else WriteError(pathlib.Path(path), cause) from cause
    finally:
        with contextlib.suppress(OSError):
            temporary.unlink(missing_ok=True)


def remove_leftovers(folder: pathlib.Path) -> None:
    """Remove the temporary files of processes that were killed while they wrote into `folder`: those that nobody has written
    to for `ABANDONED_SECONDS`."""
    for leftover in folder.glob(".thermoroll-*.part"):
        with contextlib.suppress(OSError):
            if time.time() - leftover.stat().st_mtime > ABANDONED_SECONDS:
                leftover.unlink()
