"""Formulas as MathML, which browsers draw by themselves: no script, no font and no network."""

import re

from docutils import nodes
from docutils.utils.math import MathError, latex2mathml
from sphinx.errors import ExtensionError

GAP = '<mspace width="0.17em"></mspace>'


def setup(app):
    """Register the renderer."""
    app.add_html_math_renderer("mathml", inline_renderers=(_inline, None), block_renderers=(_block, None))
    app.config.html_math_renderer = "mathml"
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def _inline(writer, node):
    writer.body.append(_mathml(node, as_block=False))
    raise nodes.SkipNode


def _block(writer, node):
    writer.body.append(f'<div class="math">{_mathml(node, as_block=True)}</div>\n')
    raise nodes.SkipNode


def _mathml(node, *, as_block):
    try:
        return spaced(latex2mathml.tex2mathml(node.astext(), as_block=as_block))
    except MathError as error:
        raise ExtensionError(f"no MathML for {node.astext()}: {error}") from error


def spaced(mathml):
    """Set the names of functions off, as TeX does: R cos t, and neither Rcos t nor R cost."""
    mathml = re.sub(r"(?<=</mi>)(\s*<mi[^>]*>\w+</mi>\s*<mo>&ApplyFunction;)", rf"{GAP}\1", mathml)
    return re.sub(r"(?<=&ApplyFunction;</mo>)(?!\s*<mo[^>]*>\()", GAP, mathml)
