"""Every limit on files of other makers is told to people."""

from __future__ import annotations

from pathlib import Path

from fmus.toolchain import limits

ROOT = Path(__file__).resolve().parents[3]


def test_the_readme_has_every_limit():
    names = [name for name in vars(limits) if name.isupper()]
    text = (ROOT / "fmus" / "README.md").read_text("utf-8")
    assert len(names) > 20
    assert [name for name in names if f"`{name}`" not in text] == []
