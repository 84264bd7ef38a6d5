"""Everything that can be wrong with a case is reported, with its place, what is allowed, and what was meant."""

from __future__ import annotations

import contextlib
import datetime as dt
import itertools
import re
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.support.cases import findings
from tests.support.command_line import MECHANICAL, THERMAL
from tests.support.documents import ROOT
from thermoroll_cli.files.case import Case, CaseError, Override
from thermoroll_cli.files.case_errors import Finding, KeyPath, Places, Span
from thermoroll_cli.files.case_model import Settings
from thermoroll_cli.files.case_schema import known_keys
from thermoroll_cli.files.case_source import SIZE_LIMIT


def changed(key: str, line: str) -> str:
    """The case with the line of `key` replaced."""
    lines = MECHANICAL.splitlines()
    return "\n".join(line if old.startswith(f"{key} ") else old for old in lines) + "\n"


@pytest.mark.parametrize(("key", "line", "message", "allowed"), [
    ("normal_N", "normal_N = -65.0", "must be greater than 0", "1e-15 to 1e15, in N"),
    ("normal_N", "normal_N = 0", "must be greater than 0", "1e-15"),
    ("friction_coefficient", "friction_coefficient = 5e-324", "too small to be computed with", "1e-12 to 10"),
    ("normal_N", "normal_N = nan", "nan is not a number", "1e-15"),
    ("normal_N", "normal_N = inf", "must be finite", "1e-15"),
    ("normal_N", "normal_N = true", "must be a number", "1e-15"),
    ("normal_N", 'normal_N = "65"', "must be a number", "1e-15"),
    ("normal_N", "normal_N = [65]", "must be a number", "1e-15"),
    ("normal_N", "normal_N = 1979-05-27", "must be a number", "1e-15"),
    ("normal_N", f"normal_N = 1{'0' * 400}", "must be finite", "1e-15"),
    ("poisson_ratio", "poisson_ratio = 0.6", "above the allowed range", "from 0 to 0.5"),
    ("poisson_ratio", "poisson_ratio = -0.1", "below the allowed range", "from 0 to 0.5"),
    ("youngs_modulus_GPa", "youngs_modulus_GPa = 0.0", "must be greater than 0", "in GPa"),
    ("friction_coefficient", "friction_coefficient = -0.1", "below the allowed range", "from 0 to 10"),
    ("friction_coefficient", "friction_coefficient = 30", "above the allowed range", "from 0 to 10"),
    ("speed_m_s", "speed_m_s = 0", "must be greater than 0", "in m/s"),
    ("upper_radius_x_mm", "upper_radius_x_mm = 0.0", "must not be zero", "inf (flat)"),
    ("upper_radius_x_mm", "upper_radius_x_mm = nan", "nan is not a number", "inf (flat)"),
    ("upper_radius_x_mm", "upper_radius_x_mm = -inf", "outside the allowed range", "inf (flat)"),
    ("upper_radius_x_mm", "upper_radius_x_mm = true", "must be a number", "inf (flat)"),
    ("longitudinal", "longitudinal = inf", "must be finite", "-1e6 to 1e6"),
    ("grid", "grid = 7", "outside the allowed range", "from 8 to 2048"),
    ("grid", "grid = 2049", "outside the allowed range", "from 8 to 2048"),
    ("grid", "grid = 16.0", "must be a whole number", "from 8 to 2048"),
    ("grid", "grid = true", "must be a whole number", "from 8 to 2048"),
    ("grid", "grid = [16]", "must be a whole number", "[nx, ny]"),
    ("grid", "grid = [16, 4]", "outside the allowed range", "[nx, ny]"),
    ("grid", "accuracy = 1.0", "above the allowed range", "1e-5 to 0.1"),
    ("grid", "extent = 1.0", "below the allowed range", "1.2 to 6"),
    ("title", "title = 3", "must be text in quotes", "one line"),
    ("title", 'title = "a\\u001b[2Jb"', "one line without control characters", "one line"),
    ("title", f'title = "{"a" * 201}"', "is too long", "200 characters"),
])
def test_bad_values(key: str, line: str, message: str, allowed: str) -> None:
    (finding,) = findings(changed(key, line))
    number = MECHANICAL.splitlines().index(next(old for old in MECHANICAL.splitlines() if old.startswith(f"{key} "))) + 1
    assert message in finding.message
    assert allowed in finding.allowed
    assert finding.source == "bad.toml"
    assert finding.span is not None
    assert (finding.span.line, finding.span.column) == (number, line.index("=") + 3)
    assert finding.key.split(".")[-1] == line.split()[0]
    assert (finding.value and line.endswith(finding.value)) or finding.value.endswith("…")


