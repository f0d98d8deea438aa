"""Runs as people keep them."""

from __future__ import annotations

from shutil import copytree

import pytest


@pytest.fixture(scope="package")
def whole(kept_run, tmp_path_factory):
    """The folder of a run of 2 s."""
    return kept_run(tmp_path_factory.mktemp("runs") / "static-1", until=2.0)


@pytest.fixture
def run(whole, tmp_path):
    """A copy of it that may be damaged."""
    return copytree(whole, tmp_path / "static-1")
