"""What the varied set shows: the verdicts on the claims, examined case by case, and each controller's distributions."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from orchestrator.reproduction.paper import claims, goals
from orchestrator.reproduction.paper.evidence import Curve, Evidence, Result
from orchestrator.reproduction.paper.experiments import RunRole
from orchestrator.reproduction.paper.verdict import Case, DecidingNumber, Verdict, verdict_data
from orchestrator.reproduction.varied import variations
from orchestrator.reproduction.varied.variations import VariedController
from orchestrator.reproduction.varied.varied_set import CaseResults, VariedSet

REQUIRED_SHARE: Final = 0.95
"""Share of the cases in which a claim has to hold in order to hold on the varied set."""

VARIED_CLAIMS: Final[Sequence[Callable[[Evidence], Verdict]]] = (
    claims.c1, claims.c2, claims.c3, claims.c4, claims.c5, claims.c6
)  # fmt: skip

SPREAD_METRICS: Final = (
    "path_error_rms",
    "path_error_max",
    "r_dot_rms",
    "r_total_variation",
    "gap_obstacle",
    "gap_edge",
)
"""Metrics whose distributions the report gives."""

_PERCENTILES: Final = (5, 50, 95)


@dataclass(frozen=True)
class JudgedSet:
    """The varied set with the verdicts on it."""

    varied: VariedSet
    claims: tuple[Verdict, ...]
    goals: tuple[Verdict, ...]


def judge(varied: VariedSet) -> JudgedSet:
    """Decide C1 to C6 and the goals: each holds in a comparison where it holds in enough of the cases."""
    decided = tuple(_over_all_cases(varied, claim) for claim in VARIED_CLAIMS)
    return JudgedSet(varied, decided, (_over_all_cases(varied, goals.nominal),))


def content(judged: JudgedSet) -> dict[str, Any]:
    """The varied set as plain data, with everything that it takes to run any case again."""
    plan = judged.varied.plan
    return {
        "count": len(judged.varied.cases),
        "seed": judged.varied.seed,
        "plant": plan.plant,
        "ranges": plan.model_dump(mode="json")["ranges"],
        "controllers": [_distribution(controller, judged.varied) for controller in plan.controllers],
        "claims": [verdict_data(v) for v in judged.claims],
        "goals": [verdict_data(v) for v in judged.goals],
        "unresolved": [results.case.number for results in unresolved(judged.varied)],
        "cases": [_case_data(results, judged.varied) for results in judged.varied.cases],
    }


def _case_data(results: CaseResults, varied: VariedSet) -> dict[str, Any]:
    controllers = {controller.name: controller for controller in varied.plan.controllers}
    return {
        "number": results.case.number,
        "task": results.case.task,
        "drawn": dict(results.case.drawn),
        "stop_time": results.case.stop_time,
        "runs": {
            name: {
                "metrics": dict(result.metrics),
                "fault": results.faults.get(name),
                "command": variations.command(results.case, controllers[name], varied.plan.plant),
            }
            for name, result in results.results.items()
        },
    }


def unresolved(varied: VariedSet) -> list[CaseResults]:
    """The cases in which `mpc_plus` touches an obstacle or leaves the road; these may have no solution at all."""
    return [c for c in varied.cases for r in c.results.values() if r.role is RunRole.PLUS and not is_safe(r)]


def is_safe(result: Result) -> bool:
    """Whether the run has no contact and stays inside the road to its end."""
    return result.finished and result.metrics["gap_obstacle"] > 0 and result.metrics["gap_edge"] >= 0


def _evidence(results: CaseResults, varied: VariedSet) -> Evidence:
    curves: dict[str, list[Result]] = {}
    for controller in varied.plan.controllers:
        if controller.curve and controller.name in results.results:
            curves.setdefault(controller.curve, []).append(results.results[controller.name])
    return Evidence(
        results=tuple(results.results.values()),
        curves=tuple(
            Curve(name, results.case.task, varied.plan.plant, name, tuple(points)) for name, points in curves.items()
        ),
    )


def _over_all_cases(varied: VariedSet, claim: Callable[[Evidence], Verdict]) -> Verdict:
    """The verdict on a claim whose cases are the comparisons, each over all cases of the varied set."""
    comparisons: dict[tuple[tuple[str, str], ...], list[Case]] = {}
    verdicts = [claim(_evidence(results, varied)) for results in varied.cases]
    for verdict in verdicts:
        for case in verdict.cases:
            comparisons.setdefault(tuple(case.factors.items()), []).append(case)
    cases = tuple(_gathered(dict(factors), of) for factors, of in comparisons.items())
    first = verdicts[0]
    decided_by = f"{first.decided_by}; in at least {REQUIRED_SHARE:.0%} of the variations that can be compared"
    return Verdict(first.claim, first.words, decided_by, cases)


def _gathered(factors: Mapping[str, str], cases: Sequence[Case]) -> Case:
    """One comparison over all cases; what speaks against it in most of them comes first."""
    decided = [case.holds for case in cases if case.holds is not None]
    share = sum(decided) / len(decided) if decided else 0.0
    numbers = (
        DecidingNumber("share", share),
        DecidingNumber("cases", float(len(decided))),
        DecidingNumber("cannot be compared", float(len(cases) - len(decided))),
    )
    holds = share >= REQUIRED_SHARE if decided else None
    counts = Counter(metric for case in cases for metric in case.against)
    against = tuple(metric for metric, _ in counts.most_common()) if holds is False else ()
    return Case(factors, holds, numbers, (), against=against)


def _distribution(controller: VariedController, varied: VariedSet) -> dict[str, Any]:
    results = [case.results[controller.name] for case in varied.cases if controller.name in case.results]
    data: dict[str, Any] = {
        "name": controller.name,
        "label": controller.label,
        "tasks": list(controller.tasks),
        "settings": list(controller.settings),
        "cases": len(results),
    }
    if results:
        data |= {
            "no_contact": _share(results, lambda r: r.finished and r.metrics["gap_obstacle"] > 0),
            "inside_road": _share(results, lambda r: r.finished and r.metrics["gap_edge"] >= 0),
            "both": _share(results, is_safe),
            "solver_limit": _share(results, lambda r: r.metrics.get("solver_limits", 0) > 0),
            "solver_failure": _share(results, lambda r: r.metrics.get("solver_fallbacks", 0) > 0),
            "faults": sum(not r.finished for r in results),
            "spread": dict(_spreads(results)),
        }
    return data


def _share(results: Sequence[Result], holds: Callable[[Result], bool]) -> float:
    return sum(map(holds, results)) / len(results)


def _spreads(results: Sequence[Result]) -> Iterator[tuple[str, dict[str, float]]]:
    for name in SPREAD_METRICS:
        values = [r.metrics[name] for r in results if name in r.metrics]
        if values:
            yield name, {f"p{p}": float(np.percentile(values, p)) for p in _PERCENTILES}
