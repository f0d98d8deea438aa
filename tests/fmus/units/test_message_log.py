"""The messages of a unit, which do not grow with the run."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from fmus.units.message_log import LONGEST_MESSAGE, MOST_MESSAGES, MessageLog
from fmus.units.unit import UnitError


@given(texts=st.lists(st.text(max_size=3 * LONGEST_MESSAGE), max_size=4 * MOST_MESSAGES))
def test_the_last_messages_are_kept_each_to_a_length(texts):
    log = MessageLog()
    for text in texts:
        log.append(text)
    kept = texts[-MOST_MESSAGES:]
    assert [message[:LONGEST_MESSAGE] for message in log] == [text[:LONGEST_MESSAGE] for text in kept]
    assert log.dropped == len(texts) - len(kept)
    assert sum(map(len, log.said())) <= (MOST_MESSAGES + 1) * (LONGEST_MESSAGE + 50)


def test_what_repeats_is_said_once_and_what_is_left_out_is_counted():
    log = MessageLog()
    for _ in range(3 * MOST_MESSAGES):
        log.append("too hot")
    assert log.said() == [f"({2 * MOST_MESSAGES} earlier messages are left out)", "too hot"]
    assert UnitError("plant", "returned an error", log).reason == (
        "returned an error: (40 earlier messages are left out); too hot"
    )
    log.clear()
    assert (log.dropped, log.said()) == (0, [])
