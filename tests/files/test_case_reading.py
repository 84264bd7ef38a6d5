"""A valid case becomes the right problem in SI units; the JSON schema, as an editor uses it, accepts the same cases."""

from __future__ import annotations

import json
import math
import tomllib
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest

from tests.support.cases import parse
from tests.support.command_line import MECHANICAL, THERMAL
from thermoroll_cli.cli.cases import TEMPLATES, template_text
from thermoroll_cli.files.case import Case, CaseError, Override, case_name
from thermoroll_cli.files.case_schema import case_schema
from thermoroll_cli.files.case_source import apply_overrides


def test_keys_are_read_by_their_names() -> None:
    settings = Case.parse(MECHANICAL).settings
    assert settings["load"]["normal_N"] == settings.load.normal_N
    with pytest.raises(KeyError, match=r"normal: there are .*normal_N, "):
        settings["load"]["normal"]


def test_everything_but_the_essentials_has_a_default() -> None:
    text = MECHANICAL[: MECHANICAL.index("[creepage]")]
    problem = parse(text).problem
    assert (problem.motion.creepage_x, problem.motion.creepage_y, problem.motion.spin) == (0.0, 0.0, 0.0)
    assert problem.numerics.grid is None
    assert problem.numerics.accuracy == 1e-3
    assert problem.numerics.extent == 2.2


def test_heat_follows_the_thermal_constants_where_nothing_is_said() -> None:
    assert not parse(MECHANICAL).problem.heating.heat
    heating = parse(THERMAL).problem.heating
    assert heating.heat and heating.deformation
    assert (heating.peclet, heating.partition) == ("rolling", 0.5)
    assert not parse(THERMAL, "thermal.heat=false").problem.heating.heat
    assert not parse(MECHANICAL, "thermal.heat=false").problem.heating.heat


def test_override_replaces_and_adds() -> None:
    case = parse(THERMAL, "load.normal_N=80", "creepage.lateral=.001", "thermal.peclet=stationary", "title=Other one")
    assert case.problem.normal_force == 80.0
    assert case.problem.motion.creepage_y == 0.001
    assert case.problem.heating.peclet == "stationary"
    assert case.problem.title == "Other one"
    assert case.text == THERMAL


@pytest.mark.parametrize("text", ["1\n[load]", "[1, 2", "a b"])
def test_override_that_is_no_toml_value_is_text(text: str) -> None:
    assert Override.parse(f"title={text}").value == text


@pytest.mark.parametrize("text", ["load.normal_N", "=3", ""])
def test_override_needs_key_and_value(text: str) -> None:
    with pytest.raises(ValueError, match="key=value"):
        Override.parse(text)


def test_override_replaces_what_it_excludes() -> None:
    assert parse(MECHANICAL, "numerics.accuracy=1e-2").problem.numerics.grid is None
    with pytest.raises(CaseError, match="cannot be given together"):
        parse(MECHANICAL, "numerics.accuracy=1e-2", "numerics.grid=32")


def test_with_values() -> None:
    case = parse(THERMAL).with_values({"rolling.speed_m_s": 5, "numerics.accuracy": 1e-2})
    assert case.problem.motion.speed == 5.0
    assert case.problem.numerics.grid is None
    assert parse(THERMAL).with_values({}).settings == parse(THERMAL).settings
    with pytest.raises(CaseError, match=r"load\.normal_N"):
        case.with_values({"load.normal_N": -1})


@pytest.mark.parametrize(
    "text", [MECHANICAL, THERMAL, MECHANICAL.replace("lower_radius_y_mm = 30.0", "lower_radius_y_mm = inf")]
)
def test_resolved_case_gives_the_same_case(text: str) -> None:
    case = parse(text)
    assert Case.parse(case.to_toml()).settings == case.settings
    assert Case.from_json(case.to_json()).settings == case.settings
    resolved = json.loads(case.to_json(), parse_constant=lambda name: pytest.fail(f"{name} is not JSON"))
    assert resolved["numerics"] == {"grid": 16, "extent": 2.2}
    assert resolved["creepage"] == {"longitudinal": 0.003, "lateral": 0.0, "spin_rad_mm": 0.0, "at": "origin"}


def test_from_json_refuses_other_texts() -> None:
    for text in ("", "{", "[1]", '"a"', "{}", '{"geometry": 3}'):
        with pytest.raises(CaseError):
            Case.from_json(text)


