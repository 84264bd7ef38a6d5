"""Pages opened from disk in a headless Chromium."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from pathlib import Path
from typing import NamedTuple

import pytest

from tests.support.command_line import PATIENCE

NAMES = ("chromium", "chromium-browser", "google-chrome")
FLAGS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync", "--enable-logging=stderr", "--virtual-time-budget=10000",
    "--host-resolver-rules=MAP * ~NOTFOUND",
)  # fmt: skip


class Opened(NamedTuple):
    """What became of a page: its `dom` after all scripts, messages on its `console`, and `requests` to any server."""

    dom: str
    console: list[str]
    requests: set[str]


def opened(address: str, folder: Path, *options: str) -> Opened:
    """The page at `address`; its protocols are kept in the empty `folder`. Skips the test where there is no Chromium."""
    program = next(filter(None, map(shutil.which, NAMES)), None)
    if program is None:
        pytest.skip("no Chromium here that opens the page (Debian: apt install chromium)")
    protocol = folder / "requests.json"
    command = [program, *FLAGS, f"--user-data-dir={folder / 'user'}", f"--log-net-log={protocol}", *options, address]
    done = subprocess.run(command, capture_output=True, text=True, encoding="utf-8", errors="replace", timeout=PATIENCE)
    assert done.returncode == 0, done.stderr
    events = (event.get("params", {}) for event in json.loads(protocol.read_text(encoding="utf-8"))["events"])
    # The browser's own requests, for updates, belong to no page.
    asked = {event["url"] for event in events if event.get("initiator", "not an origin") != "not an origin"}
    return Opened(
        done.stdout, re.findall(r":CONSOLE[:(].*", done.stderr), {url for url in asked if url.startswith(("http", "ws"))}
    )
