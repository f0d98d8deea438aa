"""The headings of the report as places that links lead to, in Markdown as in the page.

A heading's place has the name that the usual viewers of Markdown give it, so that one table of contents serves all.
"""

from __future__ import annotations

import re
from collections.abc import MutableMapping, Sequence
from typing import Any, Final

from markdown_it import MarkdownIt
from markdown_it.renderer import RendererHTML
from markdown_it.token import Token
from markdown_it.utils import OptionsDict

_SECTION: Final = "h2"


def converter() -> MarkdownIt:
    """What turns the text into a page; each heading is a place that links lead to."""
    made = MarkdownIt("commonmark", {"html": False}).enable("table")
    made.add_render_rule("heading_open", _with_anchor)
    return made


def anchor(title: str) -> str:
    """The name of the place of a heading."""
    return re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-")


def sections(text: str) -> list[tuple[str, str]]:
    """The title of each section of a Markdown text, and the name of its place."""
    tokens, used = converter().parse(text), dict[str, int]()
    headings = [(token.tag, tokens[i + 1].content) for i, token in enumerate(tokens) if token.type == "heading_open"]
    places = [(tag, title, _place(title, used)) for tag, title in headings]
    return [(title, place) for tag, title, place in places if tag == _SECTION]


def _place(title: str, used: dict[str, int]) -> str:
    """The name of the place of the next heading; the second of the same title is told from the first by a number."""
    name = anchor(title)
    used[name] = used.get(name, -1) + 1
    return f"{name}-{used[name]}" if used[name] else name


def _with_anchor(
    renderer: RendererHTML, tokens: Sequence[Token], at: int, options: OptionsDict, env: MutableMapping[str, Any]
) -> str:
    """A heading with the name of its place."""
    tokens[at].attrs["id"] = _place(tokens[at + 1].content, env.setdefault("anchors", {}))
    return renderer.renderToken(tokens, at, options, env)
