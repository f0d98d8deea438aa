"""The contents of files that people name: read within limits, and refused in words where that is not possible."""

from __future__ import annotations

import os
import stat
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

from components.interfaces.problem import refuse
from fmus.toolchain.door import reading

LARGEST_TEXT: Final = 64 * 2**20
"""[byte] The longest text that a person or a run writes."""
_AT_ONCE: Final = 2**20


def read_bytes(path: Path, where: str, valid: str, largest: int) -> bytes:
    """The content of a file or of a pipe.

    Args:
        path: The file.
        where: The file, as messages name it.
        valid: What it should be, as messages say it.
        largest: The size [byte] beyond which nothing is read.

    Raises:
        RequestError: It cannot be read, or is larger.
    """
    if _is(path, stat.S_ISCHR, stat.S_ISBLK):
        raise refuse(where, "a device", valid)
    try:
        with path.open("rb") as file:
            content = bytearray()
            while len(content) <= largest and (part := file.read(_AT_ONCE)):
                content += part
    except FileNotFoundError as error:
        raise refuse(where, "no such file", valid) from error
    except (OSError, ValueError) as error:  # the name has a NUL, or is none in the encoding of the system
        reason = getattr(error, "strerror", None) or error
        raise refuse(where, f"a file that cannot be read ({reason})", valid) from error
    if len(content) > largest:
        raise refuse(where, f"a file of more than {largest / 2**20:g} MiB", valid)
    return bytes(content)


def read_text(path: Path, where: str, valid: str, *, only_files: bool = False) -> str:
    """The content of a file as text.

    Args:
        path: The file.
        where: The file, as messages name it.
        valid: What it should be, as messages say it.
        only_files: Whether pipes are refused, too: another file has named it, and nothing may ever come.

    Raises:
        RequestError: It cannot be read, is too long, or is no text in UTF-8, in which case the message has the line.
    """
    if only_files and _is(path, stat.S_ISFIFO, stat.S_ISSOCK):
        raise refuse(where, "a pipe", valid)
    content = read_bytes(path, where, valid, LARGEST_TEXT)
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise refuse(f"{where}, line {line}", "a file that is no text: bytes that are no UTF-8", valid) from error


def read_json(path: Path, where: str, valid: str) -> Any:
    """The content of a JSON file that this program has written, and something may have damaged.

    Raises:
        RequestError: It cannot be read, or is no JSON.
    """
    import json  # noqa: PLC0415 - few commands read any

    text = read_text(path, where, valid, only_files=True)
    with reading(where, valid):  # brackets inside each other without end, numbers of thousands of digits
        try:
            return json.loads(text)
        except json.JSONDecodeError as error:
            raise refuse(f"{where}, line {error.lineno}", f"text that is no JSON ({error.msg})", valid) from error


def _is(path: Path, *kinds: Callable[[int], bool]) -> bool:
    """Whether something that is no plain file is at a path."""
    try:
        mode = path.stat().st_mode
    except (OSError, ValueError):
        return False  # reading tells why
    return any(is_so(mode) for is_so in kinds)


def is_file(path: Path) -> bool:
    """Whether there is a file at a path, which may be none at all: too long, or with a NUL in it."""
    return os.path.isfile(path)  # noqa: PTH113 - that of pathlib raises an exception


def is_folder(path: Path) -> bool:
    """Whether there is a folder at a path, which may be none at all."""
    return os.path.isdir(path)  # noqa: PTH112 - that of pathlib raises an exception