@pytest.mark.parametrize(("table", "line", "hint"), [
    ("thermal", 'heat = "true"', "true and false are written without quotes"),
    ("thermal", "heat = 1", ""), ("thermal", 'peclet = "roling"', 'did you mean "rolling"?'), ("thermal", "peclet = 3", ""),
    ("thermal", "partition = 1.5", ""), ("thermal", "partition = nan", ""),
    ("thermal", 'partition = "match"', 'did you mean "matched"?'),
    ("output", "plots = 0", ""), ("output", 'plots = "sumary"', 'did you mean "summary"?'),
    ("force", 'lateral_N = "3,5"', "a number is written with a point"),
])
def test_bad_values_of_optional_tables(table: str, line: str, hint: str) -> None:
    (finding,) = findings(f"{MECHANICAL}[{table}]\n{line}\n")
    assert finding.key == f"{table}.{line.split()[0]}"
    assert finding.allowed
    assert finding.hint.startswith(hint) and bool(finding.hint) == bool(hint)


@pytest.mark.parametrize(("key", "line", "hint"), [
    ("normal_N", "normal_kN = 65", 'did you mean "normal_N"? The unit is part of the key: N, not kN (1 kN is 1000 N)'),
    ("normal_N", "normal = 65", 'did you mean "normal_N"? The unit is part of the key: N, which is missing here'),
    ("normal_N", "normal_n = 65", 'did you mean "normal_N"?'),
    ("friction_coefficient", "friction_coeficient = 0.3", 'did you mean "friction_coefficient"?'),
    ("youngs_modulus_GPa", "youngs_modulus_MPa = 210e3", 'did you mean "youngs_modulus_GPa"?'),
    ("speed_m_s", "speed_km_h = 3.6", 'did you mean "speed_m_s"?'),
    ("upper_radius_y_mm", "upper_radius_y_m = 0.03", 'did you mean "upper_radius_y_mm"?'),
    ("longitudinal", "longitudinal_percent = 0.3", 'did you mean "longitudinal"?'),
    ("longitudinal", "SRR_percent = 0.3", 'did you mean "longitudinal"? (1 % is 0.01)'),
    ("longitudinal", '"SRR [%]" = 0.3', 'did you mean "longitudinal"? (1 % is 0.01)'),
    ("longitudinal", "slip = 0.3", 'did you mean "longitudinal"?'),
    ("friction_coefficient", '"µ" = 0.3', 'did you mean "friction_coefficient"?'),
    ("friction_coefficient", "COF = 0.3", 'did you mean "friction_coefficient"?'),
    ("youngs_modulus_GPa", "E_MPa = 210e3", 'did you mean "youngs_modulus_GPa"? (1 MPa is 0.001 GPa)'),
    ("poisson_ratio", "nu = 0.3", 'did you mean "poisson_ratio"?'),
    ("title", '"tan δ" = 0.1', 'did you mean "material.relaxation_file"?'),
    ("longitudinal", "longitudinal_N = 3", "longitudinal_N belongs in [force]"),
    ("longitudinal", "friction_coefficient = 3", "friction_coefficient belongs in [load]"),
    ("longitudinal", "xyz = 3", "known here: longitudinal, lateral, spin_rad_mm"),
    ("[numerics]", "[numeric]", 'did you mean "numerics"?'), ("title", "normal_N = 3", "normal_N belongs in [load]"),
    ("title", "normal = 3", 'did you mean "load.normal_N"?'), ("[load]", "[lod]", 'did you mean "load"?'),
])
def test_unknown_keys(key: str, line: str, hint: str) -> None:
    text = changed(key, line) if not key.startswith("[") else MECHANICAL.replace(key, line)
    (finding,) = findings(text)  # one error: the key that is now missing is the misspelt one
    assert finding.message == "unknown key"
    assert finding.hint.startswith(hint)
    assert finding.span is not None
    assert text.splitlines()[finding.span.line - 1] == line


