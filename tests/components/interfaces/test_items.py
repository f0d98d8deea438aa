"""Enumerations as data: any names, any whole numbers."""

from __future__ import annotations

from enum import IntEnum

from components.interfaces.items import Enumeration, Item


class Gear(IntEnum):
    """Ours."""

    reverse = -1
    first = 1


def test_a_class_becomes_its_items():
    gear = Enumeration.of(Gear)
    assert (gear.name, [*gear]) == ("Gear", [Item("reverse", -1), Item("first", 1)])
    assert gear == Enumeration.of(Gear)
    assert len({gear, Enumeration.of(Gear)}) == 1


def test_names_that_mean_something_in_python_are_names_like_others():
    items = [Item(name, k) for k, name in enumerate(("mro", "name", "class", "__NONE__", "Option 1", "_x_", "value"))]
    found = Enumeration("Mode", (*items,))
    assert found.values == {item.name: item.value for item in items}
    assert found.names == {item.value: item.name for item in items}


def test_of_two_items_with_one_value_the_first_gives_it_its_name():
    assert Enumeration("Mode", (Item("a", 1), Item("b", 1))).names == {1: "a"}
