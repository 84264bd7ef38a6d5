"""Case texts that are read, and what is said about those that cannot be."""

from __future__ import annotations

import pytest

from thermoroll_cli.files.case import Case, CaseError, Finding, Override


def parse(text: str, *overrides: str) -> Case:
    return Case.parse(text, overrides=[Override.parse(override) for override in overrides])


def findings(text: str, *overrides: str, name: str = "bad.toml") -> tuple[Finding, ...]:
    with pytest.raises(CaseError) as caught:
        Case.parse(text, name=name, overrides=[Override.parse(override) for override in overrides])
    return caught.value.findings