def test_missing_keys_stand_at_their_table() -> None:
    finding, other = findings(MECHANICAL.replace("normal_N = 65.0\nfriction_coefficient = 0.3\n", ""))
    assert {finding.key, other.key} == {"load.normal_N", "load.friction_coefficient"}
    assert finding.message == "is missing"
    assert finding.line_text == "[load]"


def test_missing_tables_name_their_keys() -> None:
    all_of_them = findings("title = 'x'")
    assert [finding.key for finding in all_of_them] == ["material", "geometry", "load", "rolling"]
    assert "friction_coefficient" in all_of_them[2].hint


@pytest.mark.parametrize("name", ["material", "geometry", "load", "thermal", "numerics", "output"])
def test_tables_must_be_tables(name: str) -> None:
    table = MECHANICAL.find(f"[{name}]")
    end = MECHANICAL.find("\n[", table + 1)
    text = f"{name} = 3\n" + (MECHANICAL if table < 0 else MECHANICAL[:table] + (MECHANICAL[end:] if end > 0 else ""))
    (finding,) = findings(text)
    assert finding.message == "must be a table"
    assert finding.span == Span(1, len(name) + 4, 1)


FORCED = MECHANICAL.replace("[creepage]\nlongitudinal = 0.003\n", "[force]\nlongitudinal_N = 25.0\n")
OWN = "poisson_ratio = 0.28\n[material.lower]\nyoungs_modulus_GPa = 210\npoisson_ratio = 0.28\n"
LACKING = "conductivity_W_mK, expansion_um_mK, diffusivity_mm2_s"


@pytest.mark.parametrize(("text", "override", "key", "message"), [
    (changed("lower_radius_y_mm", "lower_radius_y_mm = -20.0"), "", "geometry.lower_radius_y_mm",
     r"convexity lost along y.*geometry\.lower_radius_y_mm, geometry\.upper_radius_y_mm"),
    (changed("upper_radius_x_mm", "upper_radius_x_mm = -30.0"), "", "geometry.upper_radius_x_mm", "convexity lost along x"),
    (MECHANICAL.replace("x_mm = 30.0", "x_mm = inf"), "", "geometry.lower_radius_x_mm", "both bodies are flat"),
    (FORCED, "", "force.longitudinal_N", r"force of 25 N .* = 19\.5 N"),
    (FORCED, "force.lateral_N=15", "force.longitudinal_N", r"29\.1548 N"),
    (changed("longitudinal", "longitudinal = 0.0") + "[force]\nlongitudinal_N = 1.0\n", "", "force.longitudinal_N",
     r"cannot be given together with creepage\.longitudinal \(line 16\)"),
    (changed("longitudinal", "lateral = 0.0") + "[force]\nlateral_N = 1.0\n", "", "force.lateral_N",
     r"cannot be given together with creepage\.lateral \(line 16\)"),
    (MECHANICAL + "accuracy = 1e-3\n", "", "numerics.accuracy", r"together with numerics\.grid \(line 18\)"),
    (MECHANICAL + "[thermal]\n", "", "material", f"heat is on, but missing: {LACKING}"),
    (THERMAL.replace("expansion_um_mK = 11.7\n", ""), "", "material", "missing: expansion_um_mK$"),
    (MECHANICAL.replace("poisson_ratio = 0.28\n", OWN), "", "material.lower",
     r"constants of both bodies \(youngs_modulus_GPa, poisson_ratio\) cannot be given together with"),
    (MECHANICAL, "material.upper.youngs_modulus_GPa=70", "material.upper", r"together with \[material\.upper\]"),
    (MECHANICAL.replace("[material]", "[material.lower]"), "", "material.upper", "^is missing: the other body has its own"),
    (MECHANICAL.replace("[material]", "[material.upper]\nyoungs_modulus_GPa = 1\n[material.lower]"), "",
     "material.upper.poisson_ratio", "is missing"),
    (MECHANICAL, "load.normal_N=-5", "load.normal_N", "must be greater than 0"),
    (MECHANICAL, "load.normal_kN=5", "load.normal_kN", "unknown key"),
    (MECHANICAL, "lod.normal_N=5", "lod", "unknown key"), (MECHANICAL, "load.normal_N.x=5", "", "not a table"),
])  # fmt: skip
def test_keys_that_do_not_go_together(text: str, override: str, key: str, message: str) -> None:
    (finding,) = findings(text, *([override] if override else []))
    assert (finding.key, bool(re.search(message, finding.message))) == (key, True), finding.render()
    assert finding.source == "bad.toml" or finding.render().startswith(f"--set {override}: error: ")


