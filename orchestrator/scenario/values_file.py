"""Files with values, a line for each, as they are given to `--set`: ``fmu.k = 3``; a `#` begins a comment."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Final

from components.interfaces.problem import Problem, raise_if_any
from orchestrator.system.contents import read_text

_MARK: Final = "@"
_COMMENT: Final = re.compile(r"(^|\s)#.*")
_ASSIGNMENT: Final = re.compile(r"(?P<path>[^=]*[^=\s])\s*=\s*(?P<value>.*)")
_VALID: Final = "UNIT.PARAMETER = VALUE"


def expanded(texts: Sequence[str]) -> list[str]:
    """The settings of a person, with those of files in the place of their names.

    Args:
        texts: The values of the option `--set`; `@FILE` stands for the lines of a file.

    Raises:
        RequestError: A file cannot be read, or has lines of another form; all of them.
    """
    return [one for text in texts for one in (_lines(Path(text[1:])) if text.startswith(_MARK) else [text])]


def _lines(path: Path) -> list[str]:
    where = f"--set {_MARK}{path}"
    content = read_text(path, where, f"a file of lines {_VALID}")
    lines = [(i + 1, _COMMENT.sub("", line).strip()) for i, line in enumerate(content.splitlines())]
    raise_if_any(_problems(where, lines))
    return [f"{m['path']}={m['value']}" for _, line in lines if (m := _ASSIGNMENT.fullmatch(line))]


def _problems(where: str, lines: Sequence[tuple[int, str]]) -> Iterator[Problem]:
    for number, line in lines:
        if line and not _ASSIGNMENT.fullmatch(line):
            yield Problem(f"{where}, line {number}", f"`{line}`", _VALID)
