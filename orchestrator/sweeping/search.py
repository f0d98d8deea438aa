"""The search for failures: variants that make a metric cross a bound, or miss a verdict, the worst of each kind.

SciPy's differential evolution looks for the worst variant. What it has found is then kept away from, and it looks for
another one, until the budget is used or nothing new is found.
"""

from __future__ import annotations

import re
import time
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np

from components.interfaces.maths import Array
from components.interfaces.problem import choices, did_you_mean, refuse
from orchestrator.sweeping.journal import VariantResult
from orchestrator.sweeping.plan import PlannedSweep, Variant

FIND: Final = "--find"
BUDGET: Final = "--budget"
_FORM: Final = "METRIC < NUMBER, METRIC > NUMBER, not VERDICT, or fault"
_COMPARISON: Final = re.compile(
    r"\s*(?P<name>\w+)\s*(?P<sign><=?|>=?)\s*(?P<bound>[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*"
)
_VERDICT: Final = re.compile(r"\s*not\s+(?P<name>\w+(?:[ _]\w+)*)\s*")
_TIME: Final = re.compile(r"(?P<number>\d+\.?\d*)\s*(?P<unit>s|min|h)?")
_SECONDS: Final = {"s": 1.0, "min": 60.0, "h": 3600.0}
_APART: Final = 0.15
"""Share of the diagonal of what varies by which two failures are distinct."""
_AT_ONCE: Final = 12
"""Variants per dimension in each generation."""
_LEAST: Final = 24
_GENERATIONS: Final = 12
"""Generations of one search, after which another one begins elsewhere."""
_MOST_FOUND: Final = 8
"""Distinct failures that are looked for."""


@dataclass(frozen=True)
class Aim:
    """What counts as a failure."""

    text: str
    name: str
    sign: str
    """`<`, `<=`, `>`, `>=`, `not` or `fault`."""
    bound: float = 0.0

    def margin(self, result: VariantResult) -> float:
        """How far a result is from failing; 0 or less where it fails, infinite where it does not say.

        Args:
            result: The result of a variant.
        """
        if self.sign == "fault":
            return -1.0 if result.fault else 1.0
        if self.sign == "not":
            return float("inf") if self.name not in result.verdicts else 1.0 if result.verdicts[self.name] else -1.0
        value = result.metrics.get(self.name, float("nan"))
        if not np.isfinite(value):
            return float("inf")
        margin = value - self.bound if self.sign[0] == "<" else self.bound - value
        # a bound that is reached is crossed only by `<=` and `>=`
        return margin if margin or self.sign.endswith("=") else 5e-324

    def check(self, result: VariantResult) -> None:
        """Raises `RequestError` where a variant that ran says nothing of it."""
        known: Collection[str] = result.verdicts if self.sign == "not" else result.metrics
        if not result.fault and self.sign != "fault" and self.name not in known:
            kind = "verdict" if self.sign == "not" else "metric"
            remedy = did_you_mean(self.name, known)
            raise refuse(f"{FIND} {self.text}", f"no {kind} `{self.name}`", choices(known), remedy)


def read_aim(text: str) -> Aim:
    """Read what is looked for, such as `gap_edge < 0`. Raises `RequestError` where it has another form."""
    if text.strip() == "fault":
        return Aim(text, "", "fault")
    if match := _VERDICT.fullmatch(text):
        return Aim(text, match["name"].replace(" ", "_"), "not")
    match = _COMPARISON.fullmatch(text)
    if match is None:
        raise refuse(f"{FIND} {text}", "text of another form", _FORM, "Try --find 'gap_edge < 0'.")
    return Aim(text, match["name"], match["sign"], float(match["bound"]))


@dataclass(frozen=True)
class Budget:
    """How long, or by how many variants, failures are looked for."""

    seconds: float = float("inf")
    variants: float = float("inf")


def read_budget(text: str) -> Budget:
    """Read `60s`, `10min`, `1h`, or a number of variants. Raises `RequestError` where it has another form."""
    match = _TIME.fullmatch(text.strip())
    if match is None or float(match["number"]) <= 0 or (match["unit"] is None and "." in match["number"]):
        raise refuse(f"{BUDGET} {text}", "text of another form", "60s, 10min, 1h, or a number of variants")
    if match["unit"] is None:
        return Budget(variants=float(match["number"]))
    return Budget(seconds=float(match["number"]) * _SECONDS[match["unit"]])


class _SpentError(Exception):
    """The budget is used."""


