"""Pages from templates, which share one style."""

from __future__ import annotations

import pytest
from jinja2 import UndefinedError

from orchestrator.pictures.templating import embedded, templates


def test_a_page_extends_the_shared_one_and_escapes_its_texts(tmp_path):
    body = '{% extends "page.html.jinja" %}{% block title %}T{% endblock %}{% block body %}{{ text }}{% endblock %}'
    (tmp_path / "own.html.jinja").write_text(body)
    html = templates(tmp_path).get_template("own.html.jinja").render(text="a < b")
    assert html.startswith("<!doctype html>")
    assert "<title>T</title>" in html
    assert "a &lt; b" in html
    assert "font: 16px/1.5 system-ui" in html


def test_text_templates_are_not_escaped_and_nothing_is_left_out_in_silence(tmp_path):
    (tmp_path / "own.md.jinja").write_text("{{ text }}")
    template = templates(tmp_path).get_template("own.md.jinja")
    assert template.render(text="a < b") == "a < b"
    with pytest.raises(UndefinedError):
        template.render()


def test_a_picture_is_embedded():
    assert embedded(b"PNG") == "data:image/png;base64,UE5H"
