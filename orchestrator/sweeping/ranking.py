"""Which variants are the worst."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import Final

from components.interfaces.problem import refuse
from orchestrator.sweeping.journal import VariantResult

KEEP_OPTION: Final = "--keep"
_GAPS: Final = ("gap_obstacle", "gap_edge")
"""[m] The metrics that say how near it was."""
_WORST: Final = re.compile(r"worst:([0-9]{1,6})")


def badness(result: VariantResult) -> tuple[bool, int, float, int]:
    """A key by which the worst variants come first.

    One that ended in a fault is worse than any other, then counts how many verdicts do not hold, then the smallest gap
    to an obstacle or to the edge of the road.

    Args:
        result: The result of a variant.
    """
    failed = sum(not holds for holds in result.verdicts.values())
    gaps = [result.metrics[name] for name in _GAPS if name in result.metrics]
    return not result.fault, -failed, min(gaps, default=float("inf")), result.variant


def in_words(result: VariantResult) -> str:
    """What is bad about a variant, in a few words."""
    failed = ", ".join(f"{name.replace('_', ' ')}: no" for name, holds in result.verdicts.items() if not holds)
    gaps = ", ".join(f"{name} {result.metrics[name]:.3g} m" for name in _GAPS if name in result.metrics)
    return "; ".join(part for part in (result.fault, failed, gaps) if part) or "nothing to tell"


def worst_first(results: Mapping[int, VariantResult]) -> list[int]:
    """The numbers of the variants, the worst first; their results are looked at one at a time."""
    return sorted(results, key=lambda variant: badness(results[variant]))


def kept(wanted: Iterable[str], results: Mapping[int, VariantResult], count: int) -> list[int]:
    """The variants whose runs are kept, the worst first.

    Args:
        wanted: `worst:10`, or numbers of variants.
        results: All results.
        count: The number of variants.

    Raises:
        RequestError: A text has another form, or there is no such variant.
    """
    ranked = worst_first(results)
    numbers: dict[int, None] = {}
    for text in wanted:
        for part in (one.strip() for one in text.split(",")):
            if match := _WORST.fullmatch(part):
                numbers |= dict.fromkeys(ranked[: int(match[1])])
            elif part.isdecimal() and int(part) < count:
                numbers[int(part)] = None
            else:
                raise refuse(
                    f"{KEEP_OPTION} {text}", f"`{part}`", f"worst:N, or numbers of variants from 0 to {count - 1}"
                )
    return list(numbers)
