"""The same inputs, the same bits: in two processes, in one process again, after a reset, and after going back.

One course is driven once; every other way to drive it has to show the same rows, bit by bit.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

from fmus.reading.archive import Archive
from fmus.units.capabilities import StateCapability
from fmus.units.unit import NoResetError
from orchestrator.exchange.passport.bench import Bench, MeasurementError
from orchestrator.exchange.passport.excitation import course, own_step, usual_steps
from orchestrator.exchange.passport.passport_line import Line, Topic
from orchestrator.exchange.passport.running import Course, Rows, Running, first_difference, followed
from orchestrator.exchange.passport.workplace import Workplace

PROCESSES: Final = Topic("determinism.processes", "The same inputs give the same bits in two processes")
AGAIN: Final = Topic("determinism.again", "A second instance in the same process gives the same bits")
RESET: Final = Topic("state.reset", "After a reset it gives the same bits")
RESTORED: Final = Topic("state.restored", "Back in a saved state it gives the same bits")
SERIALIZED: Final = Topic("state.serialized", "A state that was written as bytes is continued by another process")
INTERLEAVED: Final = Topic("instances.interleaved", "Two instances that step in turn do not mix")
THREADS: Final = Topic("instances.threads", "Two instances in two threads do not mix")

SEED, OTHER_SEED = 11, 12


@dataclass(frozen=True)
class Driven:
    """The course that every other one is compared with."""

    course: Course
    rows: Rows
    same_everywhere: bool
    """Whether another process shows the same rows."""


def drive_once(place: Workplace, given: Course) -> Rows:
    """The rows of one instance."""
    place.tell("driving one instance")
    with Running(place.archive, given.h) as running:
        return followed(running, given)


def drive_again(place: Workplace, given: Course) -> Rows:
    """The rows of the second instance in a process, when the first has been driven."""
    place.tell("driving the first instance")
    with Running(place.archive, given.h, name="first") as first:
        followed(first, given)
        place.tell("driving the second instance")  # the first keeps the library loaded
        with Running(place.archive, given.h, name="second") as second:
            return followed(second, given)


def drive_after_reset(place: Workplace, given: Course) -> Rows | None:
    """The rows after a reset; None for a library without that function."""
    with Running(place.archive, given.h) as running:
        place.tell("driving the instance before its reset")
        followed(running, given, last=saved_at(given))
        place.tell("resetting the instance")
        try:
            running.unit.reset()
        except NoResetError:
            return None
        running.start_over()
        place.tell("driving the instance after its reset")
        return followed(running, given)


def drive_from_saved_state(place: Workplace, given: Course) -> Rows:
    """The rows after the state was saved, when the instance has gone on and come back."""
    with Running(place.archive, given.h) as running:
        place.tell("driving the instance before its state is saved")
        followed(running, given, last=saved_at(given))
        assert running.unit.state is not None  # noqa: S101 - the caller has asked
        place.tell("saving its state")
        state = running.unit.state.save()
        place.tell("driving the instance after its state was saved")
        followed(running, given, first=saved_at(given))
        place.tell("restoring its state")
        running.unit.state.restore(state)
        running.tick = saved_at(given)
        place.tell("driving the instance from its saved state")
        rows = followed(running, given, first=saved_at(given))
        running.unit.state.forget(state)
        return rows


def write_state(place: Workplace, given: Course) -> bytes:
    """The state before a step, as bytes."""
    with Running(place.archive, given.h) as running:
        place.tell("driving the instance before its state is written")
        followed(running, given, last=saved_at(given))
        place.tell("writing its state")
        state = _state(running)
        return state.serialized(state.save())


def drive_from_written_state(place: Workplace, given: Course, content: bytes) -> Rows:
    """The rows of an instance that is given a state as bytes."""
    with Running(place.archive, given.h) as running:
        place.tell("reading its state")
        state = _state(running)
        state.restore(state.deserialized(content))
        running.tick = saved_at(given)
        place.tell("driving the instance from the state that it read")
        return followed(running, given, first=saved_at(given))


def saved_at(given: Course) -> int:
    """The step before which a state is saved."""
    return given.steps // 2


def _state(running: Running) -> StateCapability:
    assert running.unit.state is not None  # noqa: S101 - the caller has asked
    return running.unit.state


def driven(bench: Bench) -> tuple[Driven | None, list[Line]]:
    """Drive the course in two processes, in different seconds of the clock.

    Returns:
        The course with its rows, None where the FMU does not get through; and the line about it.
    """
    h = own_step(bench.archive)
    given = course(bench.archive, h, usual_steps(bench.archive, h), SEED)
    try:
        rows = bench.measure(drive_once, given)
        second = int(time.time())
        while int(time.time()) == second:  # an FMU that depends on the time of day would not show it otherwise
            time.sleep(0.01)
        again = bench.measure(drive_once, given)
    except MeasurementError as error:
        return None, [PROCESSES.fails(str(error))]
    line = compared(PROCESSES, bench.archive, rows, again, f"{_size(rows)} are bit-identical")
    return Driven(given, rows, first_difference(rows, again, bench.archive.interface.outputs) is None), [line]


def lines(bench: Bench, baseline: Driven) -> list[Line]:
    """The lines that compare other ways to drive the course with the first."""
    if not baseline.same_everywhere:
        why = f"two runs differ anyway: see {PROCESSES.key}"
        return [topic.does_not_apply(why) for topic in (AGAIN, RESET, RESTORED, SERIALIZED)]
    return [_again(bench, baseline), _reset(bench, baseline), _restored(bench, baseline), _serialized(bench, baseline)]


def _again(bench: Bench, baseline: Driven) -> Line:
    try:
        rows = bench.measure(drive_again, baseline.course)
    except MeasurementError as error:
        return AGAIN.fails(str(error))
    return compared(AGAIN, bench.archive, baseline.rows, rows, f"{_size(rows)} are those of a new process")


def _reset(bench: Bench, baseline: Driven) -> Line:
    try:
        rows = bench.measure(drive_after_reset, baseline.course)
    except MeasurementError as error:
        return RESET.fails(str(error))
    if rows is None:
        return RESET.does_not_apply("its library has no function for it")
    return compared(RESET, bench.archive, baseline.rows, rows, f"{_size(rows)} are those of a new instance")


def _restored(bench: Bench, baseline: Driven) -> Line:
    if not bench.archive.interface.rolls_back:
        return RESTORED.does_not_apply("it does not declare that its state can be saved")
    try:
        rows = bench.measure(drive_from_saved_state, baseline.course)
    except MeasurementError as error:
        return RESTORED.fails(str(error))
    fine = f"saved before step {saved_at(baseline.course) + 1}; {_size(rows)} after it are bit-identical"
    return compared(RESTORED, bench.archive, _from_saved(baseline), rows, fine)


def _serialized(bench: Bench, baseline: Driven) -> Line:
    if not (bench.archive.interface.rolls_back and bench.archive.interface_type.canSerializeFMUstate):
        return SERIALIZED.does_not_apply("it does not declare that its state can be written")
    try:
        content = bench.measure(write_state, baseline.course)
        rows = bench.measure(drive_from_written_state, baseline.course, content)
    except MeasurementError as error:
        return SERIALIZED.fails(str(error))
    at = f"step {saved_at(baseline.course) + 1} ({len(content)} bytes)"
    fine = f"written before {at}; {_size(rows)} after it are bit-identical"
    return compared(SERIALIZED, bench.archive, _from_saved(baseline), rows, fine)


def _from_saved(baseline: Driven) -> Rows:
    return {kind: table[saved_at(baseline.course) + 1 :] for kind, table in baseline.rows.items()}


def compared(topic: Topic, archive: Archive, one: Rows, other: Rows, fine: str) -> Line:
    """The line about two series of rows that have to be the same.

    Args:
        topic: What it is about.
        archive: The FMU.
        one: The rows as they should be.
        other: The rows that were shown.
        fine: The evidence where they are the same.
    """
    if not archive.interface.outputs:
        return topic.does_not_apply("it has no outputs to compare")
    difference = first_difference(one, other, archive.interface.outputs)
    if difference is None:
        return topic.passes(fine)
    row, name, expected, found = difference
    return topic.fails(f"`{name}` differs first in row {row}: {_shown(expected)} and {_shown(found)}")


def _shown(value: Any) -> str:
    return repr(value.item() if hasattr(value, "item") else value)


def _size(rows: Rows) -> str:
    tables: Sequence[Any] = list(rows.values())
    return f"{len(tables[0])} rows of {sum(t.shape[1] for t in tables)} values" if tables else "no rows"
