"""What is said on the terminal stands there as it was written."""

from __future__ import annotations

import pytest

from orchestrator.command import console


@pytest.mark.parametrize("stream", [console.out, console.err], ids=["out", "err"])
def test_a_pattern_does_not_become_an_emoji(stream):
    with stream.capture() as said:
        stream.print("--record plant.*:x: and plant.*:-1:", markup=False)
    assert said.get() == "--record plant.*:x: and plant.*:-1:\n"


def test_what_was_done_keeps_a_line_and_what_goes_on_does_not():
    with console.err.capture() as said, console.working() as progress:
        progress.now("built to be seen for a moment")
        progress.done("an FMU")
    assert said.get() == "an FMU\n"
