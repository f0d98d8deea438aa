"""Libraries that crash, hang or take all memory on damaged files read these in a child process, with limits of both.

The parent calls `in_plain_form` with a module that calls `answer`. The content goes through a file, because it may be
large, in a form that is read without a parser.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Generator
from contextlib import contextmanager
from pathlib import Path
from typing import TypeAlias

from components.interfaces.problem import refuse
from fmus.toolchain.child_death import ChildDiedError, ChildSilentError, death_in_words
from fmus.toolchain.child_process import ChildProcess, ParentProcess
from fmus.toolchain.door import exception_in_words
from fmus.toolchain.limits import LIBRARY_MEMORY, LIBRARY_TIME
from fmus.toolchain.memory_limit import memory_limit, without_core_files

_Child: TypeAlias = ChildProcess[str]
_kept: list[dict[str, _Child]] = []
"""The processes that are asked again, by their module, in a block of `readers_kept`; empty outside."""


@contextmanager
def readers_kept() -> Generator[None]:
    """In the block, a process that has read a file reads the next ones, too; else each file has one of its own."""
    if _kept:  # a block in a block
        yield
        return
    _kept.append({})
    try:
        yield
    finally:
        for child in _kept.pop().values():
            _end(child)


def in_plain_form(  # noqa: PLR0913 - the four parts of a refusal
    module: str, source: Path, target: Path, where: str, valid: str, remedy: str = ""
) -> None:
    """Let a child process read a file, and write what it has read in a plain form.

    Args:
        module: The module that the child runs.
        source: The file.
        target: The file that is written.
        where: The first file, as messages name it.
        valid: What it should be, as messages say it.
        remedy: What to do about one that cannot be read.

    Raises:
        RequestError: It cannot be read, or reading it ends the process, or takes too long.
    """
    kept = _kept[-1].pop(module, None) if _kept else None
    reason, lives = _asked(module, kept, source, target)
    if kept is not None and not lives:  # what former files have done to a process must not concern this one
        reason, _ = _asked(module, None, source, target)
    if reason:
        raise refuse(where, reason, valid, remedy)


def _asked(module: str, child: _Child | None, source: Path, target: Path) -> tuple[str, bool]:
    """Why a file cannot be read, in words, empty where it was; and whether the process that was asked lives."""
    with open(os.devnull, "wb") as nothing:  # noqa: PTH123 - a library may print its panic
        child = child or ChildProcess(module, str, errors=nothing)
    lives = False
    try:
        reason = child.ask((str(source), str(target)), LIBRARY_TIME)
        lives = True
    except ChildDiedError as error:
        reason = f"a file that ends the process that reads it ({death_in_words(error.death)})"
    except ChildSilentError as error:
        reason = f"a file that takes more than {error.within:g} s to read"
    if lives and _kept:
        _kept[-1][module] = child
    else:
        _end(child)
    return reason, lives


def _end(child: _Child) -> None:
    child.kill()
    child.close()


def answer(convert: Callable[[str, str], None]) -> None:
    """In the child: read files, within the limit of memory, until the parent asks no more.

    Args:
        convert: Reads one file, and writes another.
    """
    parent = ParentProcess()
    parent.end_with_parent()
    without_core_files()
    memory_limit(LIBRARY_MEMORY)()
    while True:
        try:
            source, target = parent.request()
            parent.answer(_reason(convert, source, target))
        except EOFError:
            os._exit(0)  # what a library has read from damaged data may not be fit to be released


def _reason(convert: Callable[[str, str], None], source: str, target: str) -> str:
    try:
        convert(source, target)
    except BaseException as error:  # noqa: BLE001 - the parent tells it, also the panic of a library in Rust
        return f"a file that cannot be read ({exception_in_words(error)})"
    return ""
