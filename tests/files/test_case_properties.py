"""What must hold for any case: units, round trips, and no text that breaks the reader."""

from __future__ import annotations

import math
from typing import Any

import pytest
import tomli_w
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from thermoroll_cli.files.case import Case, CaseError

BOUNDED = settings(max_examples=12, deadline=None)


def numbers(low: float, high: float) -> st.SearchStrategy[float]:
    """Over all decades from `low` to `high`."""
    return st.floats(math.log10(low), math.log10(high)).map(lambda power: min(max(10.0**power, low), high))


RADII = st.one_of(numbers(1e-3, 1e3), st.just(math.inf))
SHARED = st.fixed_dictionaries({"youngs_modulus_GPa": numbers(1e-9, 1e6), "poisson_ratio": st.floats(0, 0.5)})
CONSTANTS = st.fixed_dictionaries(
    {"conductivity_W_mK": numbers(1e-6, 1e6), "expansion_um_mK": numbers(1e-6, 1e6), "diffusivity_mm2_s": numbers(1e-9, 1e12)}
)
CREEPAGE = st.floats(-1e6, 1e6)


@st.composite
def cases(draw: st.DrawFn) -> dict[str, Any]:
    """Valid cases over everything that a case file may hold."""
    thermal = draw(st.booleans())
    elastic = draw(SHARED)
    if draw(st.booleans()):
        material: dict[str, Any] = elastic | (draw(CONSTANTS) if thermal else {})
    else:
        material = {body: elastic | (draw(CONSTANTS) if thermal else {}) for body in ("lower", "upper")}
    content: dict[str, Any] = {
        "material": material,
        "geometry": {
            f"{body}_radius_{axis}_mm": draw(RADII if body == "lower" else numbers(1e-3, 1e3))
            for body in ("lower", "upper")
            for axis in "xy"
        },
        "load": {"normal_N": draw(numbers(1e-6, 1e6)), "friction_coefficient": draw(st.just(0.0) | st.floats(1e-12, 2))},
        "rolling": {"speed_m_s": draw(numbers(1e-6, 1e6))},
    }
    optional = {
        "title": st.text(st.characters(categories=["L", "N", "P", "S"]), max_size=20),
        "creepage": st.fixed_dictionaries({}, optional=dict.fromkeys(("longitudinal", "lateral", "spin_rad_mm"), CREEPAGE)),
        "numerics": st.one_of(
            st.fixed_dictionaries({"grid": st.integers(8, 2048)}, optional={"extent": st.floats(1.2, 6)}),
            st.fixed_dictionaries({"grid": st.lists(st.integers(8, 2048), min_size=2, max_size=2)}),
            st.fixed_dictionaries({"accuracy": numbers(1e-5, 0.1)})),
        "output": st.fixed_dictionaries({"plots": st.booleans()}),
    }  # fmt: skip
    if thermal:
        peclet = st.sampled_from(["rolling", "stationary"])
        optional["thermal"] = st.fixed_dictionaries({}, optional={
            "heat": st.booleans(), "deformation": st.booleans(), "peclet": peclet, "partition": st.floats(0, 1)})
    for key, strategy in optional.items():
        if draw(st.booleans()):
            content[key] = draw(strategy)
    return content


def parsed(content: dict[str, Any]) -> Case:
    """The case; another one is drawn if it is refused because it moves too fast for its heat."""
    try:
        return Case.parse(tomli_w.dumps(content))
    except CaseError as error:
        assume("Péclet" not in str(error))
        raise


@given(cases())
@BOUNDED
def test_round_trip_through_toml_and_json(content: dict[str, Any]) -> None:
    case = parsed(content)
    again = Case.parse(case.to_toml())
    assert again.settings == case.settings
    assert again.problem == case.problem
    assert again.to_toml() == case.to_toml()
    assert Case.from_json(case.to_json()).settings == case.settings


@given(cases())
@BOUNDED
def test_units(content: dict[str, Any]) -> None:
    problem = parsed(content).problem
    for body, material in (("lower", problem.lower), ("upper", problem.upper)):
        given_material = content["material"].get(body, content["material"])
        assert material.youngs_modulus == pytest.approx(given_material["youngs_modulus_GPa"] * 1e9, rel=1e-15)
        for name, key, unit in (
            ("conductivity", "conductivity_W_mK", 1.0), ("expansion", "expansion_um_mK", 1e-6),
            ("diffusivity", "diffusivity_mm2_s", 1e-6)):
            value = given_material.get(key)
            assert getattr(material, name) == (None if value is None else pytest.approx(value * unit, rel=1e-15))
        for axis in "xy":
            radius = content["geometry"][f"{body}_radius_{axis}_mm"]
            assert getattr(problem.geometry, f"{body}_radius_{axis}") == pytest.approx(radius * 1e-3, rel=1e-15)
    creepage = content.get("creepage", {})
    assert problem.motion.creepage_x == creepage.get("longitudinal", 0.0)
    assert problem.motion.creepage_y == creepage.get("lateral", 0.0)
    assert problem.motion.spin == pytest.approx(creepage.get("spin_rad_mm", 0.0) * 1e3, rel=1e-15)
    assert problem.normal_force == content["load"]["normal_N"]
    assert problem.motion.speed == content["rolling"]["speed_m_s"]
    assert (problem.numerics.grid is None) != (problem.numerics.accuracy is None)


ANYTHING = st.one_of(
    st.just({}), st.integers(), st.floats(), st.booleans(), st.text(max_size=10), st.lists(st.integers(), max_size=3),
    st.dictionaries(st.text(max_size=5), st.integers(), max_size=2))  # fmt: skip


@given(cases(), st.data())
@BOUNDED
def test_any_wrong_value_is_an_error_with_its_key_or_a_valid_case(content: dict[str, Any], data: st.DataObject) -> None:
    table = data.draw(st.sampled_from(sorted(key for key, value in content.items() if isinstance(value, dict) and value)))
    key = data.draw(st.sampled_from(sorted(content[table])))
    content[table][key] = data.draw(ANYTHING)
    try:
        text = tomli_w.dumps(content)
    except UnicodeEncodeError:
        return
    try:
        problem = Case.parse(text, name="x.toml").problem
    except CaseError as cause:
        assert all(finding.key.split(".")[0] in {*content, "material"} for finding in cause.findings)
        assert all(finding.render().startswith("x.toml") for finding in cause.findings)
    else:
        assert not math.isnan(problem.normal_force)


@given(st.text(max_size=60))
@BOUNDED
def test_no_text_breaks_the_reader(text: str) -> None:
    with pytest.raises(CaseError) as caught:
        Case.parse(text)
    assert caught.value.findings
