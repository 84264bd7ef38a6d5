"""Equations of the site as MathML, made when it is built (a hook of MkDocs, see mkdocs.yml): they need neither scripts nor a
network."""

from __future__ import annotations

import html
import re
from typing import Any

from latex2mathml.converter import convert

EQUATION = re.compile(r'<(span|div) class="arithmatex">\\[(\[](.*?)\\[)\]]</\1>', re.DOTALL)
FUNCTION = re.compile(r"(<mi>(?:cos|sin|tan|ln|exp)</mi>)")
TAG = re.compile(r"\\tag\{(.*?)\}")


def on_page_content(content: str, **_: Any) -> str:
    """The page's HTML with every equation typeset."""
    return EQUATION.sub(_typeset, content)


def _typeset(found: re.Match[str]) -> str:
    """One equation; its number, which MathML has no element for, stands beside it."""
    source, block = html.unescape(found[2]).strip(), found[1] == "div"
    numbers = [f'<span class="number">({html.escape(number)})</span>' for number in TAG.findall(source)]
    # The converter takes `\{` behind `\left` for the begin of a group.
    source = TAG.sub("", source).replace(r"\left\{", r"\left\lbrace").replace(r"\right\}", r"\right\rbrace")
    thin = '<mspace width="0.17em"/>'
    mathml = FUNCTION.sub(rf"{thin}\1{thin}", convert(source, display="block" if block else "inline"))
    return f'<div class="equation">{mathml}{"".join(numbers)}</div>' if block else mathml
