"""The door that every file of another maker comes in by: whatever a parser or a library throws becomes a refusal.

What is known to go wrong has a message of its own, where it is read. The door is for the rest: it names the file, and
the exception with its text, so that a mistake of ours is not hidden behind words.
"""

from __future__ import annotations

from collections.abc import Generator
from contextlib import contextmanager
from typing import Final

from components.interfaces.problem import RequestError, refuse

_LONGEST: Final = 200
"""The most characters of the text of an exception that a message shows."""
_WORDS: Final[tuple[tuple[type[Exception], str], ...]] = (
    (RecursionError, "something that is nested too deeply"),
    (MemoryError, "something that takes more memory than there is"),
    (UnicodeError, "bytes that are no text in its encoding"),
    (OSError, "something that the system refuses"),
)
"""What an exception means, in words; the first that fits."""


@contextmanager
def reading(where: str, valid: str, remedy: str = "", what: str = "something that cannot be read") -> Generator[None]:
    """Turn whatever is raised while a file is read into a refusal; refusals pass as they are.

    Args:
        where: The file, and the line where it is known.
        valid: What would be valid.
        remedy: What to do.
        what: What is found, where the kind of the exception says nothing better.

    Raises:
        RequestError: Anything was raised in the block.
    """
    try:
        yield
    except RequestError:
        raise
    except Exception as error:
        found = next((words for kind, words in _WORDS if isinstance(error, kind)), what)
        raise refuse(where, f"{found} ({exception_in_words(error)})", valid, remedy) from error


def exception_in_words(error: BaseException) -> str:
    """The kind of an exception and its text, in one line of bounded length."""
    text = " ".join(str(error).split())
    text = text if len(text) <= _LONGEST else f"{text[:_LONGEST]}..."
    return f"{type(error).__name__}: {text}" if text else type(error).__name__
