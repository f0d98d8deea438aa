"""The passport as files: one page for a person, one JSON for a machine."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any, Final, cast

from markupsafe import Markup, escape

from fmus.toolchain.archives import writable_folder
from orchestrator.exchange.passport import identity
from orchestrator.exchange.passport.passport import Passport
from orchestrator.exchange.passport.passport_comparison import PassportComparison
from orchestrator.exchange.passport.passport_line import GROUPS, Mark
from orchestrator.pictures.templating import embedded, templates

_TEMPLATES: Final = Path(__file__).parent / "templates"


def write_passport(
    made: Passport, folder: Path, name: str, comparison: PassportComparison | None = None
) -> tuple[Path, Path]:
    """Write NAME.passport.html and NAME.passport.json.

    Args:
        made: The passport.
        folder: Where they go; made if it is not there.
        name: The name of both files, without their endings.
        comparison: What has changed since another passport.

    Returns:
        The page and the JSON.

    Raises:
        RequestError: The folder cannot be written to.
    """
    writable_folder(folder)
    page_file, data_file = folder / f"{name}.passport.html", folder / f"{name}.passport.json"
    page_file.write_text(page(made, comparison), encoding="utf-8")
    content = made.data() | ({"against": comparison.data()} if comparison is not None else {})
    data_file.write_text(json.dumps(content, indent=2, allow_nan=False) + "\n", encoding="utf-8")
    return page_file, data_file


def page(made: Passport, comparison: PassportComparison | None = None) -> str:
    """The passport as HTML that needs no other file."""
    lines = made.lines
    environment = templates(_TEMPLATES)
    cast(dict[str, Any], environment.filters)["code"] = _with_code
    return environment.get_template("passport.html.jinja").render(
        passport=made.identity,
        counts={mark.value: made.count(mark) for mark in Mark},
        lines=lines,
        failing=[line for line in lines if line.mark is Mark.FAILS],
        facts=identity.shown(made.identity),
        groups=[(title, g) for key, title in GROUPS.items() if (g := [ln for ln in lines if ln.group == key])],
        pictures=[embedded(picture) for picture in made.pictures],
        comparison=comparison,
        provenance=made.provenance,
    )


def _with_code(text: str) -> Markup:
    """A text in which what stands in backquotes is shown as code."""
    parts = re.split(r"`([^`]+)`", str(text))
    return Markup("").join(Markup("<code>{}</code>").format(p) if i % 2 else escape(p) for i, p in enumerate(parts))
