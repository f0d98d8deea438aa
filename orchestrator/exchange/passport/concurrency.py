"""Two instances in one process: they step in turn, and in two threads at once, and neither may see the other."""

from __future__ import annotations

import threading
import time
from functools import partial
from typing import Final

import numpy as np

from fmus.reading.archive import Archive
from orchestrator.exchange.passport.bench import Bench, MeasurementError
from orchestrator.exchange.passport.determinism import (
    INTERLEAVED,
    OTHER_SEED,
    PROCESSES,
    THREADS,
    Driven,
    compared,
)
from orchestrator.exchange.passport.excitation import course
from orchestrator.exchange.passport.passport_line import Line
from orchestrator.exchange.passport.running import Course, Rows, Running, first_difference, followed
from orchestrator.exchange.passport.workplace import Workplace

_AHEAD: Final = 3
"""The number of steps that the first instance has made when the second begins."""
_TIME: Final = 1.0
"""[s] How long threads are tried."""
_MOST_ROUNDS: Final = 50


def drive_in_turn(place: Workplace, given: Course, other: Course) -> Rows:
    """The rows of an instance that steps in turn with another one, which has other inputs."""
    place.tell("driving two instances in turn")
    with Running(place.archive, given.h, name="first") as first:
        parts = [followed(first, given, last=_AHEAD)]
        with Running(place.archive, given.h, name="second") as second:
            followed(second, other, last=0)
            for k in range(_AHEAD, given.steps):
                followed(second, other, k - _AHEAD, k - _AHEAD + 1)
                parts.append(followed(first, given, k, k + 1))
    return joined(parts)


def joined(parts: list[Rows]) -> Rows:
    """Rows one after the other."""
    return {kind: np.concatenate([part[kind] for part in parts]) for kind in parts[0]}


def drive_in_threads(place: Workplace, given: Course, other: Course, expected: Rows) -> tuple[int, Rows]:
    """Drive two instances at once, again and again.

    Returns:
        How many times, and the rows of the first instance the last time, which is the first at which they differ.
    """
    place.tell("driving two instances in two threads")
    ends, rounds = time.monotonic() + _TIME, 0
    rows = expected
    while rounds < _MOST_ROUNDS and (rounds == 0 or time.monotonic() < ends):
        rows = _both(place.archive, given, other)
        rounds += 1
        if first_difference(expected, rows, place.archive.interface.outputs) is not None:
            break
    return rounds, rows


def _both(archive: Archive, given: Course, other: Course) -> Rows:
    together = threading.Barrier(2)
    found: dict[str, Rows] = {}
    faults: list[Exception] = []

    def drive(name: str, mine: Course) -> None:
        try:
            with Running(archive, mine.h, name=name) as running:
                together.wait()
                # without a pause the thread that runs keeps the interpreter, on a busy machine to its end
                found[name] = followed(running, mine, pause=partial(time.sleep, 0))
        except Exception as error:  # noqa: BLE001 - passed on to the thread that waits
            together.abort()
            faults.append(error)

    threads = [threading.Thread(target=drive, args=pair) for pair in (("first", given), ("second", other))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    real = [fault for fault in faults if not isinstance(fault, threading.BrokenBarrierError)]
    if real:
        raise real[0]
    return found["first"]


def lines(bench: Bench, baseline: Driven) -> list[Line]:
    """The lines about two instances."""
    if bench.archive.only_once:
        why = "it declares that a process can hold only one instance"
    elif not baseline.same_everywhere:
        why = f"two runs differ anyway: see {PROCESSES.key}"
    else:
        return [_in_turn(bench, baseline), _in_threads(bench, baseline)]
    return [topic.does_not_apply(why) for topic in (INTERLEAVED, THREADS)]


def _other(bench: Bench, baseline: Driven) -> Course:
    return course(bench.archive, baseline.course.h, baseline.course.steps, OTHER_SEED)


def _in_turn(bench: Bench, baseline: Driven) -> Line:
    try:
        rows = bench.measure(drive_in_turn, baseline.course, _other(bench, baseline))
    except MeasurementError as error:
        return INTERLEAVED.fails(str(error))
    fine = "the rows of one are bit-identical to those that it shows alone"
    return compared(INTERLEAVED, bench.archive, baseline.rows, rows, fine)


def _in_threads(bench: Bench, baseline: Driven) -> Line:
    try:
        rounds, rows = bench.measure(drive_in_threads, baseline.course, _other(bench, baseline), baseline.rows)
    except MeasurementError as error:
        return THREADS.fails(str(error))
    fine = f"{rounds} times {baseline.course.steps} steps are bit-identical to those that it makes alone"
    return compared(THREADS, bench.archive, baseline.rows, rows, fine)
