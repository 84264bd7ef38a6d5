"""The output of the commands of docs/tutorial.md, and the creep curve that they draw."""

from __future__ import annotations

import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

BLOCK = re.compile(r"(```console\n)(.*?)(```)", re.DOTALL)


def run_commands(document: pathlib.Path) -> None:
    """Run the commands of all ```console blocks (lines that begin with `$ `) in one empty folder, insert their output, and copy
    the picture of the creep curve."""
    text = document.read_text(encoding="utf-8")
    with tempfile.TemporaryDirectory() as folder:
        ran = BLOCK.sub(lambda block: block[1] + _session(block[2], folder) + block[3], text)
        shutil.copy(pathlib.Path(folder) / "creep" / "sweep.png", document.parent / "figures" / "creep_curve.png")
    if ran != text:
        document.write_text(ran, encoding="utf-8")


def _session(block: str, folder: str) -> str:
    commands = [line[2:] for line in block.splitlines() if line.startswith("$ ")]
    path = os.pathsep.join([str(pathlib.Path(sys.executable).parent), os.environ.get("PATH", "")])
    environment = {**os.environ, "PATH": path, "COLUMNS": "120", "NO_COLOR": "1"}
    printed = []
    for command in commands:
        done = subprocess.run(["bash", "-c", command], cwd=folder, env=environment, stdout=subprocess.PIPE,
                              stderr=subprocess.DEVNULL, text=True, check=False)
        printed.append(f"$ {command}\n{done.stdout}")
    return "".join(printed)
