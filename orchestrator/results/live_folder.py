"""The folder of a run that lasts: what is written to it besides rows, and what a person may do to it meanwhile."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, Final

from fmus.toolchain.archives import unwritable
from orchestrator.results.claimed_folder import ClaimedFolder
from orchestrator.results.manifest import reason, remove
from orchestrator.results.run_folder import (
    DRAFT,
    FIGURES,
    RECORDING,
    RESERVE,
    RUN,
    SYSTEM,
    write_system,
)
from orchestrator.results.summary import write_summary
from orchestrator.system.experiment import Scenario

_RESERVED: Final = 2**15
"""[byte] Room that is kept for the summary, which is written when the disk may be full."""


class LiveFolder:
    """The folder of a run that lasts, with what is known before the first step.

    Args:
        claimed: The folder, which is removed again where this cannot be written.
        scenario: What is run.
        known: The summary as it is known before the first step.
        begun: Called with the folder when it is there, and again when it is another one.

    Raises:
        RequestError: The folder cannot be written to.
    """

    def __init__(
        self,
        claimed: ClaimedFolder,
        scenario: Scenario,
        known: Mapping[str, Any],
        begun: Callable[[Path], None] = lambda _: None,
    ) -> None:
        self._claimed, self._scenario, self._known, self._begun = claimed, scenario, known, begun
        try:
            self._begin()
            (self.path / RESERVE).write_bytes(bytes(_RESERVED))
        except BaseException as error:
            claimed.abandon()
            if isinstance(error, OSError):
                raise unwritable(claimed.named, error) from error
            raise
        begun(self.path)

    @property
    def path(self) -> Path:
        """Where the folder is now."""
        return self._claimed.path

    @property
    def named(self) -> Path:
        """Where the folder is now, as a person names it."""
        return self._claimed.named

    def _begin(self) -> None:
        (self.path / FIGURES).mkdir(exist_ok=True)
        write_system(self._scenario, self.path)
        self._digest = _digest(self.path / SYSTEM)
        write_summary(self._known, self.path, DRAFT)

    def follow(self) -> bool:
        """Go on where the folder is now; return whether it still is the same one, with what was written to it."""
        before = self.path
        same = self._claimed.follow()
        if not same:
            self._begin()
        if self.path != before:
            self._begun(self.path)
        return same

    def write_draft(self, content: Mapping[str, Any]) -> None:
        """Write what is known of the run so far, for the case that this process does not come to its end."""
        with suppress(OSError):
            write_summary(content, self.path, DRAFT)

    def make_room(self) -> None:
        """Remove a recording that is not whole, and that can be made again from the rows."""
        with suppress(OSError):
            remove(self.path, RUN, [RECORDING, f".{RECORDING}"])

    def conclude(self, content: Mapping[str, Any]) -> str:
        """Write the summary, and remove what is not needed any more.

        Returns:
            Why that was not possible, in words; empty where it was.
        """
        try:
            remove(self.path, RUN, [RESERVE])
            write_summary(content, self.path)
            remove(self.path, RUN, [DRAFT])
        except OSError as error:
            return f"summary.json cannot be written to {self.named} ({reason(error)})"
        return ""

    def remarks(self) -> Iterator[str]:
        """What a person should know of the folder, as texts."""
        yield from self._claimed.remarks
        system = self.path / SYSTEM
        with suppress(OSError):  # then there is more that is wrong with the folder, which is told elsewhere
            if not system.is_file():
                write_system(self._scenario, self.path)
                yield f"{SYSTEM} was removed during the run, and has been written again"
            elif _digest(system) != self._digest:
                yield f"{SYSTEM} is not the one that this run has written: something has replaced it"


def _digest(path: Path) -> bytes:
    return hashlib.sha256(path.read_bytes()).digest()
