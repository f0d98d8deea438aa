"""What a measurement works with, in its process: the FMU, units of it, and a line to the process that waits."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from fmus.reading.archive import Archive
from fmus.toolchain.child_process import ParentProcess


@dataclass(frozen=True)
class Order:
    """A request to a measuring process."""

    path: Path
    lenient: bool
    measurement: Callable[..., Any] | None = None
    """A function of a module, which the process imports."""
    arguments: tuple[Any, ...] = ()
    options: Mapping[str, Any] = field(default_factory=dict[str, Any])

    def to(self, measurement: Callable[..., Any], arguments: tuple[Any, ...], options: Mapping[str, Any]) -> Order:
        """The order to carry out a measurement on the same FMU."""
        return replace(self, measurement=measurement, arguments=arguments, options=dict(options))


@dataclass(frozen=True)
class Answer:
    """An answer of a measuring process: a stage that begins, or the end."""

    value: bytes | None = None
    """The result, as `fmus.toolchain.typed_messages` writes it."""
    fault: str | None = None
    """Why there is no value."""
    death: int | None = None
    """The exit code of the process that was to answer, or the negative number of the signal that ended it."""
    stage: str | None = None
    """What the measurement does from now on; another answer follows."""


@dataclass(frozen=True)
class Workplace:
    """The FMU that is measured."""

    archive: Archive
    """The FMU, unpacked once: all its units in the process share its library, as in most other tools."""
    parent: ParentProcess

    def tell(self, stage: str) -> None:
        """Say what is done from now on: a crash or a hang is reported with it, and patience begins anew."""
        self.parent.answer(Answer(stage=stage))
        self.parent.request()  # it has been heard
