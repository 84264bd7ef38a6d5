"""Tasks that need no solver, for the programs that work tasks off: their processes import this module alone."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any


@dataclass(frozen=True)
class DeadlyTask:
    """Items of which one kills the process that works at it."""

    keys: tuple[str, ...]
    folder: str

    @property
    def key(self) -> str:
        return self.keys[0]

    def items(self) -> Iterator[tuple[dict[str, Any], dict[str, bytes]]]:
        for key in self.keys:
            if key == "deadly":
                with open(os.path.join(self.folder, "deaths"), "a") as stream:
                    stream.write("x")
                os._exit(9)
            yield {"key": key, "reason": ""}, {}

    def without(self, done: Callable[[str], bool]) -> DeadlyTask | None:
        left = tuple(key for key in self.keys if not done(key))
        return replace(self, keys=left) if left else None

    def parts(self) -> list[DeadlyTask]:
        return [replace(self, keys=(key,)) for key in self.keys]

    def given_up(self, reason: str) -> dict[str, Any]:
        return {"key": self.keys[0], "reason": reason}


class SlowDiskTask(DeadlyTask):
    """Items with files that take long to write."""

    def items(self) -> Iterator[tuple[dict[str, Any], dict[str, bytes]]]:
        os.fsync = lambda file: time.sleep(0.5)
        for key in self.keys:
            yield {"key": key, "file": f"{key}.bin"}, {f"{key}.bin": b"content"}
            time.sleep(0.5)  # it works at the next one
