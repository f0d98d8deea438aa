"""Arguments of another type than their annotation or of an unknown name, in the words of every wrong request."""

from __future__ import annotations

import collections.abc
import dataclasses
import inspect
import sys
from collections.abc import Callable, Collection, Iterator, Mapping
from enum import Enum
from functools import cache, wraps
from numbers import Integral, Real
from types import NoneType, UnionType
from typing import Any, Literal, ParamSpec, TypeVar, Union, cast, get_args, get_origin

from components.interfaces.problem import Problem, RequestError, choices, did_you_mean, raise_if_any

_P = ParamSpec("_P")
_R = TypeVar("_R")
_C = TypeVar("_C")
_SHOWN = 60
"""The most characters of a value that a message shows."""


def checked_arguments(function: Callable[_P, _R]) -> Callable[_P, _R]:
    """Decorate a function or an `__init__` so that arguments of another type than annotated raise `RequestError`.

    So do unknown names. Numbers of NumPy count as numbers; what is too few or too many remains Python's own
    `TypeError`.
    """
    signature = inspect.signature(function)
    where = function.__qualname__.removesuffix(".__init__")

    @wraps(function)
    def checked(*args: _P.args, **kwargs: _P.kwargs) -> _R:
        try:
            given = signature.bind(*args, **kwargs).arguments
        except TypeError as error:
            known = [name for name in signature.parameters if name != "self"]
            raise (_of_unknown_names(f"{where}: ", "argument", kwargs, known) or error) from None
        raise_if_any(_problems(where, given, _hints(function)))
        return function(*args, **kwargs)

    return checked


def names_told(cls: type[_C]) -> type[_C]:
    """Decorate a dataclass so that it tells unknown and missing names of its fields as every wrong request is told.

    What Python says of them names neither the names that are known nor the closest one. A call that is right costs
    no more than another call.

    Args:
        cls: The class; its `name` is what messages call it, if it has one.
    """
    initialise: Callable[..., None] = cls.__init__

    @wraps(initialise)
    def told(self: Any, *args: Any, **values: Any) -> None:
        try:
            initialise(self, *args, **values)
        except TypeError as error:
            raise (_of_fields(type(self), values, by_place=bool(args)) or error) from None

    cls.__init__ = told
    return cls


def _of_fields(cls: Any, values: Mapping[str, Any], *, by_place: bool) -> RequestError | None:
    """What is wrong with the names of the values of a dataclass; None if nothing is.

    Args:
        cls: The class.
        values: The values that are given by name.
        by_place: Whether others are given by their place, so that nobody knows here which are missing.
    """
    fields = {field.name: field for field in dataclasses.fields(cls) if field.init}
    called = getattr(cls, "name", None)
    where = f"{called if isinstance(called, str) else cls.__name__}."
    unknown = _of_unknown_names(where, "field", values, fields)
    without = [name for name, field in fields.items() if field.default is field.default_factory]  # both are MISSING
    missing = [Problem(f"{where}{name}", "no value", _valid(fields[name])) for name in without if name not in values]
    problems = [*(unknown.problems if unknown else ()), *(() if by_place else missing)]
    return RequestError(problems) if problems else None


def _valid(field: dataclasses.Field[Any]) -> str:
    """The valid values of a field, as far as it says so."""
    declared = field.metadata.get("quantity")
    return "a value" if declared is None else declared.range


def _of_unknown_names(where: str, what: str, given: Mapping[str, Any], known: Collection[str]) -> RequestError | None:
    """The names that were given and are not known; None if there are none."""
    problems = [
        Problem(f"{where}{name}", f"an unknown {what}", choices(known), did_you_mean(name, known))
        for name in given
        if name not in known
    ]
    return RequestError(problems) if problems else None


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
    if _fits_at_once(value, hint):
        return True
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


def _fits_at_once(value: Any, hint: Any) -> bool:
    """Whether a value is of the very type, as most are; `Simulation.read` is called in every step."""
    kind = cast("Any", type(value))
    if kind is hint or (hint in kind.__mro__ and kind is not bool):  # which Python takes for a whole number
        return True
    origin = get_origin(hint)
    if origin in (Union, UnionType):
        return any(kind is part for part in get_args(hint))
    if kind is dict and get_args(hint) == (str, Any):
        return issubclass(dict, origin or ()) and all(type(key) is str for key in value)
    return kind in (tuple, dict, frozenset) and not value and isinstance(value, origin or ())


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
