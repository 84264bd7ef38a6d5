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


@pytest.mark.parametrize("line", ["normal_N = -65.0", "normal_N = 1979-05-27", f"normal_N = 1{'0' * 400}", "normal_kN = 65"])
def test_an_error_stands_at_its_value_or_unknown_key(line: str) -> None:
    (finding,) = findings(changed("normal_N", line))
    assert finding.source == "bad.toml" and finding.span is not None
    assert (finding.span.line, finding.span.column) == (11, 1 if "kN" in line else line.index("=") + 3)
    assert line.endswith(finding.value) or finding.value.endswith("…")


@pytest.mark.parametrize(("override", "key"), [
    ("load.normal_N=-5", "load.normal_N"), ("load.normal_kN=5", "load.normal_kN"), ("lod.normal_N=5", "lod"),
    ("load.normal_N.x=5", "")])
def test_an_error_of_an_override_names_it(override: str, key: str) -> None:
    (finding,) = findings(MECHANICAL, override)
    assert finding.key == key and finding.render().startswith(f"--set {override}: error: ")


def test_keys_that_exclude_each_other_are_named_with_both_places() -> None:
    (finding,) = findings(MECHANICAL + "accuracy = 1e-3\n")
    assert finding.span is not None and finding.span.line == 19 and "together with numerics.grid (line 18)" in finding.message


def test_missing_keys_stand_at_their_table() -> None:
    finding, other = findings(MECHANICAL.replace("normal_N = 65.0\nfriction_coefficient = 0.3\n", ""))
    assert {finding.key, other.key} == {"load.normal_N", "load.friction_coefficient"}
    assert finding.message == "is missing"
    assert finding.line_text == "[load]"


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
    pytest.param("manchester", {"history": OVER_TIME}, marks=pytest.mark.slow), ("crossing", {}), ("angular_contact", {}),
    ("dent", {})])
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