def test_errors_in_thermal_beside_a_coated_body_are_errors_alone() -> None:
    layer = "[[material.layers]]\nthickness_um = 2.0\nyoungs_modulus_GPa = 300.0\npoisson_ratio = 0.2\n[geometry]"
    text = MECHANICAL.replace("[geometry]", layer) + "[subsurface]\n[thermal]\npeclet = 3\n"
    assert [finding.key for finding in findings(text)] == ["thermal.peclet"]


def test_all_errors_at_once_in_the_order_of_the_file() -> None:
    text = THERMAL.replace("= 0.28", "= 0.6").replace("normal_N", "normal_kN").replace("speed_m_s = 1.0", "speed_m_s = nan")
    text += "[outputs]\nplots = true\n"
    found = findings(text)
    assert [finding.key for finding in found] == ["material.poisson_ratio", "load.normal_kN", "rolling.speed_m_s", "outputs"]


@pytest.mark.parametrize(("text", "place", "hint"), [
    ("a = True\n", (1, 5), "small letters"), ("a = 1,5\n", (1, 6), "written with a point"),
    ("\n[load\n", (2, 6), "ends with ]"), ("a = rolling\n", (1, 5), "in quotes"), ("a =\n", (1, 4), "value is missing"),
    ("a = 65 N\n", (1, 8), "unit is part of the key"), ("a = .5\n", (1, 5), "digit before the point"),
    ("a = 5.\n", (1, 6), "digit after the point"), ("a: 5\n", (1, 2), "key = value"),
    ("a = [1,", (1, 8), ""),
])
def test_broken_toml(text: str, place: tuple[int, int], hint: str) -> None:
    (finding,) = findings(text)
    assert finding.message.startswith("broken TOML: ")
    assert finding.span is not None
    assert (finding.span.line, finding.span.column) == place
    assert hint in finding.hint and bool(finding.hint) == bool(hint)


@pytest.mark.parametrize(("text", "key", "first", "place"), [
    ("a = 1\na = 2\n", "a", 1, (2, 1)),
    (MECHANICAL + "[load]\nnormal_N = 3\n", "load", 10, (19, 1)),
    (changed("friction_coefficient", "normal_N = 3.0"), "load.normal_N", 11, (12, 1)),
    ("[creepage]\nspin = { a = 1, b = 2, a = 3 }\n", "creepage.spin.a", 2, (2, 24)),
    ("load.x = 1\n[load.x]\ny = 3\n", "load.x", 1, (2, 1)),
])
def test_what_is_there_twice_is_named_with_both_places(text: str, key: str, first: int, place: tuple[int, int]) -> None:
    (finding,) = findings(text)
    assert finding.key == key
    assert finding.message.endswith(f"is there twice, first in line {first}")
    assert finding.span is not None and (finding.span.line, finding.span.column) == place


@pytest.mark.parametrize("text", ["", "\n  \n", "# only a comment\n"])
def test_a_file_with_nothing_in_it(text: str) -> None:
    (finding,) = findings(text)
    assert finding.message == "there is nothing in it" and "thermoroll init" in finding.hint


