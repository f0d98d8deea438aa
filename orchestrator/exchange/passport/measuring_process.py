"""The process that measures: it imports once what all measurements need, and a copy of it carries out each of them.

A copy is made by `fork`, in a fraction of the time that a new process takes to start; systems without it (Windows)
start a new process for each measurement.
"""

from __future__ import annotations

import os
import tempfile
from dataclasses import replace
from functools import cache
from pathlib import Path

from components.interfaces.problem import RequestError
from fmus.reading.archive import VALID_FMU, Archive
from fmus.reading.opening import open_fmu
from fmus.reading.unpack import unpack
from fmus.toolchain.child_process import ParentProcess
from fmus.toolchain.typed_messages import written
from fmus.units.unit import EndRequested, UnitError
from orchestrator.exchange.passport import running
from orchestrator.exchange.passport.workplace import Answer, Order, Workplace

_PREPARED = running  # what every measurement needs is imported before the first order comes


def main() -> None:
    """Have orders carried out until the parent process has ended."""
    parent = ParentProcess()
    os.chdir(tempfile.gettempdir())  # whatever the FMU writes to its working folder goes with the measurement
    parent.answer(Answer())  # it has started
    while True:
        try:
            order: Order = parent.request()
        except EOFError:
            return
        _read(order.path, lenient=order.lenient)
        if not hasattr(os, "fork") or (copy := os.fork()) == 0:
            _carry_out(order, parent)
        else:
            _, status = os.waitpid(copy, 0)
            if code := os.waitstatus_to_exitcode(status):
                parent.answer(Answer(death=code))


@cache
def _read(path: Path, *, lenient: bool) -> Archive:
    """The FMU; its description is read once, and nothing of it runs."""
    return open_fmu(path, lenient=lenient)


def _carry_out(order: Order, parent: ParentProcess) -> None:
    """Carry out an order and end the process; the FMU has no chance to crash when its measurement is complete."""
    code = 1
    try:
        parent.answer(_answer(order, parent))
        code = 0
    finally:
        os._exit(code)


def _answer(order: Order, parent: ParentProcess) -> Answer:
    try:
        assert order.measurement is not None  # noqa: S101 - only the parent's template has none
        archive = _read(order.path, lenient=order.lenient)
        folder = Path(tempfile.mkdtemp()).resolve()
        unpack(archive.path, folder, archive.path.name, VALID_FMU)
        place = Workplace(replace(archive, unpacked=folder), parent)
        return Answer(written(order.measurement(place, *order.arguments, **order.options)))
    except UnitError as error:
        return Answer(fault=error.reason)
    except EndRequested as end:
        return Answer(fault=str(end))
    except RequestError as error:
        return Answer(fault="; ".join(problem.found for problem in error.problems))


if __name__ == "__main__":
    main()
