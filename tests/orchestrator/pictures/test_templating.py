"""Pages from templates, which share one style."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from jinja2 import UndefinedError
from matplotlib.colors import to_rgb

import orchestrator
from orchestrator.pictures.templating import embedded, templates

PAGES = sorted(Path(orchestrator.__file__).parent.rglob("*.html.jinja"))
SHARED = next(page for page in PAGES if page.name == "page.html.jinja").read_text()
DARK_FROM = SHARED.index("@media screen and (prefers-color-scheme: dark)")


def colours(style):
    """The colours that a part of the style names."""
    return dict(re.findall(r"--([\w-]+): (#\w+);", style))


LIGHT, DARK = colours(SHARED[:DARK_FROM]), colours(SHARED[DARK_FROM:])


def luminance(colour):
    channels = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in to_rgb(colour)]
    return 0.2126 * channels[0] + 0.7152 * channels[1] + 0.0722 * channels[2]


def contrast(one, other):
    """The contrast of two colours as the accessibility guidelines (WCAG 2) count it: 1 to 21."""
    dark, light = sorted(map(luminance, (one, other)))
    return (light + 0.05) / (dark + 0.05)


@pytest.mark.parametrize("scheme", [LIGHT, DARK], ids=["light", "dark"])
def test_all_texts_are_readable_on_light_and_on_dark_screens(scheme):
    assert LIGHT.keys() == DARK.keys()
    pairs = [(text, "ground") for text in ("text", "pale", "link", "good", "bad")]
    pairs += [("text", "raised"), ("good", "good-ground"), ("bad", "bad-ground"), ("pale", "plain-ground")]
    for text, ground in pairs:
        assert contrast(scheme[text], scheme[ground]) >= 4.5, (text, ground)
    assert (luminance(scheme["ground"]) > 0.5) == (scheme is LIGHT)


def test_pictures_get_a_dark_ground_on_dark_screens_only():
    rule = "img { filter: invert(0.92) hue-rotate(180deg); }"
    assert rule in SHARED[DARK_FROM:]
    assert "filter" not in SHARED[:DARK_FROM]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_colour_of_a_page_is_one_of_the_schemes(page):
    text = page.read_text()
    rules = re.sub(r":root \{.*?\}", "", text, flags=re.DOTALL)
    assert not re.search(r": [^;]*#[0-9a-f]{3,6}\b", rules)
    assert set(re.findall(r"var\(--([\w-]+)\)", text)) <= LIGHT.keys()


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