@pytest.mark.parametrize("text", ["INF", "Infinity", "+inf", "inf"])
def test_infinity_as_scripts_print_it(text: str) -> None:
    case = Case.parse(MECHANICAL, overrides=[Override.parse(f"geometry.lower_radius_x_mm={text}")])
    assert case.settings.geometry.lower_radius_x_mm == float("inf")
    (finding,) = findings(MECHANICAL, f"load.normal_N={text}")
    assert finding.message == "must be finite"


def test_errors_in_python_do_not_speak_of_the_command_line() -> None:
    case = Case.parse(MECHANICAL)
    for values in ({"load.normal_N": -1}, {"lod.normal_N": 1}, {"load.normal_N.x": 1}):
        with pytest.raises(CaseError) as caught:
            case.with_values(values)
        assert str(caught.value).startswith("with_values ") and "--set" not in str(caught.value)
    assert case.with_values({"numerics.grid": np.int64(32)}).problem.numerics.grid == (32, 32)
    assert case.with_values({"numerics.grid": np.array([16, 32])}).problem.numerics.grid == (16, 32)
    assert case.with_values({"load.normal_N": np.float32(2.0)}).problem.normal_force == 2.0


TABLES = {"": known_keys(())} | {name: known_keys((name,)) for name in Settings.model_fields if name != "title"}
ODD = (True, 10**400, float("nan"), float("-inf"), [1], {"a": 1}, "", dt.date(2000, 1, 1))


def test_every_message_is_our_own() -> None:
    """Whatever stands at the keys of a table: no words of the library that checks it."""
    for (table, keys), value in itertools.product(TABLES.items(), ODD):
        paths = [(table, key) if table else (key,) for key in keys]
        try:
            Case.parse(MECHANICAL, overrides=[Override(path, value, f"{'.'.join(path)}={value}") for path in paths])
        except CaseError as cause:
            for finding in cause.findings:
                assert not re.search(r"[Vv]alue error|[Ii]nput should|valid (number|integer|string)", finding.message)
                assert finding.key


def damaged(value: Any) -> Iterator[Any]:
    """Copies of a table or a list without one of its keys, or with a text in place of a table or a list, at every depth."""
    if isinstance(value, dict):
        for key, each in value.items():
            yield {name: other for name, other in value.items() if name != key}
            yield from ({**value, key: other} for other in damaged(each))
    elif isinstance(value, list):
        yield from ([other, *value[1:]] for other in damaged(value[0]))
    if isinstance(value, dict | list):
        yield "text"


OVER_TIME = {"distance_mm": [0.0, 20.0], "values": {"wheelset.lateral_shift_mm": [0.0, 4.0], "rolling.speed_m_s": [2.0, 3.0]}}


@pytest.mark.parametrize(("name", "more"), [
    ("manchester", {"history": OVER_TIME}), ("crossing", {}), ("angular_contact", {}), ("dent", {})])
def test_what_is_missing_or_no_table_is_an_error_of_the_case(name: str, more: dict[str, Any], monkeypatch) -> None:
    """Checks find tables missing that were invalid: nothing else is raised."""
    monkeypatch.chdir(ROOT / "cases")
    for tables in damaged(tomllib.loads(Path(f"{name}.toml").read_text(encoding="utf-8")) | more):
        with contextlib.suppress(CaseError):
            Case.of(tables)


@pytest.mark.parametrize("text", ["a = " + "[" * 100_000, "a = " + "1" * 10_000, "a." * 100_000 + "a = 1"])
def test_absurd_toml(text: str) -> None:
    assert findings(text)