@dataclass
class FailureSearch:
    """A search in the variants of a plan, which it adds to the plan as it looks at them.

    Args:
        planned: The plan, without variants.
        run: Runs variants, and gives each result when it has come.
    """

    planned: PlannedSweep
    run: Callable[[Iterator[Variant]], Iterator[VariantResult]]
    clock: Callable[[], float] = time.monotonic
    places: list[Array] = field(default_factory=list[Array])
    """Where each variant is, as shares of what varies, `(d,)`."""
    margins: list[float] = field(default_factory=list[float])

    def __post_init__(self) -> None:
        self._aim = read_aim(self.planned.request.find or "")
        self._budget = read_budget(self.planned.request.budget)
        self._began = self.clock()
        self._avoided: list[Array] = []
        self._known: dict[tuple[str, ...], int] = {}
        """The variants by their values."""

    def go(self) -> None:
        """Look for failures until the budget is used, or nothing new is found.

        Raises:
            RequestError: No variant has such a metric or verdict.
        """
        dimensions = len(self.planned.variations)
        try:
            self._margins(np.full((dimensions, 1), 0.5))
            for attempt in range(_MOST_FOUND + 1):
                before = len(self.distinct())
                self._one(attempt)
                self._avoided = [self.places[number] for number in self.distinct()]
                if len(self._avoided) == before:
                    return
        except _SpentError:
            return

    def distinct(self) -> list[int]:
        """The worst variant of each kind of failure, the worst first: those that are far from worse ones."""
        found: list[int] = []
        for number in sorted(range(len(self.margins)), key=self.margins.__getitem__):
            if self.margins[number] > 0 or len(found) == _MOST_FOUND:
                break
            if all(self._apart(self.places[number], self.places[other]) >= _APART for other in found):
                found.append(number)
        return found

    def mildest(self) -> int | None:
        """The failing variant that is nearest to the middle of what varies."""
        failing = [number for number, margin in enumerate(self.margins) if margin <= 0]
        middle: Array = np.full(len(self.planned.variations), 0.5)
        return min(failing, key=lambda number: self._apart(self.places[number], middle), default=None)

    def _apart(self, a: Array, b: Array) -> float:
        return float(np.linalg.norm(a - b) / np.sqrt(len(a)))

    def _one(self, attempt: int) -> None:
        """One search for the worst variant that is not near those that were found."""
        from scipy.optimize import Bounds, differential_evolution  # noqa: PLC0415 - slow to import

        dimensions = len(self.planned.variations)
        size = max(_LEAST, _AT_ONCE * dimensions) // dimensions
        objective: Any = self._objective  # of many places at once, which the types of SciPy do not know
        differential_evolution(
            objective,
            Bounds(np.zeros(dimensions), np.ones(dimensions)),
            popsize=size,
            maxiter=_GENERATIONS,
            init="sobol" if attempt == 0 else "latinhypercube",
            updating="deferred",
            vectorized=True,
            polish=False,
            tol=1e-3,
            rng=np.random.default_rng([self.planned.request.seed, attempt]),
        )

    def _objective(self, shares: Array) -> Array:
        """The margins at some places `(d, n)`; near what was found already it is as if nothing failed."""
        margins = self._margins(shares)
        largest = max((abs(m) for m in self.margins if np.isfinite(m)), default=1.0)
        for i, place in enumerate(shares.T):
            near = min((self._apart(place, other) for other in self._avoided), default=1.0)
            if near < _APART:
                margins[i] = largest * (2 - near / _APART)
        return np.where(np.isfinite(margins), margins, 2 * largest)

    def _margins(self, shares: Array) -> Array:
        """Run the variants at some places `(d, n)`, and give their margins `(n,)`."""
        shares = np.clip(shares, 0.0, np.nextafter(1.0, 0.0))
        columns = [v.at(row) for v, row in zip(self.planned.variations, shares, strict=True)]
        wanted = [*zip(*columns, strict=True)]
        new = {values: i for i, values in reversed([*enumerate(wanted)]) if values not in self._known}
        left = self._budget.variants - len(self.places)
        if new and (left < 1 or self.clock() - self._began > self._budget.seconds):
            raise _SpentError
        self._run(dict(sorted(new.items(), key=lambda item: item[1])[: int(min(len(new), left))]), shares)
        if len(new) > left:
            raise _SpentError
        return np.array([self.margins[self._known[values]] for values in wanted])

    def _run(self, new: Mapping[tuple[str, ...], int], shares: Array) -> None:
        """Run variants with values that nobody has seen, each with its column of `shares`."""
        first = len(self.places)
        for number, (values, i) in enumerate(new.items(), first):
            self._known[values] = number
            for variation, value in zip(self.planned.variations, values, strict=True):
                self.planned.columns[variation.path].append(value)
            found = zip(self.planned.variations, shares[:, i].tolist(), strict=True)
            self.places.append(np.array([variation.place(share) for variation, share in found]))
        self.margins += [float("inf")] * len(new)
        for result in self.run(self.planned.variant(number) for number in range(first, len(self.places))):
            if not first:
                self._aim.check(result)
            self.margins[result.variant] = self._aim.margin(result)
