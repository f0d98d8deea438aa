"""Faults that are done to the product, and the score: how many of each group it stands."""

from __future__ import annotations

import importlib
import pkgutil
import shutil
import tempfile
import time
import traceback
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from random import Random

Check = Callable[[Path, Random], None]
"""Does one fault in an empty folder, at times and places that come from the generator; fails as a test does."""

CATALOGUE: list[Fault] = []
"""Every fault that is known, in the order in which they are done."""
_LONGEST = 1500
"""[characters] What is kept of the reason why a fault was not stood."""


@dataclass(frozen=True)
class Fault:
    """One fault, and the check that the product stands it."""

    group: str
    name: str
    check: Check
    short: bool
    """Whether it takes so little time that CI does it."""


@dataclass(frozen=True)
class Outcome:
    """What became of one fault."""

    fault: Fault
    reason: str
    """Why it was not stood; empty where it was."""
    took: float
    """[s] Wall time."""


def fault(group: str, name: str | None = None, *, short: bool = True) -> Callable[[Check], Check]:
    """Put a check among the known faults.

    Args:
        group: The group that it counts for.
        name: What is done, in a few words; the name of the function, if not given.
        short: Whether it takes so little time that CI does it.
    """

    def put(check: Check) -> Check:
        CATALOGUE.append(Fault(group, name or check.__name__.replace("_", " "), check, short))
        return check

    return put


def known_faults() -> list[Fault]:
    """All faults, of all modules of this folder."""
    package = Path(__file__).parent
    for module in sorted(m.name for m in pkgutil.iter_modules([str(package)])):
        if not module.startswith(("test_", "__")):
            importlib.import_module(f"tests.faults.{module}")
    return CATALOGUE


def outcome(one: Fault, seed: int) -> Outcome:
    """Do one fault in a new folder, with times and places that follow from the seed and its name alone."""
    folder, began = Path(tempfile.mkdtemp(prefix="fault_")).resolve(), time.monotonic()
    reason = ""
    try:
        one.check(folder, Random(f"{seed} {one.group} {one.name}"))  # noqa: S311 - it shall be repeatable
    except Exception as error:  # noqa: BLE001 - whatever it is, the fault was not stood
        reason = " ".join(traceback.format_exception_only(error)).strip()[-_LONGEST:] or type(error).__name__
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    return Outcome(one, reason, time.monotonic() - began)


def table(outcomes: Iterable[Outcome]) -> str:
    """The score of each group, and the faults that were not stood with the reasons."""
    groups: dict[str, list[Outcome]] = {}
    for one in outcomes:
        groups.setdefault(one.fault.group, []).append(one)
    width = max(map(len, groups), default=0)
    lines = [f"{'group':{width}}  stood"]
    lines += [f"{g:{width}}  {sum(not o.reason for o in own)} of {len(own)}" for g, own in groups.items()]
    failed = [o for own in groups.values() for o in own if o.reason]
    return "\n".join([*lines, *(f"NOT STOOD {o.fault.group}: {o.fault.name}: {o.reason}" for o in failed)])