def test_unreadable_files(tmp_path: Path) -> None:
    def message(path: Path) -> str:
        with pytest.raises(CaseError) as caught:
            Case.read(path)
        (finding,) = caught.value.findings
        return finding.render()

    (tmp_path / "case.toml").write_text(MECHANICAL)
    assert "no such file" in message(tmp_path / "cas.toml")
    assert "did you mean" in message(tmp_path / "cas.toml") and "case.toml" in message(tmp_path / "cas.toml")
    assert "thermoroll init --example gear_pair writes cases/gear_pair.toml" in message(tmp_path / "cases" / "gear_pair.toml")
    assert "this is a folder" in message(tmp_path)
    (tmp_path / "latin.toml").write_bytes('title = "x"\nü'.encode("latin-1"))
    assert "latin.toml:2:1: error: not UTF-8 text: byte 0xfc" in message(tmp_path / "latin.toml")
    (tmp_path / "result.h5").write_bytes(b"\x89HDF\r\n\x1a\n" + bytes(1000))
    assert "this is an HDF5 file" in message(tmp_path / "result.h5")
    with open(tmp_path / "large.toml", "wb") as stream:
        stream.truncate(100_000_000)
    assert "too large" in message(tmp_path / "large.toml")
    (tmp_path / "just.toml").write_text(MECHANICAL + "#" * (SIZE_LIMIT - len(MECHANICAL)))
    assert Case.read(tmp_path / "just.toml")


def test_rendering_points_at_the_place() -> None:
    finding = Finding("is wrong", "a.b", "3", "5", "try 5", "x.toml", Span(12, 6, 3), "b\t = 345")
    assert finding.render().splitlines() == [
        "x.toml:12:6: error: a.b = 3: is wrong",
        "  12 | b  = 345",
        "     |      ^^^",
        "  allowed: 5",
        "  help: try 5",
    ]
    assert "\x1b[" in finding.render(colour=True)


def test_rendering_survives_any_line() -> None:
    wide = Finding("m", source="s", span=Span(1, 3, 1), line_text="漢字x")
    assert wide.render().splitlines()[-1] == "    |     ^"
    long = Finding("m", source="s", span=Span(1, 5000, 3), line_text="a" * 10_000)
    snippet, caret = long.render().splitlines()[1:]
    assert len(snippet) < 120 and "^^^" in caret
    escape = Finding("m\x1b[2J", source="s\n", span=Span(1, 1, 1), line_text="\x1b[2J")
    assert "\x1b" not in escape.render()
    assert Finding("m", source="s", span=Span(1, 9, 1), line_text="").render()


TEXT = '''\
# comment = 1
top = 1   # trailing
"quoted key" = 'a # b'
[table]  # header
a.b = [1, 2,  # inside
  3]
inline = { x = 1, "y z" = [ { w = "}" } ] }
many = """
[not.a.table]
k = 1 \\"""
"""
[table.sub]
last = 1979-05-27 07:32:00
[[list]]
n = 1
[[list]]
n = 2
[list.inner]
m = 3'''


def test_places() -> None:
    found = Places(TEXT).found
    expected: dict[KeyPath, tuple[Span, Span]] = {
        ("top",): (Span(2, 1, 3), Span(2, 7, 1)),
        ("quoted key",): (Span(3, 1, 12), Span(3, 16, 7)),
        ("table",): (Span(4, 1, 7), Span(4, 1, 7)),
        ("table", "a"): (Span(5, 1, 3), Span(5, 1, 3)),
        ("table", "a", "b"): (Span(5, 1, 3), Span(5, 7, 6)),
        ("table", "inline", "x"): (Span(7, 12, 1), Span(7, 16, 1)),
        ("table", "many"): (Span(8, 1, 4), Span(8, 8, 3)),
        ("table", "sub"): (Span(12, 1, 11), Span(12, 1, 11)),
        ("table", "sub", "last"): (Span(13, 1, 4), Span(13, 8, 19)),
        ("list", 1): (Span(16, 1, 8), Span(16, 1, 8)),
        ("list", 1, "n"): (Span(17, 1, 1), Span(17, 5, 1)),
        ("list", 1, "inner"): (Span(18, 1, 12), Span(18, 1, 12)),
        ("list", 1, "inner", "m"): (Span(19, 1, 1), Span(19, 5, 1)),
    }
    for path, (key, value) in expected.items():
        assert (found[path].key, found[path].value) == (key, value), path
    assert ("table", "k") not in found and ("not", "a", "table") not in found


@given(st.text(st.sampled_from("ab.= []{}\"'#\n1\\"), max_size=40))
@settings(max_examples=40, deadline=None)
def test_no_text_raises(text: str) -> None:
    Places(text)
