"""Pages from templates: one style for all of them, which need no other file."""

from __future__ import annotations

import base64
from pathlib import Path
from typing import Final

from jinja2 import Environment, FileSystemLoader, StrictUndefined, select_autoescape

_SHARED: Final = Path(__file__).parent / "templates"
"""The folder of `page.html.jinja`, which pages extend."""


def templates(folder: Path) -> Environment:
    """The templates in a folder, and those that all pages share; what they are given is escaped in HTML.

    Args:
        folder: The folder.
    """
    return Environment(
        loader=FileSystemLoader([folder, _SHARED]),
        autoescape=select_autoescape(("html.jinja",), default=False),
        undefined=StrictUndefined,
        trim_blocks=True,
        keep_trailing_newline=True,
    )


def embedded(image: bytes) -> str:
    """A picture (PNG) as the address of itself, so that a page needs no other file."""
    return f"data:image/png;base64,{base64.b64encode(image).decode('ascii')}"
