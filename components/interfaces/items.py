"""Enumerations: named whole numbers, whatever the names are.

The names come from files too, which may have blanks in them or be words of Python; so an enumeration is data here, and
no class with an attribute for each item.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import IntEnum


@dataclass(frozen=True)
class Item:
    """One item of an enumeration."""

    name: str
    value: int


@dataclass(frozen=True)
class Enumeration:
    """The items of an enumeration, in the order in which they are declared."""

    name: str
    items: tuple[Item, ...]

    @staticmethod
    def of(declared: type[IntEnum]) -> Enumeration:
        """The enumeration with the name and the items of a class."""
        return Enumeration(declared.__name__, tuple(Item(item.name, item.value) for item in declared))

    def __iter__(self) -> Iterator[Item]:
        """The items."""
        return iter(self.items)

    @property
    def values(self) -> dict[str, int]:
        """The value of each item, by its name."""
        return {item.name: item.value for item in self.items}

    @property
    def names(self) -> dict[int, str]:
        """The name of each item, by its value; the first of those that a file gives the same value."""
        return {item.value: item.name for item in reversed(self.items)}
