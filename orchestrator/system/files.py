"""Files that people write: read as TOML and checked against a model, which reports all problems at once."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Final, TypeVar, cast, get_args

from pydantic import BaseModel, ConfigDict, ValidationError

from components.interfaces.problem import Problem, RequestError, choices, did_you_mean, raise_if_any, refuse
from fmus.toolchain.door import exception_in_words, reading
from orchestrator.system.contents import read_text

_TOML: Final = "a TOML file"
_NUMBER: Final = "whole numbers of up to 64 bits"
_LARGEST: Final = 2**64
_LONG_NUMBER: Final = re.compile(r"[0-9_]{4000,}")
_LONG_KEY: Final = re.compile(r"(?<![\w.-])(?:[\w-]++\s*+\.\s*+){200}")
_Model = TypeVar("_Model", bound=BaseModel)


class Given(BaseModel):
    """A value with its unit of measurement and its source."""

    model_config = ConfigDict(extra="forbid", strict=True, use_attribute_docstrings=True)

    value: Any
    """A number, a truth value, or a list of them for an array."""
    unit: str = "1"
    """The unit of measurement, in Modelica's spelling, such as `m/s2`."""
    source: str = ""
    """Where the value comes from; the file itself, if nothing is said."""


def read_toml(path: Path) -> dict[str, Any]:
    """Read a TOML file.

    Raises:
        RequestError: The file cannot be read, or is not valid TOML; the message then has the line.
    """
    where = str(path)
    text = read_text(path, where, _TOML, only_files=True)
    if (long := _LONG_KEY.search(text)) is not None:  # tomllib takes a time that grows with the square of the parts
        raise refuse(_at(where, text, long), "a key of more than 200 parts", _TOML)
    with reading(where, _TOML):
        try:
            content = tomllib.loads(text)
        except tomllib.TOMLDecodeError as error:
            raise refuse(where, f"text that is no TOML ({error})", _TOML) from error
        except ValueError as error:  # Python reads no number of so many digits, and tells no line
            place = _at(where, text, _LONG_NUMBER.search(text))
            raise refuse(place, f"a value that cannot be read ({exception_in_words(error)})", _NUMBER) from error
    raise_if_any(
        Problem(f"{where}: {key}", f"a number of {digits} digits", _NUMBER) for key, digits in _too_large(content)
    )
    return content


def _at(where: str, text: str, place: re.Match[str] | None) -> str:
    """The line of a place in a file, where it is known."""
    return where if place is None else f"{where}, line {text.count(chr(10), 0, place.start()) + 1}"


def _too_large(value: Any, key: str = "") -> Iterator[tuple[str, int]]:
    """The keys of whole numbers that no variable of FMI could hold, with their digits."""
    if isinstance(value, dict | list):
        table = cast(dict[Any, Any], value if isinstance(value, dict) else dict(enumerate(value)))  # type: ignore[unknown]
        for name, item in table.items():
            yield from _too_large(item, f"{key}.{name}" if key else str(name))
    elif isinstance(value, int) and abs(value) >= _LARGEST:
        yield key, int(value.bit_length() * 0.30103) + 1


def checked(model: type[_Model], content: Mapping[str, Any], where: str) -> _Model:
    """Check the content of a file.

    Args:
        model: The entries that the file must have, with their types.
        content: The parsed file.
        where: The name of the file, for messages.

    Returns:
        The content as an object of the model.

    Raises:
        RequestError: Entries are missing, unknown or of another type; the error lists all of them.
    """
    try:
        return model.model_validate(dict(content))
    except ValidationError as error:
        raise RequestError([_problem(model, where, dict(item)) for item in error.errors()]) from error


def _problem(model: type[BaseModel], where: str, item: Mapping[str, Any]) -> Problem:
    location: Sequence[str | int] = item["loc"]
    place = f"{where}: {'.'.join(str(part) for part in location if part != _WRAPPED)}"
    if item["type"] == "missing":
        return Problem(place, "nothing", "an entry of this name", _hint(model, location))
    if item["type"] == "extra_forbidden":
        known = sorted(_model_at(model, location[:-1]).model_fields)
        known = ["value", "unit", "source"] if known == sorted(Given.model_fields) else known
        return Problem(place, "an unknown entry", choices(known), did_you_mean(str(location[-1]), known))
    if item["type"] == "model_type" and issubclass(_model_at(model, location), Given):
        return Problem(place, f"`{item['input']}`", f'{{ value = {item["input"]}, unit = "..." }}')
    return Problem(place, f"`{item['input']}`", item["msg"].removeprefix("Input should be "), _hint(model, location))


def _hint(model: type[BaseModel], location: Sequence[str | int]) -> str:
    is_part = location[-1] in Given.model_fields and issubclass(_model_at(model, location[:-1]), Given)
    if is_part or "parameters" in location:
        return 'Write NAME = { value = ..., unit = "...", source = "..." }.'
    return ""


def _model_at(model: type[BaseModel], location: Sequence[str | int]) -> type[BaseModel]:
    """The model of the table at a place in the file."""
    for part in location:
        field = model.model_fields.get(str(part))  # a part that is no field is the key of a dictionary of models
        if field is not None:
            model = next((kind for kind in _kinds(field.annotation) if issubclass(kind, BaseModel)), model)
    return model


def _kinds(annotation: Any) -> list[type]:
    return (
        [annotation]
        if isinstance(annotation, type) and not get_args(annotation)
        else [kind for argument in get_args(annotation) for kind in _kinds(argument)]
    )


_WRAPPED = "values"
"""The field that holds all entries of a file without fixed ones; the file itself does not contain this name."""
