"""The JSON schema of case files, as an editor uses it: what it accepts, and what it says of mistakes."""

from __future__ import annotations

import json
import math
import tomllib
from pathlib import Path
from typing import Any

import jsonschema
import pytest

from tests.support.command_line import MECHANICAL, THERMAL
from thermoroll_cli.cli.cases import TEMPLATES, template_text
from thermoroll_cli.files.case import Case, CaseError
from thermoroll_cli.files.case_schema import case_schema

CASES = {path.name: path.read_text() for path in sorted((Path(__file__).parents[2] / "cases").glob("*.toml"))}
CASES |= {f"template {name}": template_text(name) for name in TEMPLATES}
SCHEMA = case_schema()
VALIDATOR = jsonschema.Draft202012Validator(SCHEMA)
TWO = THERMAL.replace("[material]", "[material.lower]", 1).replace(
    "[geometry]", "[material.upper]\nyoungs_modulus_GPa = 70\npoisson_ratio = 0.3\n[geometry]"
)


def without_infinity(node: Any) -> Any:
    """`node` as editors hand it on that read TOML into JSON, which has no infinity."""
    if isinstance(node, dict):
        return {key: without_infinity(value) for key, value in node.items()}
    return None if isinstance(node, float) and not math.isfinite(node) else node


def errors(text: str) -> list[tuple[str, str]]:
    """Path and message of each error, the same for TOML as Python reads it and as editors hand it on."""
    content = tomllib.loads(text)
    found = [(error.json_path, error.message) for error in VALIDATOR.iter_errors(content)]
    handed_on = [error.json_path for error in VALIDATOR.iter_errors(without_infinity(content))]
    assert [path for path, _ in found] == handed_on
    return found


def test_it_is_a_schema_in_strict_json() -> None:
    jsonschema.Draft202012Validator.check_schema(SCHEMA)
    json.dumps(SCHEMA, allow_nan=False)


@pytest.mark.parametrize("name", CASES)
def test_real_cases_are_valid(name: str) -> None:
    assert errors(CASES[name]) == []


@pytest.mark.parametrize(
    ("text", "replaced", "by", "path", "words"),
    [
        (MECHANICAL, "poisson_ratio", "poison_ratio", "$.material", "'poison_ratio' was unexpected"),
        (MECHANICAL, "poisson_ratio = 0.28", "", "$.material", "'poisson_ratio' is a required property"),
        (MECHANICAL, "poisson_ratio = 0.28", "poisson_ratio = 0.6", "$.material.poisson_ratio", "0.6 is greater than"),
        (MECHANICAL, "= 0.28", "= '0.28'", "$.material.poisson_ratio", "is not of type 'number'"),
        (TWO, "expansion_um_mK", "expansion_mm_mK", "$.material.lower", "'expansion_mm_mK' was unexpected"),
        (TWO, "[material.upper]", "[material.uper]", "$.material", "'upper' is a required property"),
        (TWO, "[material.upper]", "[material.uper]", "$.material", "'uper' was unexpected"),
        (TWO, "[material.lower]", "[material]\npoisson_ratio = 0.3\n[material.lower]", "$.material.poisson_ratio", "with [m"),
        (MECHANICAL, "upper_radius_x_mm = 30.0", "upper_radius_x_mm = 0", "$.geometry.upper_radius_x_mm", "0 should not"),
        (MECHANICAL, "normal_N", "normal_kN", "$.load", "'normal_kN' was unexpected"),
        (MECHANICAL, "grid = 16", "grid = 7", "$.numerics.grid", "7 is less than the minimum of 8"),
        (MECHANICAL, "grid = 16", "grid = [16, 16, 16]", "$.numerics.grid", "too long"),
        (MECHANICAL, "grid = 16", "grid = 16.5", "$.numerics.grid", "is not of type 'integer', 'array'"),
        (MECHANICAL, "grid = 16", "grid = 16\naccuracy = 1e-3", "$.numerics.accuracy", "with numerics.grid"),
        (MECHANICAL, "[numerics]", "[force]\nlongitudinal_N = 3\n[numerics]", "$.force.longitudinal_N", "with creepage.long"),
        (MECHANICAL, "[numerics]", "[thermal]\npartition = 'match'\n[numerics]", "$.thermal.partition", "not one of"),
        (MECHANICAL, "[numerics]", "[thermal]\npartition = 2\n[numerics]", "$.thermal.partition", "greater than the maximum"),
        (MECHANICAL, "[numerics]", "[termal]\n[numerics]", "$", "'termal' was unexpected"),
    ],
)
def test_a_mistake_is_told_where_it_is(text: str, replaced: str, by: str, path: str, words: str) -> None:
    mistaken = text.replace(replaced, by, 1)
    assert mistaken != text
    with pytest.raises(CaseError):
        Case.parse(mistaken)
    found = errors(mistaken)
    assert any(at == path and words in message for at, message in found), found
    assert not any("under any of the given schemas" in message for _, message in found)


@pytest.mark.parametrize("key", [f"{body}_radius_{axis}_mm" for body in ("lower", "upper") for axis in "xy"])
def test_flat_is_inf(key: str) -> None:
    assert errors(MECHANICAL.replace(f"{key} = 30.0", f"{key} = inf")) == []


def test_nothing_else_is_infinite() -> None:
    ((path, _),) = errors(MECHANICAL.replace("normal_N = 65.0", "normal_N = inf"))
    assert path == "$.load.normal_N"
