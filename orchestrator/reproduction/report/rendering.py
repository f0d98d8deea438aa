"""The report as text: Markdown from the templates, and the same as one page for a browser."""

from __future__ import annotations

import re
from collections.abc import Mapping, MutableMapping, Sequence
from pathlib import Path
from typing import Any, Final, cast

from markdown_it.renderer import RendererHTML
from markdown_it.token import Token
from markdown_it.utils import OptionsDict
from markupsafe import Markup

from orchestrator.pictures.templating import embedded, templates
from orchestrator.reproduction.paper.verdict import Verdict
from orchestrator.reproduction.paper.where import counted
from orchestrator.reproduction.report import headings
from orchestrator.reproduction.report.metric_names import (
    deciding_title,
    labelled,
    metric_tables,
    metric_title,
    percentage,
    sentence,
    written,
)

_TEMPLATES: Final = templates(Path(__file__).parent / "templates")
# jinja2 annotates this dictionary with the types of its own filters only
cast(dict[str, Any], _TEMPLATES.filters).update(
    anchor=headings.anchor,
    counted=counted,
    deciding_title=deciding_title,
    labelled=labelled,
    metric_tables=metric_tables,
    metric_title=metric_title,
    percentage=percentage,
    sections=headings.sections,
    sentence=sentence,
    written=written,
)


def markdown(content: Mapping[str, Any], verdicts: Mapping[str, Sequence[Verdict]]) -> str:
    """The whole report as Markdown.

    Args:
        content: The content of `report.json`.
        verdicts: The verdicts in it as objects: `claims` and `goals`, and with a varied set `varied`.
    """
    folders = {run["name"]: run["folder"] for run in content["runs"]}
    text = _TEMPLATES.get_template("report.md.jinja").render(
        content=content,
        judged=[*verdicts["claims"], *verdicts["goals"]],
        on_variations={verdict.claim: verdict for verdict in verdicts.get("varied", ())},
        folders=folders,
    )
    return re.sub(r"\n{3,}", "\n\n", text).strip() + "\n"


def html(text: str, folder: Path) -> str:
    """The Markdown as one page that needs no other file: the figures are embedded in it.

    Args:
        text: The report as Markdown.
        folder: The folder that the paths of the figures refer to.
    """
    converter = headings.converter()
    converter.add_render_rule("image", _embedded)
    converter.add_render_rule("table_open", lambda *_: '<div class="wide"><table>\n')
    converter.add_render_rule("table_close", lambda *_: "</table></div>\n")
    body = Markup(converter.render(text, {"folder": folder}))  # noqa: S704 - the converter has escaped the text
    return _TEMPLATES.get_template("report.html.jinja").render(body=body)


def _embedded(
    renderer: RendererHTML, tokens: Sequence[Token], at: int, options: OptionsDict, env: MutableMapping[str, Any]
) -> str:
    """An image whose data stands in the page."""
    image = tokens[at]
    image.attrs["src"] = embedded((env["folder"] / str(image.attrs["src"])).read_bytes())
    return renderer.image(tokens, at, options, env)
