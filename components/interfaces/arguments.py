"""Arguments of another type than their annotation, told in the words of every wrong request."""

from __future__ import annotations

import collections.abc
import inspect
import sys
from collections.abc import Callable, Iterator, Mapping
from enum import Enum
from functools import cache, wraps
from numbers import Integral, Real
from types import NoneType, UnionType
from typing import Any, Literal, ParamSpec, TypeVar, Union, cast, get_args, get_origin

from components.interfaces.problem import Problem, raise_if_any

_P = ParamSpec("_P")
_R = TypeVar("_R")
_SHOWN = 60
"""The most characters of a value that a message shows."""


def checked_arguments(function: Callable[_P, _R]) -> Callable[_P, _R]:
    """Decorate a function or an `__init__` so that arguments of another type than annotated raise `RequestError`.

    Numbers of NumPy count as numbers; what is too few or too many remains Python's own `TypeError`.
    """
    signature = inspect.signature(function)
    where = function.__qualname__.removesuffix(".__init__")

    @wraps(function)
    def checked(*args: _P.args, **kwargs: _P.kwargs) -> _R:
        given = signature.bind(*args, **kwargs).arguments
        raise_if_any(_problems(where, given, _hints(function)))
        return function(*args, **kwargs)

    return checked


def check_fields(instance: object) -> None:
    """Check the fields of a dataclass against their annotations. Raises `RequestError`."""
    kind = type(instance)
    raise_if_any(_problems(kind.__name__, vars(instance), _hints(kind)))


@cache
def _hints(annotated: Any) -> Mapping[str, Any]:
    """The annotations of arguments or fields; the result of a function may be of a type that is not imported."""
    known = vars(sys.modules[annotated.__module__])
    found = {name: text for name, text in inspect.get_annotations(annotated).items() if name != "return"}
    return {name: eval(text, dict(known)) if isinstance(text, str) else text for name, text in found.items()}  # noqa: S307 - our own sources


def _problems(where: str, given: Mapping[str, Any], hints: Mapping[str, Any]) -> Iterator[Problem]:
    for name, hint in hints.items():
        if name in given:
            yield from _misfits(f"{where}: {name}", given[name], hint)


def _misfits(where: str, value: Any, hint: Any) -> Iterator[Problem]:
    """What of a value is not of the type: the items of a collection that are not, or all of it."""
    if _fits(value, hint):
        return
    inside = get_args(hint)
    if get_origin(hint) is collections.abc.Mapping and isinstance(value, Mapping):
        for key, item in cast("Mapping[Any, Any]", value).items():
            yield from _misfits(f"{where}: key", key, inside[0])
            yield from _misfits(f"{where}[{key!r}]", item, inside[1])
        return
    text = repr(value)
    found = f"`{text if len(text) <= _SHOWN else text[:_SHOWN] + ' ...'}` ({type(value).__name__})"
    yield Problem(where, found, in_words(hint), getattr(hint, "MADE_BY", ""))


def _fits(value: Any, hint: Any) -> bool:
    if type(value) is hint:
        return True  # most are, and `Simulation.read` is called in every step
    from typeguard import CollectionCheckStrategy, TypeCheckError, check_type  # noqa: PLC0415 - slow to import

    if isinstance(hint, str):
        return True  # a type of a library that is imported only where it is needed
    if isinstance(value, str) and not _takes_text(hint):
        return False  # to Python it is a sequence of texts
    try:
        check_type(_plain(value), hint, collection_check_strategy=CollectionCheckStrategy.ALL_ITEMS)
    except TypeCheckError:
        return False
    return True


def _takes_text(hint: Any) -> bool:
    if get_origin(hint) in (Union, UnionType):
        return any(map(_takes_text, get_args(hint)))
    return hint in (str, Any) or get_origin(hint) is Literal or _is_enum(hint)


def _is_enum(hint: Any) -> bool:
    return inspect.isclass(hint) and issubclass(hint, Enum)


def _plain(value: Any) -> Any:
    """A number as one of Python's, so that those of NumPy fit; a truth value is no number."""
    if isinstance(value, bool | int | float | Enum):
        return value
    if isinstance(value, Integral):
        return int(value)
    return float(value) if isinstance(value, Real) else value


def in_words(hint: Any) -> str:
    """A type as a person writes it: `float or None`, `Mapping of str to UnitSource`."""
    origin, parts = get_origin(hint), get_args(hint)
    if origin is Literal:
        return " or ".join(f"`{value}`" for value in parts)
    if origin in (Union, UnionType):
        return " or ".join(dict.fromkeys(map(in_words, parts)))
    if _is_enum(hint):
        return " or ".join(f"{hint.__name__}.{member.name}" for member in hint)
    if origin in (collections.abc.Mapping, collections.abc.Sequence, collections.abc.Collection):
        return f"{origin.__name__} of {' to '.join(map(in_words, parts))}"
    if hint is Any:
        return "anything"
    return "None" if hint is NoneType else getattr(origin or hint, "__name__", str(hint))
