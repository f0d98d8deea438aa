"""Sources: what the units of a system are made from, with the parameter values that are given."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, Protocol

from components.interfaces.block import Block
from fmus.reading.archive import Archive
from fmus.reading.opening import open_fmu
from fmus.unit_interface import Interface
from fmus.units.block_unit import BlockUnit, interface_of
from fmus.units.make import fmu_unit
from fmus.units.unit import Unit


class Source(Protocol):
    """What a unit of a system is made from, with the parameter values that are given."""

    @property
    def parameters(self) -> Mapping[str, Any]:
        """Values by name; where the interface has start values, only those that differ."""
        ...

    @property
    def interface(self) -> Interface:
        """What the unit looks like from outside. Raises `RequestError`."""
        ...

    def make(self, name: str) -> Unit:
        """The running unit."""
        ...


@dataclass(frozen=True)
class InProcess:
    """A block that runs in this process, with its parameter values."""

    block: type[Block[Any, Any, Any]]
    parameters: Mapping[str, Any]

    @property
    def interface(self) -> Interface:
        """What the unit looks like from outside."""
        return interface_of(self.block)

    def make(self, name: str) -> Unit:
        """The running unit."""
        return BlockUnit(name, self.block)


@dataclass(frozen=True)
class Fmu:
    """An FMU file, with the parameter values that differ from its own start values.

    `lenient` runs a file though it breaks rules of FMI; `archive.remarks` says which. `isolated` runs it in a process
    of its own, and gives the time [s] that one of its calls may take.
    """

    path: Path
    parameters: Mapping[str, Any] = field(default_factory=dict[str, Any])
    lenient: bool = False
    isolated: float | None = None

    @cached_property
    def archive(self) -> Archive:
        """The file, opened and understood. Raises `RequestError`."""
        return open_fmu(Path(self.path), self.parameters, lenient=self.lenient)

    @property
    def interface(self) -> Interface:
        """What the unit looks like from outside."""
        return self.archive.interface

    def changed(self, **changes: Any) -> Fmu:
        """The same file with other `parameters`, or `isolated`; it is read again only where its arrays may change."""
        made = dataclasses.replace(self, **changes)
        if "parameters" not in changes or not self.archive.structural:
            vars(made)["archive"] = self.archive
        return made

    def make(self, name: str) -> Unit:
        """The running unit."""
        if self.isolated is None:
            return fmu_unit(name, self.archive)
        from fmus.units.isolated_unit import IsolatedUnit  # noqa: PLC0415 - only who asks for it needs it

        return IsolatedUnit(name, self.archive, self.parameters, lenient=self.lenient, patience=self.isolated)


def block_source(value: Block[Any, Any, Any]) -> InProcess:
    """A block with its values, as a unit of a system."""
    return InProcess(type(value), {f.name: getattr(value, f.name) for f in dataclasses.fields(value)})  # type: ignore[arg-type]
