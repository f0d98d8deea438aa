"""A file that this process and a child map as memory; the child cannot shorten it under this process's feet.

A process that reads mapped memory behind the end of its file is ended by a signal. On Linux the file is one without a
name, whose size is fixed for good; elsewhere it is an ordinary one.
"""

from __future__ import annotations

import os
import sys
from contextlib import suppress
from pathlib import Path
from typing import Final

_DESCRIPTORS: Final = Path("/proc/self/fd")


class SharedFile:
    """An empty file.

    Args:
        folder: The folder in which an ordinary file stands.
        name: Its name.
    """

    def __init__(self, folder: Path, name: str) -> None:
        self.descriptors: tuple[int, ...] = ()
        """What a child has to inherit."""
        self.path = folder / name
        """The file, the same for a child that has inherited the descriptors."""
        if sys.platform == "linux":
            descriptor = os.memfd_create(name, os.MFD_ALLOW_SEALING | os.MFD_CLOEXEC)
            self.descriptors, self.path = (descriptor,), _DESCRIPTORS / str(descriptor)

    def fix(self) -> None:
        """Keep the size as it is, for everybody."""
        if sys.platform == "linux":
            import fcntl  # noqa: PLC0415 - only POSIX has it

            seals = fcntl.F_SEAL_SHRINK | fcntl.F_SEAL_GROW | fcntl.F_SEAL_SEAL
            fcntl.fcntl(self.descriptors[0], fcntl.F_ADD_SEALS, seals)

    def close(self) -> None:
        """Let go of the file, which remains mapped."""
        for descriptor in self.descriptors:
            with suppress(OSError):
                os.close(descriptor)
        self.descriptors = ()


def let_go(path: Path) -> None:
    """In a child that has mapped a file: close what it has inherited, so that no write to a descriptor reaches it."""
    if path.parent == _DESCRIPTORS:
        os.close(int(path.name))
