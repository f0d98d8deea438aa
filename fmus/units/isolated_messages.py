"""The exchange between `IsolatedUnit` and the process of its FMU: calls, replies, and columns in shared memory.

Numbers lie in a file that both processes map; texts and bytes, which have no fixed size, go with the messages.
"""

from __future__ import annotations

import copy
import io
import mmap
import pickle
import sys
from dataclasses import dataclass, field, replace
from enum import IntEnum
from pathlib import Path
from typing import Any, Final

import numpy as np
from lxml import etree
from typing_extensions import override

from components.interfaces.problem import Problem, RequestError
from components.interfaces.quantity import DTYPES, Type, zeros
from fmus.reading.archive import VALID_FMU, Archive
from fmus.reading.xml_documents import parse_xml
from fmus.toolchain.foreign_text import plain
from fmus.toolchain.limits import MOST_TOLD
from fmus.toolchain.typed_messages import UnreadableMessageError
from fmus.unit_interface import Interface
from fmus.units.message_log import Message
from fmus.units.unit import Column, EndRequested, TypedColumns, UnitError, widths

_ALIGNMENT: Final = 8
_LONGEST: Final = 4000
"""[characters] A text that says what is wrong with a file or a call; its parts are bounded before."""
_PROBLEMS: Final = 100
"""The problems of one file that are told."""
_LISTS: Final = (
    *("modelVariables", "outputs", "derivatives", "clockedStates", "eventIndicators", "initialUnknowns"),
    *("unitDefinitions", "typeDefinitions"),
)
"""FMPy's names of the lists in a description that units do not read."""


@dataclass(frozen=True)
class Instantiation:
    """The first request: make the unit."""

    name: str
    folder: Path
    """The working folder of the process that asks for it."""
    packed: bytes
    """The FMU file as it was read, without the element tree of its description, which cannot be sent, and without what
    no unit needs of it."""
    description: bytes | None
    """The text of that element tree, where it is of use because the library has to be compiled."""
    memory: Path
    """The file of the columns, which both processes map."""
    control: Path | None
    """The file for the calls of every macro step; without one they are messages like all others."""

    @classmethod
    def of(cls, name: str, archive: Archive, memory: Path, control: Path | None) -> Instantiation:
        """The request to make the unit of an FMU file."""
        text = None if archive.root is None or archive.library is not None else etree.tostring(archive.root)
        stream = io.BytesIO()
        sent = replace(archive, description=_without_variables(archive.description), root=None)
        _Pickler(stream, pickle.HIGHEST_PROTOCOL).dump(sent)
        return cls(name, Path.cwd(), stream.getvalue(), text, memory, control)

    @property
    def archive(self) -> Archive:
        """The FMU file with its description, as far as that is of use."""
        archive: Archive = pickle.loads(self.packed)  # noqa: S301 - from our own process
        if self.description is None:
            return archive
        return replace(archive, root=parse_xml(self.description, archive.where, VALID_FMU))


def _without_variables(description: Any) -> Any:
    """The description that FMPy has read, without its lists of variables, units and types: there may be 100 000."""
    light = copy.copy(description)
    for name in _LISTS:
        if hasattr(light, name):
            setattr(light, name, [])
    return light


class _Pickler(pickle.Pickler):
    """Pickles the enumerations of FMUs too, which are classes that no module has."""

    @override
    def reducer_override(self, obj: Any) -> Any:
        if isinstance(obj, type) and issubclass(obj, IntEnum) and not _is_importable(obj):
            return IntEnum, (obj.__name__, {name: item.value for name, item in obj.__members__.items()})
        return NotImplemented


def _is_importable(kind: type[Any]) -> bool:
    return getattr(sys.modules.get(kind.__module__), kind.__qualname__, None) is kind


@dataclass(frozen=True)
class UnitCall:
    """A request for one call of a method of the unit, or of one of its capabilities."""

    method: str
    arguments: tuple[Any, ...] = ()
    set_first: bool = False
    """Whether the inputs have changed and have to be set before."""
    get_after: bool = False
    """Whether the outputs are wanted afterwards."""
    texts: list[list[Any]] = field(default_factory=list[list[Any]])
    """The inputs that are texts or bytes, type by type."""


