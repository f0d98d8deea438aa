"""Messages about a wrong request, in four parts: where, what was found, what would be valid, what to do."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Final, TypeVar

_T = TypeVar("_T")
_D = TypeVar("_D")
MOST_PROBLEMS: Final = 1000
"""The most problems that are looked for: nobody reads more of them, and a file may have any number."""
_LISTED: Final = 100
"""The most names that a message lists."""
_COMPARED: Final = 1000
"""The most names that a misspelled name is compared with."""


@dataclass(frozen=True)
class Problem:
    """One thing that is wrong, in the four parts that a person needs to correct it.

    Args:
        where: The place of the problem, such as the path of a parameter.
        found: What was found there.
        valid: What would be valid there.
        remedy: A sentence on what to do, if there is one to give.
    """

    where: str
    found: str
    valid: str
    remedy: str = ""

    def __str__(self) -> str:
        where = self.where if self.where.strip() else f'"{self.where}"'  # a file may give a thing an empty name
        text = f"{where}: found {self.found}; valid: {self.valid}"
        return f"{text}. {self.remedy}" if self.remedy else text


class RequestError(ValueError):
    """A request that cannot be carried out.

    Args:
        problems: All problems of the request; the message has a line for each.
    """

    def __init__(self, problems: Iterable[Problem]) -> None:
        self.problems = tuple(problems)
        super().__init__("\n".join(map(str, self.problems)))

    def __reduce__(self) -> tuple[type[RequestError], tuple[tuple[Problem, ...]]]:
        """An error that comes from another process has its problems as well."""
        return type(self), (self.problems,)


def refuse(where: str, found: str, valid: str, remedy: str = "") -> RequestError:
    """The error for a single problem, with the four parts that `Problem` has."""
    return RequestError([Problem(where, found, valid, remedy)])


def raise_if_any(problems: Iterable[Problem]) -> None:
    """Report all problems at once; do nothing when there are none.

    Raises:
        RequestError: There are problems; the error has all of them, or `MOST_PROBLEMS` and that there are more.
    """
    remaining = iter(problems)
    if gathered := tuple(islice(remaining, MOST_PROBLEMS)):
        more = next(remaining, None)
        raise RequestError(gathered if more is None else (*gathered, OTHER_PROBLEMS))


class Gathered:
    """The problems of what does not depend on each other, so that a person learns of all of them at once."""

    def __init__(self) -> None:
        self.problems: list[Problem] = []

    def attempt(self, action: Callable[[], _T], otherwise: _D) -> _T | _D:
        """The result of `action`; `otherwise` where it raises `RequestError`, whose problems are added."""
        try:
            return action()
        except RequestError as error:
            self.problems += error.problems
            return otherwise


OTHER_PROBLEMS: Final = Problem(
    "other problems", f"more than these {MOST_PROBLEMS}", "none", "Correct these first: the others are not listed."
)
"""What stands in the place of more problems than are looked for."""


def choices(names: Iterable[str]) -> str:
    """The valid names as one readable phrase; of very many the first."""
    return listed(sorted(names), _LISTED, "others") or "nothing"


def listed(names: Sequence[str], most: int = 3, rest: str = "more") -> str:
    """Names in their order as one phrase, of which only the first are spelled out; `rest` is a word for the others."""
    others = f" and {len(names) - most} {rest}" if len(names) > most else ""
    return ", ".join(names[:most]) + others


def did_you_mean(name: str, names: Iterable[str]) -> str:
    """A remedy that names the closest valid name, or an empty text."""
    close = difflib.get_close_matches(name, list(islice(names, _COMPARED)), n=1, cutoff=0.6)
    return f"Did you mean `{close[0]}`?" if close else ""
