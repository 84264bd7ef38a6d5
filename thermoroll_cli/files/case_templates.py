"""Commented case files to start from: the files in `templates/`."""

from __future__ import annotations

from importlib.resources import files

_FOLDER = files("thermoroll_cli.files") / "templates"
TEMPLATES = {
    "wheel-rail": "a wheel on a rail",
    "worn-rail": "a wheel on a measured rail profile",
    "ball-bearing": "a ball in a grooved raceway, with spin",
    "roller": "a roller with a logarithmic crown",
    "traction-drive": "two rollers near their largest force",
    "twin-disc": "two discs that turn and get hot",
    "twin-disc-wear": "two discs that wear",
    "locomotive": "a wheel with friction that falls with slip, and a layer of dirt",
    "article": "the article's spheres, at a speed that no machine has",
}
"""Templates of `thermoroll init`, the first by default; a new one is a file `templates/NAME.toml` and a line here."""


def template_text(name: str) -> str:
    """The template `name` as the text of a case file."""
    return (_FOLDER / f"{name}.toml").read_text(encoding="utf-8")
