"""The C compiler: found once and called for each file; its errors are passed on."""

from __future__ import annotations

import os
import shlex
import shutil
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Final

from components.interfaces.problem import refuse

FLAGS: Final = ("-O1", "-finline-small-functions", "-std=c99", "-fPIC", "-fvisibility=hidden", "-ffp-contract=off")
"""The flags that the binary depends on.

Without contraction of multiplication and addition, the numbers are the same wherever the code is compiled. Generated
code calls its own minimum, maximum and square in every other line: inlined, it takes a quarter less time. With that,
-O2 takes half as long again to compile as -O1, and the result is only a twentieth faster.
"""

_LINES_SHOWN: Final = 12
"""The number of lines of the compiler's output in a message."""


class BuildError(RuntimeError):
    """The C compiler failed on generated code, or on the runtime; the message has its first lines."""


@dataclass(frozen=True)
class Compiler:
    """A C compiler and what identifies it."""

    command: tuple[str, ...]
    identity: str
    """The first line of what it prints about its version."""

    def compile(self, source: Path, include: Path, flags: Sequence[str] | None = None) -> Path:
        """Compile one C file to an object file beside it.

        The compiler runs in the folder of the file, so that the object file contains no path of this machine.

        Args:
            source: The C file.
            include: The folder with the headers.
            flags: The flags that the binary depends on; `FLAGS` if not given.

        Raises:
            BuildError: The compiler fails.
        """
        target = source.with_suffix(".o")
        chosen = FLAGS if flags is None else flags
        self._run([*chosen, f"-I{include}", "-c", source.name, "-o", target.name], source.parent)
        return target

    def link(self, objects: Sequence[Path], target: Path) -> None:
        """Link object files to a shared library that needs no other libraries than libc and libm.

        Args:
            objects: The object files.
            target: The shared library to write.

        Raises:
            BuildError: The linker fails.
        """
        complete = [] if sys.platform == "darwin" else ["-Wl,--no-undefined"]
        self._run(["-shared", *map(str, objects), "-o", str(target), *complete, "-lm"], target.parent)

    def _run(self, arguments: Sequence[str], folder: Path) -> None:
        command = [*self.command, *arguments]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)  # noqa: S603
        if done.returncode != 0:
            output = "\n".join(done.stderr.splitlines()[:_LINES_SHOWN])
            message = f"{self.command[0]} failed ({done.returncode}) on {shlex.join(command)}:\n{output}"
            raise BuildError(message)


def find_compiler() -> Compiler | None:
    """The compiler that the variable CC names, else the first of cc, gcc and clang; None where there is none."""
    return _find(os.environ.get("CC", ""), os.environ.get("PATH", ""))


def required_compiler(instead: str = "") -> Compiler:
    """The compiler that `find_compiler` gives.

    Args:
        instead: What to do without one, for the message.

    Raises:
        RequestError: There is none.
    """
    compiler = find_compiler()
    if compiler is None:
        named = os.environ.get("CC", "")
        found = f"CC={named}, which cannot be run" if named else "no C compiler"
        remedy = f"Install gcc or clang (Debian: apt-get install gcc){instead and f', or {instead}'}."
        raise refuse("building FMUs", found, "cc, gcc or clang on the PATH, or CC naming one", remedy)
    return compiler


@lru_cache(maxsize=8)
def _find(named: str, path: str) -> Compiler | None:
    for candidate in [shlex.split(named)] if named else [["cc"], ["gcc"], ["clang"]]:
        program = shutil.which(candidate[0], path=path)
        if program is None:
            continue
        version = subprocess.run([program, "--version"], capture_output=True, text=True, check=False)  # noqa: S603
        if version.returncode == 0 and version.stdout:
            return Compiler((program, *candidate[1:]), version.stdout.splitlines()[0])
    return None
