"""What is wrong with files that a case or a command names.

tests/reference/refused_files.json has, for each kind, a command with its case, a sound file, and contents that are refused with
words of the message."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
import tomli_w

from tests.support.command_line import call
from tests.support.documents import ROOT

FILES = json.loads((ROOT / "tests" / "reference" / "refused_files.json").read_text(encoding="utf-8"))


@pytest.mark.parametrize("kind", FILES)
def test_what_is_refused_is_named_with_its_file(kind: str, tmp_path: Path) -> None:
    given = FILES[kind]
    (tmp_path / "cases").symlink_to(ROOT / "cases")
    (tmp_path / "case.toml").write_text(tomli_w.dumps(given["case"]), encoding="utf-8")
    command, path = given["command"].split(), tmp_path / given["file"]
    if "sound" in given:
        path.write_text(given["sound"], encoding="utf-8")
        assert call(*command, cwd=tmp_path).returncode == 0
    for content, words in given["refused"]:
        path.write_text(content.replace("{long}", "1" * 200_000), encoding="utf-8")
        done = call(*command, cwd=tmp_path)
        told = " ".join(done.stderr.replace("│", " ").split())
        assert done.returncode == given["code"] and words in told, (content, told)
        assert not any((tmp_path / "out").glob("*"))
        if given["code"] == 3:
            assert path.name in told
            record = json.loads(call(*command, "--json", cwd=tmp_path).stdout)
            assert record["errors"] and not record["valid"]
