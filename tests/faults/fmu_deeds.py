"""What becomes of a deed of an FMU in a process of its own: how the run ends, and what is said of it."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from pathlib import Path
from random import Random
from typing import Final

from components.interfaces.quantity import zeros
from fmus.toolchain.version import Version
from fmus.units.unit import UnitError, widths
from orchestrator.system.source import Fmu
from tests.faults.faulty_fmus import faulty, lacking
from tests.faults.fmu_runs import PATIENCE, Ended, run
from tests.faults.scoring import fault

ENDS: Final = {
    "segv": "SIGSEGV",
    "abort": "SIGABRT",
    "exit 0": "exit code 0",
    "_exit 0": "exit code 0",
    "exit 1": "exit code 1",
    "loop": r"no answer to .* within \d",
}
"""Deeds that end an FMU's process, and what is said of them."""
STATUSES: Final = {
    "error": "an error|status 3",
    "fatal": "a fatal error|status 4",
    "discard": "discarded|status 2",
    "pending": "`pending`|status 5",
    "negative": "status -7",
    "least": "status -2147483648",
    "status 99": "status 99",
}
"""Statuses of failures, and what is said of them."""
FATAL: Final = {
    "sleep": "no answer",
    "divide": "SIGFPE",
    "stack": "SIGSEGV",
    "memory": "SIGABRT|SIGSEGV|MemoryError|SIGKILL",
    "log many and fail": r"an error: \(\d+ other messages are left out\); it is too hot$",
    "log markup": r"an error: \[bold\]no\[/nonsense\]",
    "log escape": r"an error: \\x1b\]0;title",
    "log bad UTF-8": "an error: ",
    "log NULL": "an error",
    "log huge": r"an error: x{400} \.\.\.$",
    "fork and die": "SIGABRT",
    "thread dies": "SIGSEGV",
    "kill group": "SIGKILL",
    "SIGTERM": "SIGTERM",
    "SIGUSR1": "SIGUSR1",
    "SIGALRM": "SIGALRM",
    "SIGSTOP": "no answer",
    "SIGFPE": "SIGFPE",
    "SIGKILL": "SIGKILL",
    "SIGSYS": "SIGSYS",
}
"""Deeds that end a run from a step, and what is said of them."""
HARMLESS: Final = {
    "warning": "returned a warning",
    "log many": "it wrote: .*it is warm",
    "log format": None,
    "print": "",
    "read": "",
    "write everywhere": "",
    "write much everywhere": None,
    "close all": None,
    "close streams": "",
    "shorten": "",
    "fork": "",
    "fork and leave": "",
    "fork 64": "",
    "fork itself": "",
    "execute": "",
    "thread": None,
    "handlers": "",
    "mask": "",
    "locale": "",
    "arithmetic": None,
    "folder": "",
    "lost folder": "",
    "environment": "",
    "permissions": "",
    "limits": None,
    "priority": "",
    "stop parent": None,
    "kill parent": None,
    "fork and kill": None,
    "terminate parent": None,
    "trace parent": None,
    "session": "",
    "delete": None,
    "exit handler": None,
    "SIGINT": None,
    "heap": None,
    "SIGHUP": None,
    "alarm": None,
    "SIGPIPE": None,
    "SIGCHLD": "",
    "SIGCONT": "",
}
"""Deeds that do no harm, and what is said of them; None where it may also end the run in order."""
AT_THE_END: Final = re.compile(r"destructor|fmi\d(Terminate|FreeInstance)")
"""Functions in which nothing is lost any more: the run is told as it was, with a remark."""


