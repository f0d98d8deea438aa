"""Libraries that crash, hang or take all memory on damaged files are asked in a child process, with limits of both.

The parent calls `ask_library` with a module that calls `answer_once`.
"""

from __future__ import annotations

import gc
import os
from collections.abc import Callable
from typing import Any, Final

from components.interfaces.problem import refuse
from fmus.toolchain.child_process import (
    ChildDiedError,
    ChildProcess,
    ChildSilentError,
    ParentProcess,
    death_in_words,
)
from fmus.toolchain.door import exception_in_words

LIBRARY_TIME: Final = 120.0
"""[s] The time in which a library has to read a file."""
LIBRARY_MEMORY: Final = 8 * 2**30
"""[byte] The memory that it may take for that."""


def ask_library(  # noqa: PLR0913 - the four parts of a refusal
    module: str, request: object, where: str, valid: str, remedy: str = "", within: float = LIBRARY_TIME
) -> Any:
    """Let a child process read a file.

    Args:
        module: The module that the child runs.
        request: What it is asked.
        where: The file, as messages name it.
        valid: What it should be, as messages say it.
        remedy: What to do about one that cannot be read.
        within: The time [s] that it may take.

    Returns:
        Its answer.

    Raises:
        RequestError: It raised an exception, died, or took too long.
    """
    with open(os.devnull, "wb") as nothing:  # noqa: PTH123 - a library may print its panic
        child = ChildProcess(module, errors=nothing)
        try:
            answer = child.ask(request, within)
        except ChildDiedError as error:
            found = f"a file that ends the process that reads it ({death_in_words(error.death)})"
            raise refuse(where, found, valid, remedy) from error
        except ChildSilentError as error:
            raise refuse(where, f"a file that takes more than {within:g} s to read", valid, remedy) from error
        finally:
            child.kill()
            child.close()
    if "error" in answer:
        raise refuse(where, f"a file that cannot be read ({answer['error']})", valid, remedy)
    return answer["value"]


def answer_once(read: Callable[[Any], Any]) -> None:
    """In the child: answer one request, within the limit of memory.

    Args:
        read: Gives the answer to a request: values, lists and dictionaries of such, and bytes.
    """
    parent = ParentProcess()
    parent.end_with_parent()
    try:
        request = parent.request()
        _limit_memory()
        parent.answer(_answer(read, request))
    except EOFError:  # nobody waits for it any more
        return
    os._exit(0)  # a library that has read damaged data may crash when its objects go


def _answer(read: Callable[[Any], Any], request: Any) -> dict[str, Any]:
    gc.disable()
    try:
        return {"value": read(request)}
    except Exception as error:  # noqa: BLE001 - the parent tells it
        return {"error": exception_in_words(error)}
    except BaseException as error:  # noqa: BLE001 - so do libraries in Rust raise a panic
        return {"error": f"{type(error).__name__}: {error}"[:200]}


def _limit_memory() -> None:
    try:
        import resource  # noqa: PLC0415 - only POSIX has it
    except ImportError:
        return
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    _, highest = resource.getrlimit(resource.RLIMIT_AS)
    wanted = LIBRARY_MEMORY if highest == resource.RLIM_INFINITY else min(LIBRARY_MEMORY, highest)
    resource.setrlimit(resource.RLIMIT_AS, (wanted, highest))
