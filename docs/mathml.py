"""Equations as MathML, which browsers render without a script and without network."""

from __future__ import annotations

from typing import Any

from docutils import nodes
from math_core import LatexError, LatexToMathML
from sphinx.util import logging

_LATEX = LatexToMathML()


def _mathml(node: Any, *, displaystyle: bool) -> str:
    try:
        return _LATEX.convert_with_local_state(node.astext(), displaystyle=displaystyle)
    except LatexError as error:
        logging.getLogger(__name__).warning("equation: %s", error, location=node)
        return ""


def _inline(translator: Any, node: Any) -> None:
    translator.body.append(_mathml(node, displaystyle=False))
    raise nodes.SkipNode


def _block(translator: Any, node: Any) -> None:
    translator.body.append(f'<div class="equation">{_mathml(node, displaystyle=True)}</div>')
    raise nodes.SkipNode


def setup(app: Any) -> dict[str, bool]:
    """Register the renderer."""
    app.add_html_math_renderer("mathml", (_inline, None), (_block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
