"""Names of files of other makers that become paths on this machine: checked here, and nowhere else.

Entries of archives, sources and include directories of an FMU, libraries that it is linked with, its model identifier,
and what the parts of an SSP refer to: all of them are relative, stay in their folder, and fit a file system.
"""

from __future__ import annotations

import os
import re
from typing import Final

from fmus.toolchain.limits import DEEPEST_PATH, LONGEST_FILE_NAME, LONGEST_PATH

_DEVICES: Final = re.compile(r"(con|prn|aux|nul|com\d|lpt\d)(\..*)?", re.IGNORECASE)
"""Names that Windows reserves for devices."""
_UNPRINTABLE: Final = re.compile(r"[\x00-\x1f\x7f]")
_SHOWN: Final = 80
"""The characters of a name that a message shows."""
LEAVES: Final = "would leave the folder"
"""What is wrong with a path that leads out of its folder."""
FILE_NAME: Final = "a name without folders, of letters, digits and other printable characters"
"""What `is_file_name` takes, as the part of a message."""


def plain_path(name: str) -> str:
    """A relative path in one spelling: with slashes, and without parts that lead nowhere."""
    parts = [part for part in name.replace("\\", "/").split("/") if part not in {"", "."}]
    return "/".join(parts)


def path_problem(name: str, *, windows: bool = os.name == "nt") -> str:
    """Why a name must not become a path inside a folder; empty where it may.

    Args:
        name: The name, as the file has it.
        windows: Whether Windows has to take it.
    """
    slashed = name.replace("\\", "/")
    parts = plain_path(name).split("/")
    rules = (
        (not parts[0], "is empty"),
        (bool(_UNPRINTABLE.search(name)), "has control characters"),
        (_leaves(slashed), LEAVES),
        (len(name) > LONGEST_PATH, f"has more than {LONGEST_PATH} characters"),
        (len(parts) > DEEPEST_PATH, f"has more than {DEEPEST_PATH} folders inside each other"),
        (not _is_encodable(name), "cannot be written in UTF-8"),
        (_longest(parts) > LONGEST_FILE_NAME, f"has a part of more than {LONGEST_FILE_NAME} bytes"),
        (windows and any(_DEVICES.fullmatch(part) for part in parts), "names a device of Windows"),
    )
    return next((reason for is_so, reason in rules if is_so), "")


def is_file_name(name: str, longest: int = LONGEST_FILE_NAME - 55) -> bool:
    """Whether a name can be that of a file in any folder, with a suffix behind it: it has no folders in it."""
    return not path_problem(name) and "/" not in name and "\\" not in name and ":" not in name and len(name) <= longest


def shown_name(name: str) -> str:
    """A name of another maker for a message: of a very long one only the beginning."""
    return name if len(name) <= _SHOWN else f"{name[:_SHOWN]}... ({len(name)} characters)"


def _leaves(slashed: str) -> bool:
    """Whether a path is absolute, has a drive, or leads out of its folder; no link can do that: links are refused."""
    if slashed.startswith("/") or slashed[1:2] == ":":
        return True
    depth = 0
    for part in slashed.split("/"):
        depth += -1 if part == ".." else part not in {"", "."}
        if depth < 0:
            return True
    return False


def _longest(parts: list[str]) -> int:
    return max(len(part.encode("utf-8", "surrogateescape")) for part in parts) if _is_encodable("".join(parts)) else 0


def _is_encodable(name: str) -> bool:
    try:
        name.encode()
    except UnicodeEncodeError:
        return False
    return True
