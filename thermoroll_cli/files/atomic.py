"""Files that appear complete or not at all: a temporary name beside the target, then one rename."""

from __future__ import annotations

import contextlib
import errno
import hashlib
import os
import pathlib
import platform
import secrets
from collections.abc import Iterator

from thermoroll_cli.interruption import waiting

_EXPLANATIONS = {
    errno.ENOSPC: "no space left on the device",
    errno.EDQUOT: "the disk quota is used up",
    errno.EROFS: "the file system is read-only",
    errno.EACCES: "permission denied",
    errno.EPERM: "permission denied",
    errno.ENOENT: "the folder does not exist",
    errno.ENOTDIR: "a part of the path is a file, not a folder",
    errno.EISDIR: "that is a folder",
    errno.EFBIG: "the file would be larger than allowed",
    errno.ENAMETOOLONG: "the name is too long",
}


class WriteError(OSError):
    """A file could not be written; the message names it and says why. Nothing was left behind."""

    def __init__(self, path: pathlib.Path, cause: OSError) -> None:
        reason = _EXPLANATIONS.get(cause.errno or 0, cause.strerror or str(cause))
        super().__init__(f"cannot write {path}: {reason}")
        self.errno = cause.errno
        self.path = path


def write_bytes(path: str | os.PathLike[str], content: bytes | memoryview) -> None:
    """Write `content` to `path` so that at any moment `path` holds its old content or all of the new one.

    Whatever interrupts the writing (a full disk, Ctrl-C), the temporary file is removed again. A symbolic link is
    written through; a device or pipe (`/dev/stdout`) is written to directly, since it must not be replaced.

    Raises WriteError.
    """
    shown = pathlib.Path(path)
    target = pathlib.Path(os.path.realpath(path))
    try:
        if target.is_dir():
            raise IsADirectoryError(errno.EISDIR, "Is a directory")
        if target.exists() and not target.is_file():
            _write_all(os.open(target, os.O_WRONLY), content, durable=False)
        else:
            _replace(target, content)
    except OSError as cause:
        raise WriteError(shown, cause) from cause


def remove_leftovers(folder: pathlib.Path) -> None:
    """Remove the temporary files of processes that were killed while they wrote into `folder`; those of other machines stay,
    since who still lives there cannot be told."""
    for leftover in folder.glob(f".thermoroll-{_node()}-*.part"):
        pid = leftover.name.split("-")[2]
        if pid.isdigit() and not _alive(int(pid)):
            leftover.unlink(missing_ok=True)


def _node() -> str:
    return hashlib.sha256(platform.node().encode()).hexdigest()[:8]


def _alive(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    except OSError:
        return True
    return True


@contextlib.contextmanager
def replacing(path: str | os.PathLike[str]) -> Iterator[pathlib.Path]:
    """The name of a temporary file beside `path`, for files too large to be held in memory: what is written there takes the
    place of `path` at the end, or nothing does. Raises WriteError."""
    target = pathlib.Path(os.path.realpath(path))
    temporary = _temporary(target)
    try:
        yield temporary
        with open(temporary, "rb+") as stream:
            os.fsync(stream.fileno())
        os.replace(temporary, target)
    except OSError as cause:
        raise cause if isinstance(cause, WriteError) else WriteError(pathlib.Path(path), cause) from cause
    finally:
        temporary.unlink(missing_ok=True)


def _temporary(target: pathlib.Path) -> pathlib.Path:
    # The name does not derive from the target's: that one may already be as long as the file system allows.
    return target.with_name(f".thermoroll-{_node()}-{os.getpid()}-{secrets.token_hex(4)}.part")


def _replace(target: pathlib.Path, content: bytes | memoryview) -> None:
    temporary = _temporary(target)
    try:
        # Not tempfile: its files are private (0600), results should follow the user's umask.
        _write_all(os.open(temporary, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666), content, durable=True)
        os.replace(temporary, target)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise


def _write_all(descriptor: int, content: bytes | memoryview, *, durable: bool) -> None:
    with open(descriptor, "wb", buffering=0) as stream:
        rest = memoryview(content)
        while rest:
            # One call may write less than asked for: at most 2 GiB on Linux, or what still fitted on the disk.
            with waiting():
                rest = rest[stream.write(rest) :]
        if durable:
            with waiting():
                os.fsync(stream.fileno())
