"""The commands without the modules and names of Python that other systems than Linux lack."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.command_line import MECHANICAL, environment

ELSEWHERE = """\
import os, signal, sys, warnings
sys.modules |= dict.fromkeys(("fcntl", "grp", "pty", "pwd", "resource", "termios", "tty"))
for name in ("SIGHUP", "SIGALRM", "SIGKILL", "SIGQUIT", "SIGPIPE", "alarm", "pthread_kill", "pthread_sigmask", "setitimer"):
    delattr(signal, name)
for name in ("fchmod", "geteuid", "getpgid", "getppid", "getuid", "kill", "killpg", "mkfifo", "pread", "pwrite", "setsid"):
    delattr(os, name)
warnings.filterwarnings("ignore", "only soft file lock is available")  # filelock misses fcntl; on Windows it has msvcrt
"""


@pytest.mark.parametrize("jobs", ["1", pytest.param("2", marks=pytest.mark.slow)])
def test_nothing_needs_linux(jobs: str, tmp_path: Path) -> None:
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "elsewhere" / "sitecustomize.py").write_text(ELSEWHERE)
    (tmp_path / "case.toml").write_text(MECHANICAL)
    sweep = ("sweep", "case.toml", "--over", "creepage.longitudinal=0.001:0.002:3", "--no-plots", "-o", "out", "-q")
    commands = (("run", "case.toml", "--no-plots", "-q"), (*sweep, "--jobs", jobs), (*sweep, "--resume"))
    program = f"from thermoroll_cli.cli.main import main; print(*(main([*words]) for words in {commands!r}))"
    elsewhere = environment({"PYTHONPATH": str(tmp_path / "elsewhere")})
    done = subprocess.run([sys.executable, "-c", program], cwd=tmp_path, env=elsewhere, capture_output=True, text=True)
    assert (done.stdout, done.stderr) == ("0 0 0\n", "")
    assert len((tmp_path / "out" / "sweep.csv").read_text().splitlines()) == 4
    assert not list((tmp_path / "out").glob(".*")), "the lock is gone"
