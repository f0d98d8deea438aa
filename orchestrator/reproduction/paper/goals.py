"""The goals of `mpc_plus`, which go beyond the paper; they are decided as the claims are."""

from __future__ import annotations

from typing import Final

from orchestrator.reproduction.paper.evidence import TUNED, Evidence
from orchestrator.reproduction.paper.experiments import RunRole
from orchestrator.reproduction.paper.verdict import FAULT_NOTE, Case, DecidingNumber, Verdict, unmet

ACCURATE: Final = 0.25
"""[m] Largest rms path error in the nominal case."""


def nominal(evidence: Evidence) -> Verdict:
    """Decide whether it is accurate, smoother than the tuned MP method, without contact and inside the road."""
    cases: list[Case] = []
    for plus in evidence.of(RunRole.PLUS):
        for mp in (r for r in evidence.of(RunRole.MP, plus) if r.label == TUNED):
            own, other = plus.metrics, mp.metrics
            numbers = plus.numbers("gap_obstacle", "gap_edge", "path_error_rms", "r_dot_rms")
            numbers += (DecidingNumber("r_dot_rms", other["r_dot_rms"], of=mp.label),)
            if (off_path := evidence.off_path.get(plus.name)) is not None:
                numbers += (DecidingNumber("path_error_rms", off_path, of=f"the path of {mp.label}"),)
            met = {
                "gap_obstacle": own.get("gap_obstacle", 1.0) > 0,
                "gap_edge": own["gap_edge"] >= 0,
                "path_error_rms": own["path_error_rms"] <= ACCURATE,
                "r_dot_rms": own["r_dot_rms"] < other["r_dot_rms"],
            }
            against = unmet(met)
            factors, note = {"task": plus.task, "tyre": plus.tyre}, "" if plus.finished else FAULT_NOTE
            holds = plus.finished and not against
            cases.append(Case(factors, holds, numbers, (plus.name, mp.name), note, against))
    return Verdict(
        "plus",
        "mpc-plus is accurate and smoother than the tuned MP method",
        f"no contact, inside the road, rms path error at most {ACCURATE:g} m, rms r_dot below that of {TUNED}",
        tuple(cases),
        ("The path error is from the path that the controller itself plans; that from the MP method's is told too.",),
    )
