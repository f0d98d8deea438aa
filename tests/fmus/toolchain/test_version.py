"""The versions of FMI, as they stand in names and texts."""

from __future__ import annotations

import pytest

from fmus.toolchain.version import WRITTEN_VERSIONS, Version


def test_a_version_stands_in_texts_as_its_number():
    assert [f"fmi{version}" for version in WRITTEN_VERSIONS] == ["fmi2", "fmi3"]
    assert [f"FMI {version}.0" for version in WRITTEN_VERSIONS] == ["FMI 2.0", "FMI 3.0"]
    assert str(Version.FMI2) == "2"


def test_a_version_is_found_by_its_number_and_no_other_is():
    assert Version(3) is Version.FMI3
    assert Version.FMI2 < Version.FMI3
    assert Version.FMI1 not in WRITTEN_VERSIONS
    with pytest.raises(ValueError, match="4"):
        Version(4)
