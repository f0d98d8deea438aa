"""Files that people write: read, checked, and refused with everything that is wrong."""

from __future__ import annotations

import pytest

from components.interfaces.problem import RequestError
from orchestrator.system.files import read_toml


def test_text_that_is_no_toml_is_told_with_its_line(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text("title = 'x'\n[experiment\n")
    with pytest.raises(RequestError, match=r"mine.toml: found text that is no TOML \(.*line 2.*\); valid: a TOML file"):
        read_toml(path)


def test_a_file_that_cannot_be_read_is_told(tmp_path):
    with pytest.raises(RequestError, match=r"mine.toml: found a file that cannot be read"):
        read_toml(tmp_path / "mine.toml")