@dataclass(frozen=True)
class Raised:
    """An exception on its way to another process: of a unit that failed or ends, or of an FMU that is refused."""

    action: str = ""
    said: tuple[str, ...] = ()
    ends: float | None = None
    """[s] The time at which the unit wants the run to end."""
    problems: tuple[Problem, ...] = ()

    @classmethod
    def of(cls, error: Exception) -> Raised:
        """What an exception consists of."""
        if isinstance(error, EndRequested):
            return cls(ends=error.time)
        if isinstance(error, RequestError):
            return cls(problems=error.problems)
        if isinstance(error, UnitError):
            return cls(error.action, error.said)
        return cls(f"it failed in its process ({type(error).__name__}: {error})")

    def error(self, unit: str) -> Exception:
        """The exception, of that unit."""
        if self.ends is not None:
            return EndRequested(unit, self.ends)
        if self.problems:
            problems = [(p.where, p.found, p.valid, p.remedy) for p in self.problems[:_PROBLEMS]]
            return RequestError(Problem(*(plain(part, _LONGEST) for part in parts)) for parts in problems)
        return UnitError(unit, plain(self.action, _LONGEST), [plain(text) for text in self.said[: MOST_TOLD + 1]])


@dataclass(frozen=True)
class UnitReply:
    """The reply to a request."""

    value: bool | int | bytes | list[str] | None = None
    messages: tuple[Message, ...] = ()
    remarks: tuple[str, ...] = ()
    warnings: int = 0
    """How many calls have returned a warning so far."""
    texts: list[list[Any]] = field(default_factory=list[list[Any]])
    """The outputs that are texts or bytes, type by type."""
    raised: Raised | None = None
    """What the unit raised."""


def map_columns(interface: Interface, file: Path) -> tuple[dict[Type, Column], dict[Type, Column]]:
    """The columns of all inputs and of all recorded variables of a unit, whose numbers lie in a file.

    Args:
        interface: The interface of the unit, the same in both processes.
        file: The shared file; it is made by the process that comes first.
    """
    roles = widths(interface.inputs), widths(interface.recorded)
    size = _ALIGNMENT + sum(_bytes(kind, n) for role in roles for kind, n in role.items() if kind.is_number)
    with file.open("a+b") as opened:
        opened.truncate(size)
        memory = mmap.mmap(opened.fileno(), size)
    columns: list[dict[Type, Column]] = []
    at = 0
    for role in roles:
        columns.append({})
        for kind, n in role.items():
            if kind.is_number:
                columns[-1][kind] = np.frombuffer(memory, DTYPES[kind], n, at)
                at += _bytes(kind, n)
            else:
                columns[-1][kind] = zeros(kind, n)
    return columns[0], columns[1]


def texts(columns: TypedColumns) -> list[list[Any]]:
    """The values of columns that are no numbers."""
    return [column.tolist() for kind, column in columns.items() if not kind.is_number]


def put_texts(columns: TypedColumns, values: list[list[Any]]) -> None:
    """Write the values that `texts` gave; an empty list, where they were not requested, changes nothing.

    Raises:
        UnreadableMessageError: They are not those of these columns.
    """
    if not values:
        return
    kinds = [kind for kind in columns if not kind.is_number]
    if len(values) != len(kinds):
        raise UnreadableMessageError(f"texts of {len(values)} types")
    for kind, items in zip(kinds, values, strict=True):
        of_kind = bytes if kind is Type.BINARY else str
        if len(items) != columns[kind].size or not all(isinstance(item, of_kind) for item in items):
            raise UnreadableMessageError(f"other values of type {kind.value} than were asked for")
        columns[kind][:] = items


def _bytes(kind: Type, n: int) -> int:
    return -(-n * np.dtype(DTYPES[kind]).itemsize // _ALIGNMENT) * _ALIGNMENT