def test_reading_files(tmp_path: Path) -> None:
    path = tmp_path / "ein Fäll.v2.toml"
    path.write_bytes(b"\xef\xbb\xbf" + MECHANICAL.replace("\n", "\r\n").encode())
    case = Case.read(path)
    assert case.name == "ein Fäll.v2"
    assert case.settings == parse(MECHANICAL).settings
    assert case_name("-") == "stdin"


@pytest.mark.parametrize("overrides", [
    ["force.longitudinal_N=15"], ["force.lateral_N=-3", "creepage.spin_rad_mm=0.01"],
    ["thermal.partition=matched", "thermal.peclet=sliding"],
])
def test_features_beyond_the_first_are_read(overrides: list[str]) -> None:
    case = parse(THERMAL, *overrides)
    motion, force = case.problem.motion, case.settings.force
    assert (motion.force_x, motion.force_y) == (force.longitudinal_N, force.lateral_N)
    assert (motion.creepage_x is None, motion.creepage_y is None) == (motion.force_x is not None, motion.force_y is not None)
    assert case.problem.heating.partition == ("matched" if "matched" in overrides[0] else 0.5)
    assert Case.parse(case.to_toml()).settings == case.settings
    assert Case.from_json(case.to_json()).settings == case.settings


def test_cases_from_python() -> None:
    content = {
        "material": {"youngs_modulus_GPa": np.float64(210.0), "poisson_ratio": 0.28},
        "geometry": {f"{body}_radius_{axis}_mm": 30.0 for body in ("lower", "upper") for axis in "xy"},
        "load": {"normal_N": 65, "friction_coefficient": 0.3},
        "rolling": {"speed_m_s": 1.0},
        "creepage": {"longitudinal": 0.003, "lateral": None},
        "numerics": {"grid": np.array([16, 16])},
    }
    case = Case.from_dict(content, name="spheres")
    assert case.problem == parse(MECHANICAL, "title=", "numerics.grid=[16, 16]").problem
    assert Case.parse(case.text) == case == Case.of(content) == Case.of(case) and hash(Case.of(content)) == hash(case)
    assert case != case.with_values({"load.normal_N": 66.0})
    content["load"]["normal_N"] = -1.0
    content["lod"] = {}
    with pytest.raises(CaseError) as caught:
        Case.from_dict(content)
    assert [finding.key for finding in caught.value.findings] == ["lod", "load.normal_N"]
    assert "load.normal_N = -1.0: must be greater than 0" in str(caught.value) and "--set" not in str(caught.value)


def test_cases_show_themselves(tmp_path: Path) -> None:
    (tmp_path / "spheres.toml").write_text(MECHANICAL.replace("Two spheres", "Two <spheres>"))
    case = Case.of(tmp_path / "spheres.toml")
    assert repr(case) == "<Case spheres: Two <spheres>>" and len(repr(case.with_values({"title": ""}))) < 30
    table = case._repr_html_()
    assert "<tr><td>geometry.lower_radius_x_mm</td><td>30</td><td>0.03 m</td></tr>" in table
    assert "spheres: Two &lt;spheres&gt;</caption>" in table


def test_lists_of_tables_are_set_by_number() -> None:
    content = {"layers": [{"thickness_um": 1.0}, {"thickness_um": 2.0}]}
    apply_overrides(content, [Override.parse("layers.1.thickness_um=3")])
    assert content["layers"][1]["thickness_um"] == 3
    for wrong in ("layers.2.thickness_um=1", "layers.thickness_um=1"):
        with pytest.raises(CaseError):
            apply_overrides(content, [Override.parse(wrong)])


CASES = {path.name: path.read_text() for path in sorted((Path(__file__).parents[2] / "cases").glob("*.toml"))}
CASES |= {f"template {name}": template_text(name) for name in TEMPLATES}
SCHEMA = case_schema()
VALIDATOR = jsonschema.Draft202012Validator(SCHEMA)
TWO = THERMAL.replace("[material]", "[material.lower]", 1).replace(
    "[geometry]", "[material.upper]\nyoungs_modulus_GPa = 70\npoisson_ratio = 0.3\n[geometry]"
)


@pytest.mark.parametrize("name", ["article_4_1", "measured_wheelset", "angular_contact", "gear_pair", "corrugation"])
def test_a_valid_case_is_read_without_the_schema(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """It takes longer than all else of reading a case, and only errors need it."""
    monkeypatch.setattr("thermoroll_cli.files.case_schema._schema", lambda: pytest.fail("the schema was made"))
    Case.read(Path(__file__).parents[2] / "cases" / f"{name}.toml")


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


@pytest.mark.parametrize(("text", "replaced", "by", "path", "words"), [
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
])
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
