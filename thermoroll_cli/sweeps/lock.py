"""One sweep at a time in a folder."""

from __future__ import annotations

import contextlib
import json
import os
import pathlib
import secrets
import socket
from collections.abc import Iterator

LOCK_NAME = ".thermoroll-sweep.lock"


class FolderInUse(OSError):
    """Another sweep works in the folder."""


@contextlib.contextmanager
def sole_sweep(folder: pathlib.Path) -> Iterator[None]:
    """Hold the lock of `folder`. The lock of a process that is gone is taken over. Raises FolderInUse, OSError."""
    path = folder / LOCK_NAME
    mine = json.dumps({"pid": os.getpid(), "host": socket.gethostname(), "started": _started(os.getpid())})
    while not _create(path, mine):
        text = _read(path)
        if text is not None and not _is_stale(text):
            raise FolderInUse(_message(folder, path, text))
        _remove(path, text)
    try:
        yield
    finally:
        _remove(path, mine)


def _create(path: pathlib.Path, text: str) -> bool:
    """Make the lock with its content at once; False if there is one."""
    # Of a private name first: nobody must find a lock that does not tell yet whose it is.
    temporary = path.with_name(f"{LOCK_NAME}.{secrets.token_hex(8)}")
    try:
        temporary.write_text(text, encoding="utf-8")
        try:
            os.link(temporary, path)
        except FileExistsError:
            return False
        except OSError:  # a file system without hard links
            with contextlib.suppress(FileExistsError), open(path, "x", encoding="utf-8") as stream:
                stream.write(text)
                return True
            return False
        return True
    except OSError as cause:
        raise OSError(f"cannot write to {path.parent}: {cause.strerror or cause}") from None
    finally:
        temporary.unlink(missing_ok=True)


def _read(path: pathlib.Path) -> str | None:
    try:
        return path.read_text(encoding="utf-8", errors="replace")
    except FileNotFoundError:
        return None


def _remove(path: pathlib.Path, text: str | None) -> None:
    """Remove the lock if it still has the content `text`."""
    if text is None:
        return
    # Moved aside before it is looked at: whoever else does the same finds nothing.
    aside = path.with_name(f"{LOCK_NAME}.{secrets.token_hex(8)}")
    try:
        os.rename(path, aside)
    except FileNotFoundError:
        return
    if _read(aside) != text:
        with contextlib.suppress(OSError):
            os.link(aside, path)
    aside.unlink(missing_ok=True)


def _is_stale(text: str) -> bool:
    """Whether the lock's process is known to be gone: only on the same machine can one tell."""
    owner = _owner(text)
    pid = owner.get("pid")
    if owner.get("host") != socket.gethostname() or not isinstance(pid, int) or os.name != "posix":
        return False
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return True
    except (OSError, OverflowError):
        return False
    # Another process may have been given the number since.
    return owner.get("started") != _started(pid)


def _owner(text: str) -> dict[str, object]:
    try:
        owner = json.loads(text)
    except ValueError:
        return {}
    return owner if isinstance(owner, dict) else {}


def _started(pid: int) -> str:
    """When the process began, in the kernel's ticks; empty where the system does not tell."""
    try:
        stat = pathlib.Path(f"/proc/{pid}/stat").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return ""
    # The name of the process, in brackets, may contain anything.
    fields = stat.rpartition(")")[2].split()
    return fields[19] if len(fields) > 19 else ""


def _message(folder: pathlib.Path, path: pathlib.Path, text: str) -> str:
    owner = _owner(text)
    who = f"process {owner['pid']} on {owner.get('host')}" if "pid" in owner else "a process that did not leave its name"
    return f"another sweep works in {folder} ({who}); use another folder, or remove {path} if that sweep is dead"
