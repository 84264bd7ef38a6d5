"""Everything that a case is refused for, of all kinds of problems.

tests/reference/refused_cases.json has valid cases and, for each, the keys of the errors that a change makes, the change (null
takes out a key), and words of messages, hints or what is allowed, with … between them; and changes that make a warning, or none
("")."""

from __future__ import annotations

import copy
import json
from typing import Any

import pytest
import tomli_w

from tests.support.cases import findings
from tests.support.documents import ROOT
from thermoroll_cli.files.case import Case
from thermoroll_cli.problem.kinds import kind_of

REFUSED = json.loads((ROOT / "tests" / "reference" / "refused_cases.json").read_text(encoding="utf-8"))
NAME = str(ROOT / "case.toml")
"""Files that cases name are those of the project."""


def changed(case: dict[str, Any], changes: dict[str, Any]) -> str:
    """The text of a case with other values at dotted keys."""
    content = copy.deepcopy(case)
    for key, value in changes.items():
        tables, last = key.split("."), key.rpartition(".")[2]
        place = content
        for table in tables[:-1]:
            place = place[table]
        place[last] = value
        if value is None:
            del place[last]
    return tomli_w.dumps(content)


@pytest.mark.parametrize("kind", REFUSED)
def test_what_is_refused_is_named_with_what_is_allowed(kind: str) -> None:
    """All errors of the case; without the change it has none."""
    case = REFUSED[kind]["case"]
    assert Case.parse(changed(case, {}), name=NAME)
    for keys, changes, words in REFUSED[kind]["refused"]:
        found = findings(changed(case, changes), name=NAME)
        told = [f"{finding.message} {finding.hint} {finding.allowed}" for finding in found]
        assert {finding.key for finding in found} == set(keys.split(", ")), changes
        assert all(any(word in each for each in told) for word in words.split(" … ")), (changes, told)
        assert all(finding.allowed or finding.hint for finding in found), (changes, told)


@pytest.mark.parametrize("kind", [kind for kind in REFUSED if "doubtful" in REFUSED[kind]])
def test_what_is_allowed_and_doubtful_is_warned_of(kind: str) -> None:
    for changes, words in REFUSED[kind]["doubtful"]:
        task = Case.parse(changed(REFUSED[kind]["case"], changes)).task
        told = list(kind_of(task).warnings(task))
        assert any(words in warning for warning in told) if words else not told, (changes, told)
