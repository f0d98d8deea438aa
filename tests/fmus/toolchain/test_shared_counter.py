"""A counter wakes the process that waits for it, and a wait ends in time."""

from __future__ import annotations

import mmap
import os
import signal
import threading
import time

import pytest

from fmus.toolchain.shared_counter import SharedCounter, counters_work
from tests.waiting import wait_until

pytestmark = pytest.mark.skipif(not counters_work(), reason="it needs the futex of Linux on x86-64")


@pytest.fixture
def memory():
    return mmap.mmap(-1, 4096)


def test_it_counts_and_begins_again_after_the_largest(memory):
    counter, same = SharedCounter(memory, 64), SharedCounter(memory, 64)
    assert [counter.increase() for _ in range(3)] == [1, 2, 3]
    assert same.value == 3
    memory[64:68] = b"\xff" * 4
    assert counter.increase() == 0
    assert SharedCounter(memory, 0).value == 0


def test_a_wait_ends_with_the_count_or_in_time(memory):
    counter = SharedCounter(memory, 0)
    counter.increase()
    assert counter.is_past(0, 10.0)
    began = time.monotonic()
    assert not counter.is_past(1, 0.05)
    assert time.monotonic() - began > 0.04


@pytest.mark.parametrize("pause", [0.0, 0.2], ids=["awake", "asleep"])
def test_two_processes_take_turns(memory, pause):
    requests, replies = SharedCounter(memory, 0), SharedCounter(memory, 64)
    child = os.fork()
    if child == 0:
        for n in range(100):
            while not requests.is_past(n, 10.0):
                pass
            replies.increase()
        os._exit(0)
    try:
        for n in range(100):
            if n % 50 == 0:
                time.sleep(pause)
            requests.increase()
            wait_until(lambda n=n: replies.is_past(n, 10.0))
    finally:
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)


def test_a_signal_ends_a_wait(memory):
    counter = SharedCounter(memory, 0)
    threading.Timer(1.0, os.kill, [os.getpid(), signal.SIGINT]).start()
    with pytest.raises(KeyboardInterrupt):
        counter.is_past(0, 100_000.0)


def test_the_memory_can_be_released(memory):
    counter = SharedCounter(memory, 0)
    with pytest.raises(BufferError):
        memory.close()
    counter.release()
    memory.close()
