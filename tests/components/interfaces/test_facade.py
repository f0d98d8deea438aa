"""Names of a package are imported when they are first used."""

from __future__ import annotations

import sys
from types import ModuleType

import pytest

from components.interfaces.facade import facade


@pytest.fixture
def package(monkeypatch):
    """A package with two names: a class of a module, and a submodule of a package."""
    made = ModuleType("package_of_this_test")
    monkeypatch.setitem(sys.modules, made.__name__, made)
    made.__getattr__, made.__dir__ = facade(made.__name__, {"fractions": ("Fraction",), "xml.dom": ("minidom",)})
    return made


def test_a_name_is_imported_when_it_is_used_and_kept(package):
    assert "Fraction" not in vars(package)
    assert package.Fraction(1, 2) == 0.5
    assert "Fraction" in vars(package)


def test_a_submodule_can_be_offered_too(package):
    assert package.minidom.__name__ == "xml.dom.minidom"


def test_all_names_are_listed_before_they_are_used(package):
    assert {"Fraction", "minidom", "__name__"} <= set(dir(package))


def test_another_name_is_an_attribute_error(package):
    with pytest.raises(AttributeError, match="module 'package_of_this_test' has no attribute 'Decimal'"):
        package.Decimal  # noqa: B018 - the look-up is what fails
