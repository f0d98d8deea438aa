"""The messages of a unit, which do not grow with the run, and of which those that say why come first."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from fmus.toolchain.foreign_text import plain
from fmus.toolchain.limits import LONGEST_MESSAGE, MOST_MESSAGES, MOST_TOLD
from fmus.units.message_log import MessageLog
from fmus.units.unit import UnitError


@given(texts=st.lists(st.text(max_size=3 * LONGEST_MESSAGE), max_size=4 * MOST_MESSAGES))
def test_the_last_messages_are_kept_each_to_a_length(texts):
    log = MessageLog()
    for text in texts:
        log.append(text)
    kept = texts[-MOST_MESSAGES:]
    assert [message.text for message in log] == [plain(text) for text in kept]
    assert log.dropped == len(texts) - len(kept)
    assert sum(map(len, log.said())) <= (MOST_TOLD + 1) * (LONGEST_MESSAGE + 50)


def test_what_repeats_is_said_once_and_what_is_left_out_is_counted():
    log = MessageLog()
    for _ in range(3 * MOST_MESSAGES):
        log.append("too hot")
    assert log.said() == [f"({2 * MOST_MESSAGES} other messages are left out)", "too hot"]
    assert UnitError("plant", "returned an error", log).reason == (
        "returned an error: (40 other messages are left out); too hot"
    )
    log.clear()
    assert (log.dropped, log.said()) == (0, [])


def test_warnings_do_not_bury_why_something_failed():
    log = MessageLog()
    for k in range(1000):
        log.append(f"warm {k}", 1)
    assert log.said() == ["(995 other messages are left out)", *(f"warm {k}" for k in range(995, 1000))]
    log.append("too hot", 3)
    for k in range(1000):
        log.append(f"still warm {k}", 1)
    assert log.said() == ["(2000 other messages are left out)", "too hot"]
    log.append("a status that FMI does not have", -1)
    assert log.said()[1:] == ["too hot", "a status that FMI does not have"]
