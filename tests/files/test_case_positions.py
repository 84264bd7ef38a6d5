"""Every key of a TOML text is found where it stands."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from thermoroll_cli.files.case_errors import KeyPath, Places, Span

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


@pytest.mark.parametrize("text", ["a", "a = ", "[", "[[a", '"', "a = [", "a = {b", "= 3", "a = 'x\n'", "é = 1", '"\\q" = 1'])
def test_broken_texts_raise_nothing(text: str) -> None:
    Places(text)


@given(st.text(st.sampled_from("ab.= []{}\"'#\n1\\"), max_size=40))
@settings(max_examples=100, deadline=None)
def test_no_text_raises(text: str) -> None:
    Places(text)
