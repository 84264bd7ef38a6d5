"""Commented case files to start from: the files in `templates/`."""

from __future__ import annotations

from importlib.resources import files

_FOLDER = files("thermoroll_cli.files") / "templates"
TEMPLATES = ("article", "wheel-rail", "ball-bearing", "traction-drive", "roller", "worn-rail", "twin-disc")
"""Names of the templates of `thermoroll init`."""


def template_text(name: str) -> str:
    """The template `name` as the text of a case file."""
    return (_FOLDER / f"{name}.toml").read_text(encoding="utf-8")
