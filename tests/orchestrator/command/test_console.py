"""What is said on the terminal stands there as it was written."""

from __future__ import annotations

import re
import time

import pytest
from rich.table import Table

from orchestrator.command import console
from tests.waiting import wait_until


@pytest.mark.parametrize("stream", [console.out, console.err], ids=["out", "err"])
def test_a_pattern_does_not_become_an_emoji(stream):
    with stream.capture() as said:
        stream.print("--record plant.*:x: and plant.*:-1:")
    assert said.get() == "--record plant.*:x: and plant.*:-1:\n"


def test_what_was_done_keeps_a_line_and_what_goes_on_does_not():
    with console.err.capture() as said, console.working() as progress:
        progress.now("built to be seen for a moment")
        progress.done("an FMU")
    assert said.get() == "an FMU\n"


def test_without_a_terminal_a_line_now_and_then_says_what_goes_on_and_how_long(monkeypatch, capfd):
    monkeypatch.setattr(console, "TELLS_EVERY", 0.05)
    ticks = iter(range(10**6))
    with console.working() as progress:
        progress.now(lambda: f"stepping: {next(ticks)} s of 9 s")
        wait_until(lambda: next(ticks) > 4 or time.sleep(0.1))
        progress.now("drawing\x1b[2J")
        said = ""
        while "drawing" not in said:
            said += capfd.readouterr().err
    lines = said.splitlines()
    assert re.fullmatch(r"stepping: \d+ s of 9 s \(0 s\)", lines[0])
    assert re.fullmatch(r"drawing\\x1b\[2J \(\d+ s\)", lines[-1])
    capfd.readouterr()
    time.sleep(0.2)
    assert capfd.readouterr().err == ""


def test_on_a_terminal_the_status_line_is_asked_whenever_it_is_drawn():
    asked = []
    line = console.StatusLine(console.err.status(""))
    line.now(lambda: asked.append(1) or f"tick {len(asked)}")
    assert [str(line.__rich__()), str(line.__rich__())] == ["tick 1", "tick 2"]
    line.end()


HOSTILE = "a [red]b[/blue] \x1b[2J\x1b]0;title\x07 \x9b31m \u202egnp.exe :x: ä\n\tend\r"
SHOWN = "a [red]b[/blue] \\x1b[2J\\x1b]0;title\\x07 \\x9b31m \\u202egnp.exe :x: ä\n"


@pytest.mark.parametrize("stream", [console.out, console.err], ids=["out", "err"])
def test_foreign_text_commands_no_terminal(stream):
    table = Table("[b]name", box=None)
    table.add_row(HOSTILE)
    with stream.capture() as said:
        stream.print(HOSTILE)
        stream.print(HOSTILE, style="red")
        stream.print(table)
    text = said.get()
    assert text.count(SHOWN) == 2
    assert "[b]name" in text
    assert not {"\x1b", "\x07", "\x9b", "\u202e", "\r"} & {*text}


def test_foreign_text_in_the_status_line_and_in_results_commands_no_terminal():
    with console.err.capture() as said, console.working() as progress:
        progress.now(HOSTILE)
        progress.done(HOSTILE)
    assert said.get().startswith(SHOWN)


def test_a_text_of_any_length_is_shown_in_part():
    assert console.visible("a" * 10_000) == "a" * 10_000
    assert console.visible("a" * 10**6) == f"{'a' * 5000} ... (990000 characters) ... {'a' * 5000}"
