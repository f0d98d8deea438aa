"""Model descriptions that FMPy does not read as they are: what is changed in them before, and changed back."""

from __future__ import annotations

from collections.abc import Generator
from contextlib import contextmanager
from typing import Any, Final

_PARAMETERS: Final = ("parameter", "calculatedParameter", "structuralParameter", "local")
_CAUSALITIES: Final = {
    "constant": ("output", "local"),
    "fixed": _PARAMETERS,
    "tunable": _PARAMETERS,
    "discrete": ("input", "output", "local"),
    "continuous": ("input", "output", "local", "independent"),
}
"""The causalities that each variability allows."""


def _contradicts_itself(variable: Any) -> bool:
    """Whether causality and variability exclude each other, so that FMI has no default of `initial`."""
    default = "continuous" if variable.tag == "ScalarVariable" else None
    variability = variable.get("variability", default)
    if variability is None or variable.get("initial") is not None:
        return False
    return variable.get("causality", "local") not in _CAUSALITIES.get(variability, ())


def separate_by_single_blanks(root: Any) -> None:
    """Write single blanks between the items of lists, which XML does not demand."""
    places = {
        "dependencies": "ModelStructure//*",
        "dependenciesKind": "ModelStructure//*",
        "clocks": "ModelVariables/*",
    }
    for name, place in places.items():
        for element in root.iterfind(f"{place}[@{name}]"):
            element.set(name, " ".join(element.get(name).split()))


@contextmanager
def named_version(root: Any, version: str) -> Generator[None]:
    """A description that names another version of FMI."""
    named = root.get("fmiVersion")
    root.set("fmiVersion", version)
    try:
        yield
    finally:
        root.set("fmiVersion", named)


@contextmanager
def contradictions_with_initial(root: Any) -> Generator[list[Any]]:
    """The variables whose causality and variability exclude each other, with an `initial` for the time being."""
    contradicting = [v for v in root.iterfind("ModelVariables/*") if isinstance(v.tag, str) and _contradicts_itself(v)]
    for variable in contradicting:
        variable.set("initial", "exact")
    try:
        yield contradicting
    finally:
        for variable in contradicting:
            del variable.attrib["initial"]
