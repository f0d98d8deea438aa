"""What a unit is made from, and how it runs, as facts."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from fmus.reading.archive import InterfaceType
from fmus.toolchain.version import Version


@dataclass(frozen=True)
class SourceDescription:
    """What a unit is made from, and how it runs: facts for summaries, files and checks."""

    kind: str
    """The name of the block, or of the FMU's model."""
    file: Path | None = None
    """The FMU file; `None` for a block in this process."""
    version: Version | None = None
    """The version of FMI; `None` for a block in this process."""
    isolated: float | None = None
    """[s] The time that one call may take in a process of its own; `None` for a unit in this process."""
    interface_type: InterfaceType | None = None
    """The interface type of FMI that is used; `None` for a block in this process."""
    requested: bool = field(default=False, compare=False)
    """Whether a person has asked for that process; if not, it follows from who has built the FMU."""

    @property
    def runs_as(self) -> str:
        """How the unit runs, in words."""
        if self.version is None:
            return "block in this process"
        integrated = InterfaceType.MODEL_EXCHANGE
        return f"FMI {self.version}.0" + (f", {integrated.in_words}" if self.interface_type is integrated else "")
