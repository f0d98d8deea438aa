"""What is asked of `mpc_plus`, beyond the paper; decided as the claims are."""

from __future__ import annotations

from typing import Final

from orchestrator.reproduction.paper.evidence import TUNED, Evidence
from orchestrator.reproduction.paper.experiments import Role
from orchestrator.reproduction.paper.verdict import Case, Verdict

ACCURATE: Final = 0.25
"""[m] rms path error at most, in the nominal case"""


def nominal(evidence: Evidence) -> Verdict:
    """Accurate, and smoother than the tuned MP, without contact and inside the road."""
    cases: list[Case] = []
    for plus in evidence.of(Role.PLUS):
        for mp in (r for r in evidence.of(Role.MP, plus) if r.label == TUNED):
            own, other = plus.metrics, mp.metrics
            numbers = {n: own[n] for n in ("gap_obstacle", "gap_edge", "path_error_rms", "r_dot_rms") if n in own}
            numbers[f"r_dot_rms of {mp.label}"] = other["r_dot_rms"]
            if plus.name in evidence.off_path:
                numbers[f"path_error_rms of the path of {mp.label}"] = evidence.off_path[plus.name]
            safe = own.get("gap_obstacle", 1.0) > 0 and own["gap_edge"] >= 0
            holds = safe and own["path_error_rms"] <= ACCURATE and own["r_dot_rms"] < other["r_dot_rms"]
            factors = {"task": plus.task, "tyre": plus.tyre}
            cases.append(Case(factors, plus.finished and holds, numbers, (plus.name, mp.name)))
    return Verdict(
        "plus",
        "mpc-plus is accurate and smoother than the tuned MP method",
        f"no contact, inside the road, rms path error at most {ACCURATE:g} m, rms r_dot below that of {TUNED}",
        tuple(cases),
        ("The path error is from the path that the controller itself plans; that from the MP method's is told too.",),
    )
