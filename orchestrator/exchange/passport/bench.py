"""The measuring of an FMU: each measurement has a process of its own, which may crash or hang."""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType
from typing import IO, Any, Concatenate, Final, ParamSpec, Self, TypeVar, get_type_hints

from fmus.reading.archive import Archive
from fmus.toolchain.child_death import ChildDiedError, ChildSilentError, Death, death_in_words
from fmus.toolchain.child_process import ChildProcess
from fmus.toolchain.scratch import scratch_folder
from fmus.toolchain.typed_messages import UnreadableMessageError, read
from orchestrator.exchange.passport.workplace import Answer, Order, Workplace

P = ParamSpec("P")
T = TypeVar("T")

STAGE_PATIENCE: Final = 10.0
"""[s] The time that each stage of a measurement may take."""
_STARTING: Final = 60.0
"""[s] The time that the start of the process may take."""
_LONGEST: Final = 400
"""The number of characters of a reason; the messages of an FMU may be longer than any page."""


class MeasurementError(RuntimeError):
    """A measurement that came to no result.

    Args:
        reason: Why, in words.
        stage: What the measurement was doing.
    """

    def __init__(self, reason: str, stage: str) -> None:
        self.reason, self.stage = reason, stage
        super().__init__(f"{reason} ({stage})" if stage else reason)


class Bench:
    """Measures one FMU, in a `with` statement.

    Args:
        archive: The FMU.
        lenient: Whether broken rules of FMI are overlooked.
        patience: The time [s] that each stage of a measurement may take.
    """

    def __init__(self, archive: Archive, *, lenient: bool, patience: float = STAGE_PATIENCE) -> None:
        self.archive = archive
        self.patience = patience
        self._order = Order(archive.path.resolve(), lenient)
        self._resources = ExitStack()
        self._child: ChildProcess[Answer] | None = None

    def __enter__(self) -> Self:
        self._folder = Path(self._resources.enter_context(scratch_folder("bench")))
        self._nothing: IO[bytes] = self._resources.enter_context(Path(os.devnull).open("wb"))
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._end()
        self._resources.close()

    def measure(
        self, measurement: Callable[Concatenate[Workplace, P], T], *arguments: P.args, **options: P.kwargs
    ) -> T:
        """Carry out a measurement in a process of its own.

        Args:
            measurement: A function of a module, which is given the FMU and the arguments.
            arguments: What it is given.
            options: The same, by name.

        Raises:
            MeasurementError: The FMU failed, crashed or hung.
        """
        stage = ""
        try:
            answer = self._process().ask(self._order.to(measurement, arguments, options), self.patience)
            while answer.stage is not None:
                stage = answer.stage
                answer = self._process().ask(None, self.patience)
        except ChildSilentError as silence:
            self._end()
            raise MeasurementError(f"it hung: no answer within {silence.within:g} s", stage) from silence
        except ChildDiedError as error:
            self._end()
            raise MeasurementError(f"its process died ({death_in_words(error.death)})", stage) from error
        except UnreadableMessageError as error:
            self._end()
            raise MeasurementError("its process gave an answer that is none", stage) from error
        if answer.death is not None:
            raise MeasurementError(f"its process died ({death_in_words(Death(answer.death))})", stage)
        if answer.fault is not None:
            raise MeasurementError(self._plain(answer.fault), stage)
        try:
            return read(answer.value or b"", get_type_hints(measurement).get("return", Any))
        except UnreadableMessageError as error:
            raise MeasurementError("its process gave a result that is none", stage) from error

    def _process(self) -> ChildProcess[Answer]:
        """The measuring process, which is started where there is none."""
        if self._child is None:
            environment = {"TMPDIR": str(self._folder), "OPENBLAS_NUM_THREADS": "1"}
            module = "orchestrator.exchange.passport.measuring_process"
            self._child = ChildProcess(module, Answer, environment, self._nothing)
            self._child.answer(_STARTING)
        return self._child

    def _end(self) -> None:
        if self._child is not None:
            self._child.kill()
            self._child.close()
            self._child = None

    def _plain(self, text: str) -> str:
        """A text without the folders of this machine, in one line."""
        for place in (self._folder, self._folder.resolve(), self.archive.path.resolve().parent):
            text = text.replace(f"{place}{os.sep}", "")
        text = " ".join(re.sub(rf"macrostep_\w+{re.escape(os.sep)}", "", text).split())
        return text if len(text) <= _LONGEST else f"{text[:_LONGEST]} ..."