def stands(ended: Ended, function: str, said: str | None, code: int, rows: int = 0, *, named: bool = True) -> None:
    """Check how a run ended, and whether the function is named that ended it."""
    if said is None:
        assert ended.code in (0, 1), ended
        assert ended.rows >= rows, ended
        return
    assert re.search(said, ended.said, re.MULTILINE), f"`{said}` is not said: {ended}"
    late = bool(AT_THE_END.fullmatch(function))
    assert ended.code == (0 if late else code) or (ended.code == 2 and rows == 0 and not late), ended
    if code and named and "fmi" in function:
        assert function in ended.said or ended.code == 2, f"{function} is not named: {ended}"
    assert ended.rows >= (11 if late else rows) or ended.code == 2, ended
    if not code and not late:
        assert ended.rows == 11, ended


def put(
    group: str,
    kind: str,
    functions: Iterable[str],
    deeds: dict[str, str | None],
    code: int,
    *,
    rows: int = 0,
    way: Callable[..., Ended] = run,
    short: Iterable[str] = (),
    by: str = "",
) -> None:
    """Put faults among the known ones: every deed in every function, for one kind of FMU."""
    for function in functions:
        for deed, said in deeds.items():

            def check(
                folder: Path, _: Random, function: str = function, deed: str = deed, said: str | None = said
            ) -> None:
                options = {"algorithm": "clocked"} if kind == "clocked" else {}
                ended, named = way(faulty(kind, function, deed, folder), folder, **options), deed in ENDS | STATUSES
                stands(ended, function, said, code, rows, named=named)

            of = {"me2": "Model Exchange, ", "me3": "Model Exchange, ", "clocked": "Event Mode, "}.get(kind, "")
            name = f"{of}{function}: {deed}{f' ({by})' if by else ''}"
            fault(group, name, short=f"{function}: {deed}" in short)(check)


def put_random(group: str, kind: str, functions: Iterable[str], rows: int) -> None:
    """Put one fault for each function: a deed that the seed chooses."""
    for function in functions:

        def check(folder: Path, random: Random, function: str = function) -> None:
            deed, said = random.choice(sorted((ENDS | STATUSES).items()))
            stands(run(faulty(kind, function, deed, folder), folder), function, said, 1, rows)

        fault(group, f"{function}: a deed by chance", short=False)(check)


def put_refused(group: str, version: Version) -> None:
    """Put faults of a file that says something else than its library, and of a library that lacks a function."""

    def other_token(folder: Path, _: Random) -> None:
        token = "instantiationToken" if version == Version.FMI3 else "guid"
        path = faulty(str(version), "none", "nothing", folder, **{f'{token}="g"': f'{token}="other"'})
        stands(run(path, folder), "", "refuses to make an instance.*the (GUID|token)|letter", 2)

    def no_step(folder: Path, _: Random) -> None:
        name = f"fmi{version}DoStep"
        stands(run(lacking(version, name, folder), folder), "", name, 2)

    fault(group, "another GUID or token than in its file")(other_token)
    fault(group, "a library without a function for its steps")(no_step)


def put_states(group: str, kind: str, functions: Iterable[str]) -> None:
    """Put faults of the functions that save a state and go back to it, which no ordinary run calls."""
    for function in functions:
        for deed, said in {**ENDS, **{name: STATUSES[name] for name in ("error", "negative", "status 99")}}.items():

            def check(folder: Path, _: Random, function: str = function, deed: str = deed, said: str = said) -> None:
                found = _of_states(faulty(kind, function, deed, folder))
                assert re.search(said, found), found
                assert function in found, found

            fault(group, f"{function}: {deed}", short=False)(check)


def _of_states(path: Path) -> str:
    """What a unit says that saves its state, goes back to it, and releases it."""
    unit = Fmu(path, isolated=PATIENCE).open("fmu")
    try:
        unit.bind(
            *({k: zeros(k, n) for k, n in widths(v).items()} for v in (unit.interface.inputs, unit.interface.outputs))
        )
        unit.enter_initialization({})
        unit.exit_initialization()
        assert unit.state is not None
        state = unit.state.save()
        unit.state.restore(state)
        unit.state.forget(state)
    except UnitError as error:
        return str(error)
    finally:
        unit.close()
    return "nothing"
