"""Every key of a TOML text is found where it stands."""

from __future__ import annotations

import tomllib
from typing import Any

import pytest
import tomli_w
from hypothesis import given, settings
from hypothesis import strategies as st

from thermoroll_cli.files.case.toml_positions import KeyPath, Span, locate_keys

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
n = 2'''


def test_places() -> None:
    entries = locate_keys(TEXT)
    expected: dict[KeyPath, tuple[Span, Span]] = {
        ("top",): (Span(2, 1, 3), Span(2, 7, 1)),
        ("quoted key",): (Span(3, 1, 12), Span(3, 16, 7)),
        ("table",): (Span(4, 1, 7), Span(4, 1, 7)),
        ("table", "a"): (Span(5, 1, 3), Span(5, 1, 3)),
        ("table", "a", "b"): (Span(5, 1, 3), Span(5, 7, 16)),
        ("table", "a", "b", 2): (Span(6, 3, 1), Span(6, 3, 1)),
        ("table", "inline", "x"): (Span(7, 12, 1), Span(7, 16, 1)),
        ("table", "inline", "y z", 0, "w"): (Span(7, 31, 1), Span(7, 35, 3)),
        ("table", "many"): (Span(8, 1, 4), Span(8, 8, 3)),
        ("table", "sub"): (Span(12, 1, 11), Span(12, 1, 11)),
        ("table", "sub", "last"): (Span(13, 1, 4), Span(13, 8, 19)),
        ("list", 1, "n"): (Span(17, 1, 1), Span(17, 5, 1)),
    }
    for path, (key, value) in expected.items():
        assert (entries[path].key, entries[path].value) == (key, value), path
    assert ("table", "k") not in entries


@pytest.mark.parametrize("text", ["a", "a = ", "[", "[[a", '"', "a = [", "a = {b", "= 3", "a = 'x\n'", "é = 1"])
def test_broken_texts_raise_nothing(text: str) -> None:
    locate_keys(text)


def paths(content: Any, prefix: KeyPath = ()) -> set[KeyPath]:
    items = content.items() if isinstance(content, dict) else enumerate(content) if isinstance(content, list) else ()
    return {prefix} | {path for key, value in items for path in paths(value, (*prefix, key))}


SCALARS = st.one_of(st.integers(-(2**63), 2**63 - 1), st.floats(), st.booleans(), st.text(max_size=8), st.dates())
KEYS = st.text(st.characters(exclude_categories=["Cs"]), max_size=3)
CONTENT = st.dictionaries(
    KEYS,
    st.recursive(SCALARS, lambda inner: st.one_of(st.lists(inner, max_size=3), st.dictionaries(KEYS, inner, max_size=3))),
    max_size=4,
)


@given(CONTENT)
@settings(max_examples=50, deadline=None)
def test_every_key_of_any_toml_is_found(content: dict[str, Any]) -> None:
    text = tomli_w.dumps(content)
    entries = locate_keys(text)
    assert paths(tomllib.loads(text)) - {()} == set(entries)
