"""Conversion of formulas from docstrings to Markdown, and from the site's pages to MathML.

Browsers draw MathML by themselves, so the pages need no script and no network for it.
"""

import re

from docutils.nodes import SkipNode
from latex2mathml.converter import convert

from mecano.deck.plain_maths import DISPLAY, INLINE

PAGE = re.compile(r"(?<![\w/`\[])(?<!\]\()(?:docs/)?([a-z][\w-]*\.md)(?!\])")


def markdown_of(doc):
    """Return a docstring as Markdown for a page of the reference, two folders below docs/."""
    doc = DISPLAY.sub(_block, doc.strip())
    doc = INLINE.sub(r"{math}`\1`", doc)
    return PAGE.sub(r"[\1](../../\1)", doc)


def _block(match):
    lines = "\n".join(line.strip() for line in match[2].splitlines())
    return f"\n```{{math}}\n{lines}\n```\n"


def inline(translator, node):
    """Write an inline formula (a visitor of Sphinx)."""
    translator.body.append(convert(node.astext(), display="inline"))
    raise SkipNode


def displayed(translator, node):
    """Write a formula on a line of its own (a visitor of Sphinx)."""
    translator.body.append(f'<div class="formula">{convert(node.astext(), display="block")}</div>\n')
    raise SkipNode
