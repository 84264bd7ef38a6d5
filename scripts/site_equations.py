"""Equations of the site as MathML, and symbols in its sentences and tables as symbols with an index. They are made when it is
built (a hook of MkDocs, see mkdocs.yml): they need neither scripts nor a network."""

from __future__ import annotations

import html
import re
from typing import Any

from latex2mathml.converter import convert

EQUATION = re.compile(r'<(span|div) class="arithmatex">\\[(\[](.*?)\\[)\]]</\1>', re.DOTALL)
FUNCTION = re.compile(r"(<mi>(?:cos|sin|tan|ln|exp)</mi>)")
TAG = re.compile(r"\\tag\{(.*?)\}")
PRIME = re.compile(r"<msup>(<mi>[^<]*</mi>)<mi>&#x02032;</mi></msup>"
                   r"|<msubsup>((?:<mi>[^<]*</mi>){2})<mi>&#x02032;</mi></msubsup>")
"""A prime, which the converter raises: the character stands high already, and would become a speck."""
SYMBOL = re.compile(r"((?:(?<![A-Za-z_.])(?<![A-Za-z_]\d)(?:Pe|[Δδ]?[A-Za-z])|[α-ω])['′]?)"
                    r"_(?:\{([^{}<]+)\}|([a-zα-ω0-9]{1,5}|vM|F)(?![A-Za-z0-9_]))")
NOT_WORDS = re.compile(r"(<(pre|code|math|script|svg)\b.*?</\2>|<[^>]*>)", re.DOTALL)
"""Tags, and elements whose text stays as it is."""


def on_page_content(content: str, **_: Any) -> str:
    """The page's HTML with every equation typeset, and with F_x and γ_st as letters with an index."""
    words = NOT_WORDS.split(EQUATION.sub(_typeset, content))
    # Of each three parts the first is text, the others are what it was split at, and the name of its tag.
    words[::3] = [SYMBOL.sub(r"<i>\1</i><sub>\2\3</sub>", text) for text in words[::3]]
    del words[2::3]
    return "".join(words)


def _typeset(found: re.Match[str]) -> str:
    """One equation; its number, which MathML has no element for, stands beside it."""
    source, block = html.unescape(found[2]).strip(), found[1] == "div"
    numbers = [f'<span class="number">({html.escape(number)})</span>' for number in TAG.findall(source)]
    # The converter takes `\{` behind `\left` for the begin of a group.
    source = TAG.sub("", source).replace(r"\left\{", r"\left\lbrace").replace(r"\right\}", r"\right\rbrace")
    thin = '<mspace width="0.17em"/>'
    mathml = FUNCTION.sub(rf"{thin}\1{thin}", convert(source, display="block" if block else "inline"))
    mathml = mathml.replace('<mo stretchy="false">&#x0007C;</mo>', '<mo stretchy="false" lspace="0" rspace="0">&#x0007C;</mo>')
    mathml = PRIME.sub(lambda raised: f"<mrow>{raised[1] or f'<msub>{raised[2]}</msub>'}<mi>&#x02032;</mi></mrow>", mathml)
    return f'<div class="equation">{mathml}{"".join(numbers)}</div>' if block else mathml
