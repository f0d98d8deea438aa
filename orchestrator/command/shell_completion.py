"""What a shell offers behind the command, when somebody presses the key that completes.

`macrostep --install-completion` makes the shell ask the command itself: it starts it with the words that were typed in
the environment, where this file reads them.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Final

_RUNNABLE: Final = (".toml", ".ssp", ".fmu")
"""The files that can be run."""
_RUNS: Final = "runs"
"""The folder that holds run folders, if no other is chosen."""


def words(environment: Mapping[str, str] = os.environ) -> list[str]:
    """The words behind the command that a shell wants completed; none where it is no shell that asks.

    Args:
        environment: The environment of the command; bash tells the words in one variable, other shells in another.
    """
    if "_MACROSTEP_COMPLETE" not in environment:
        return []
    return (environment.get("_TYPER_COMPLETE_ARGS") or environment.get("COMP_WORDS", "")).split()[1:]


def runnable(incomplete: str) -> list[str]:
    """What `macrostep run` takes: scenarios, files, run folders.

    Args:
        incomplete: The word so far.
    """
    from orchestrator.scenario import scenario_file  # noqa: PLC0415 - no other command waits for it

    known = [*_beginning(incomplete, scenario_file.names()), *runs(incomplete)]
    return [*known, *(path for path in _paths(incomplete, _RUNNABLE) if path not in known and path[:-1] not in known)]


def named(incomplete: str) -> list[str]:
    """The scenarios and the blocks.

    Args:
        incomplete: The word so far.
    """
    from components import BLOCKS  # noqa: PLC0415 - no other command waits for it
    from orchestrator.scenario import scenario_file  # noqa: PLC0415

    return _beginning(incomplete, [*scenario_file.names(), *BLOCKS])


def checkable(incomplete: str) -> list[str]:
    """What `macrostep check` takes: scenarios, blocks and files.

    Args:
        incomplete: The word so far.
    """
    return [*named(incomplete), *_paths(incomplete, (*_RUNNABLE, ".mo"))]


def runs(incomplete: str) -> list[str]:
    """The run folders, and the recordings.

    Args:
        incomplete: The word so far; without a folder in it the runs of the working folder are meant as well.
    """
    from orchestrator.results.run_folder import SYSTEM  # noqa: PLC0415 - no other command waits for it

    folders = sorted(path.parent.as_posix() for path in Path(_RUNS).glob(f"*/{SYSTEM}"))
    others = [path for path in _paths(incomplete, (".rrd",)) if path.rstrip("/") not in folders]
    return [*_beginning(incomplete, folders), *others]


def _beginning(incomplete: str, values: Iterable[str]) -> list[str]:
    return [value for value in values if value.startswith(incomplete)]


def _paths(incomplete: str, endings: tuple[str, ...]) -> list[str]:
    """The files of some kinds that begin so, and the folders, in which others may be."""
    before = incomplete[: incomplete.rfind("/") + 1]
    if not Path(before).is_dir():
        return []
    found = sorted(path for path in Path(before).iterdir() if not path.name.startswith("."))
    names = [
        f"{path.name}/" if path.is_dir() else path.name for path in found if path.is_dir() or path.suffix in endings
    ]
    return _beginning(incomplete, [before + name for name in names])
