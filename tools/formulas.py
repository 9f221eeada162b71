"""Formulas of the pages, written $...$ and $$...$$, become MathML: no script and no font is fetched to show them."""

from xml.etree import ElementTree

from latex2mathml.converter import convert
from markdown.blockprocessors import BlockProcessor
from markdown.extensions import Extension
from markdown.inlinepatterns import InlineProcessor

_INLINE = r"(?<![\\$\w])\$(?!\s)([^$\n]+?)(?<!\s)\$(?![\w$])"


class _Inline(InlineProcessor):
    def handleMatch(self, match, data):  # the name that Markdown calls
        return self.md.htmlStash.store(convert(match[1])), match.start(0), match.end(0)


class _Block(BlockProcessor):
    def test(self, parent, block):
        return block.startswith("$$") and block.rstrip().endswith("$$")

    def run(self, parent, blocks):
        tex = blocks.pop(0).strip()[2:-2].strip()
        paragraph = ElementTree.SubElement(parent, "p", {"class": "formula"})
        paragraph.text = self.parser.md.htmlStash.store(convert(tex, display="block"))


class _Formulas(Extension):
    def extendMarkdown(self, md):
        md.parser.blockprocessors.register(_Block(md.parser), "formula", 175)
        md.inlinePatterns.register(_Inline(_INLINE, md), "formula", 185)


def makeExtension(**options):
    """Return the extension, as Markdown asks for it."""
    return _Formulas(**options)
