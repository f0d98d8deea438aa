"""Lazy facades: the names that a package offers are imported when they are first used (PEP 562)."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from typing import Any


def facade(package: str, names: Mapping[str, Sequence[str]]) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """Make the functions `__getattr__` and `__dir__` of a package that imports its public names on first use.

    Args:
        package: The name of the package.
        names: The public names by the module that defines them, or by the package whose submodules they are.

    Returns:
        The two functions; the first raises `AttributeError` for a name that is not among `names`.
    """
    modules = {name: module for module, found in names.items() for name in found}

    def get(name: str) -> Any:
        if name not in modules:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        module = import_module(modules[name])
        if not hasattr(module, name):
            import_module(f"{modules[name]}.{name}")
        value = getattr(module, name)
        setattr(sys.modules[package], name, value)
        return value

    return get, lambda: sorted({*vars(sys.modules[package]), *modules})
