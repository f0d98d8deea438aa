"""What the varied set says: distributions for each controller, and the claims looked at case by case."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, Final

import numpy as np

from orchestrator.reproduction.paper import claims, goals
from orchestrator.reproduction.paper.evidence import Curve, Evidence, Result
from orchestrator.reproduction.paper.experiments import Role
from orchestrator.reproduction.paper.verdict import Case, Verdict, verdict_data
from orchestrator.reproduction.varied import variations
from orchestrator.reproduction.varied.varied_set import Driven, VariedSet

ENOUGH: Final = 0.95
"""Share of the cases in which a claim has to hold to hold on the varied set."""

CLAIMS: Final[Sequence[Callable[[Evidence], Verdict]]] = (
    claims.c1, claims.c2, claims.c3, claims.c4, claims.c5, claims.c6
)  # fmt: skip

SPREAD: Final = ("path_error_rms", "path_error_max", "r_dot_rms", "r_total_variation", "gap_obstacle", "gap_edge")
"""Metrics whose distribution is told."""

_PERCENTILES: Final = (5, 50, 95)


def content(found: VariedSet) -> dict[str, Any]:
    """The varied set as plain data, with everything needed to run any case again."""
    drivers = {d.name: d for d in found.variations.controllers}
    verdicts = decide(found)
    return {
        "count": len(found.driven),
        "seed": found.seed,
        "plant": found.variations.plant,
        "ranges": found.variations.model_dump(mode="json")["ranges"],
        "controllers": [_distribution(name, found) for name in drivers],
        "claims": [verdict_data(v) for v in verdicts],
        "goals": [verdict_data(_all_cases(found, goals.nominal))],
        "unresolved": [driven.case.number for driven in unresolved(found)],
        "cases": [
            {
                "number": driven.case.number,
                "task": driven.case.task,
                "drawn": dict(driven.case.drawn),
                "stop_time": driven.case.stop_time,
                "runs": {
                    name: {
                        "metrics": dict(result.metrics),
                        "fault": driven.faults.get(name),
                        "command": variations.command(driven.case, drivers[name], found.variations.plant),
                    }
                    for name, result in driven.results.items()
                },
            }
            for driven in found.driven
        ],
    }


def decide(found: VariedSet) -> list[Verdict]:
    """C1 to C6 on the varied set: each case of a claim holds where it holds in enough of the variations."""
    return [_all_cases(found, claim) for claim in CLAIMS]


def unresolved(found: VariedSet) -> list[Driven]:
    """The cases in which `mpc_plus` touches something or leaves the road: is there any way through?"""
    return [d for d in found.driven for r in d.results.values() if r.role is Role.PLUS and not is_safe(r)]


def is_safe(result: Result) -> bool:
    """No contact and inside the road to the end."""
    return result.finished and result.metrics["gap_obstacle"] > 0 and result.metrics["gap_edge"] >= 0


def _evidence(driven: Driven, found: VariedSet) -> Evidence:
    curves: dict[str, list[Result]] = {}
    for driver in found.variations.controllers:
        if driver.curve and driver.name in driven.results:
            curves.setdefault(driver.curve, []).append(driven.results[driver.name])
    return Evidence(
        results=tuple(driven.results.values()),
        curves=tuple(
            Curve(name, driven.case.task, found.variations.plant, name, tuple(points))
            for name, points in curves.items()
        ),
    )


def _all_cases(found: VariedSet, claim: Callable[[Evidence], Verdict]) -> Verdict:
    """A claim case by case, gathered by what was compared."""
    said: dict[tuple[tuple[str, str], ...], list[bool | None]] = {}
    looked = [claim(_evidence(driven, found)) for driven in found.driven]
    for verdict in looked:
        for case in verdict.cases:
            said.setdefault(tuple(case.factors.items()), []).append(case.holds)
    cases = tuple(_gathered(dict(factors), values) for factors, values in said.items())
    asked = f"{looked[0].decided_by}; in at least {ENOUGH:.0%} of the variations that can be compared"
    return Verdict(looked[0].claim, looked[0].words, asked, cases)


def _gathered(factors: Mapping[str, str], values: Sequence[bool | None]) -> Case:
    told = [value for value in values if value is not None]
    share = sum(told) / len(told) if told else 0.0
    numbers = {"share": share, "cases": float(len(told)), "cannot be compared": float(len(values) - len(told))}
    return Case(factors, share >= ENOUGH if told else None, numbers, ())


def _distribution(name: str, found: VariedSet) -> dict[str, Any]:
    results = [driven.results[name] for driven in found.driven if name in driven.results]
    driver = next(d for d in found.variations.controllers if d.name == name)
    told: dict[str, Any] = {
        "name": name,
        "label": driver.label,
        "tasks": list(driver.tasks),
        "settings": list(driver.settings),
        "cases": len(results),
    }
    if results:
        told |= {
            "no_contact": _share(results, lambda r: r.finished and r.metrics["gap_obstacle"] > 0),
            "inside_road": _share(results, lambda r: r.finished and r.metrics["gap_edge"] >= 0),
            "both": _share(results, is_safe),
            "solver_limit": _share(results, lambda r: r.metrics.get("solver_limits", 0) > 0),
            "solver_failure": _share(results, lambda r: r.metrics.get("solver_fallbacks", 0) > 0),
            "faults": sum(not r.finished for r in results),
            "spread": dict(_spreads(results)),
        }
    return told


def _share(results: Sequence[Result], holds: Callable[[Result], bool]) -> float:
    return sum(map(holds, results)) / len(results)


def _spreads(results: Sequence[Result]) -> Iterator[tuple[str, dict[str, float]]]:
    for name in SPREAD:
        values = [r.metrics[name] for r in results if name in r.metrics]
        if values:
            yield name, {f"p{p}": float(np.percentile(values, p)) for p in _PERCENTILES}
