"""The claims of the paper, each decided by a pure function of metrics; RESOLUTIONS says what each is measured by.

The constants define, before any run, what counts as accurate and as the same trajectory.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Final

from orchestrator.reproduction.paper import matched
from orchestrator.reproduction.paper.evidence import AS_FMU, IN_PROCESS, Evidence, Result, Timing
from orchestrator.reproduction.paper.experiments import RunRole
from orchestrator.reproduction.paper.verdict import FAULT_NOTE, TIME_METRIC, Case, DecidingNumber, Verdict, unmet

ACCURATE_RMS: Final = 0.25
"""[m] Largest rms path error that counts as accurate: the same as for `mpc_plus`."""

ACCURATE_MAX: Final = 0.85
"""[m] Largest path error that counts as accurate: a 1.8 m wide car stays inside its 3.5 m wide lane."""

SAME_TRAJECTORY: Final = 0.01
"""[m] Trajectories that are nowhere further apart count as the same."""

STATIC_TASK: Final = "static"
"""The task with obstacles that stand still."""


def decide(evidence: Evidence) -> list[Verdict]:
    """Decide C1 to C8."""
    return [claim(evidence) for claim in CLAIMS.values()]


def c1(evidence: Evidence) -> Verdict:
    """Decide smoothness at matched accuracy."""
    cases: list[Case] = []
    for mp in _static(evidence, RunRole.MP):
        for curve in evidence.curves_for(mp):
            factors = {"setting": mp.label, "against": curve.label, "tyre": mp.tyre}
            if not mp.finished:
                cases.append(Case(factors, holds=False, measured=(), runs=(mp.name,), note=FAULT_NOTE))
                continue
            compared = matched.compare(mp.metrics, curve)
            numbers = mp.numbers("path_error_rms", *matched.SMOOTHNESS)
            numbers += tuple(DecidingNumber(name, value, curve.label) for name, value in compared.at.items())
            runs = (mp.name, *compared.runs)
            rougher = _not_lower(mp.metrics, compared.at, matched.SMOOTHNESS) if compared.smoother is False else ()
            cases.append(Case(factors, compared.smoother, numbers, runs, compared.how, rougher))
    return Verdict(
        "C1",
        "MP gives a smooth and flexible path compared with the two-level method",
        "total variation of r and rms r_dot both below the two-level method's at the same rms path error, on the curve "
        "of its gains",
        tuple(cases),
    )


def c2(evidence: Evidence) -> Verdict:
    """Decide the accuracy of both methods."""
    largest = {"path_error_rms": ACCURATE_RMS, "path_error_max": ACCURATE_MAX}
    cases: list[Case] = []
    for r in (r for role in (RunRole.MP, RunRole.TWO_LEVEL) for r in _static(evidence, role)):
        exceeded = unmet({name: r.metrics[name] <= most for name, most in largest.items()} if r.finished else {})
        factors, note = {"method": r.label, "tyre": r.tyre}, "" if r.finished else FAULT_NOTE
        cases.append(Case(factors, r.finished and not exceeded, r.numbers(*largest), (r.name,), note, exceeded))
    return Verdict(
        "C2",
        "both methods follow the Dubins path accurately",
        f"path error at most {ACCURATE_RMS:g} m rms and {ACCURATE_MAX:g} m (the car stays in its lane) at any time",
        tuple(cases),
    )


def c3(evidence: Evidence) -> Verdict:
    """Decide the smoothness of the driven path."""
    return Verdict(
        "C3",
        "MP gives the smoother lane change path",
        "rms r_dot and rms steering rate both below the two-level method's, each controller at its own parameters",
        tuple(_lower(evidence, "r_dot_rms", "delta_f_rate_rms")),
    )


def c4(evidence: Evidence) -> Verdict:
    """Decide the stability of the yaw rate."""
    return Verdict(
        "C4",
        "more stable yaw rate, less change of yaw angle",
        "peak and rms of r and rms r_dot all below the two-level method's, each controller at its own parameters",
        tuple(_lower(evidence, "r_peak", "r_rms", "r_dot_rms")),
    )


def c5(evidence: Evidence) -> Verdict:
    """Decide whether the two-level method oscillates."""

    def steadier(mp: Mapping[str, float], other: Mapping[str, float]) -> tuple[str, ...]:
        no_fewer = other["r_sign_changes"] >= mp["r_sign_changes"]
        return _not_lower(mp, other, ("r_total_variation", "r_dot_peak")) + unmet({"r_sign_changes": no_fewer})

    names = ("r_total_variation", "r_sign_changes", "r_dot_peak")
    return Verdict(
        "C5",
        "the two-level yaw rate oscillates abruptly",
        "its total variation of r and peak r_dot above the MP method's, and no fewer changes of sign of r",
        tuple(_pairs(evidence, names, steadier)),
    )


def c6(evidence: Evidence) -> Verdict:
    """Decide how moving obstacles are avoided."""
    cases: list[Case] = []
    for mp in (r for r in evidence.of(RunRole.MP) if r.task != STATIC_TASK):
        for other in evidence.of(RunRole.TWO_LEVEL, mp):
            factors = {"task": mp.task, "setting": mp.label, "against": other.label, "tyre": mp.tyre}
            runs = (mp.name, other.name)
            if not (mp.finished and other.finished):
                cases.append(Case(factors, None if mp.finished else False, (), runs, FAULT_NOTE))
                continue
            m = mp.metrics
            met = {
                "gap_obstacle": m["gap_obstacle"] > 0,
                "gap_edge": m["gap_edge"] >= 0,
                "corridor_violations": m.get("corridor_violations", 0) == 0,
                "r_total_variation": m["r_total_variation"] < other.metrics["r_total_variation"],
            }
            numbers = mp.numbers("gap_obstacle", "gap_edge", "corridor_violations", "r_total_variation")
            numbers += other.numbers("r_total_variation", of=other.label)
            cases.append(Case(factors, all(met.values()), numbers, runs, against=unmet(met)))
    return Verdict(
        "C6",
        "avoids moving obstacles, smoothly",
        "least gap to any obstacle above 0, inside the road, no corridor violation, and total variation of r below the "
        "two-level method's",
        tuple(cases),
    )


def c7(evidence: Evidence) -> Verdict:
    """Decide whether the active set is the best of the algorithms."""
    times = {t.controller: t for t in evidence.timings if t.way == IN_PROCESS}
    names = {r.name: r for r in evidence.results}
    cases: list[Case] = []
    if (mp := names.get(evidence.reference)) is not None:
        for other in evidence.of(RunRole.ALGORITHM, mp):
            own, its = times[mp.controller], times[other.controller]
            distance, failures = evidence.distances[other.name], _failures(mp)
            numbers = (
                DecidingNumber("distance", distance),
                DecidingNumber("failures", failures),
                DecidingNumber("failures", _failures(other), of=other.label),
                *_times(own, its, other.label),
            )
            met = {
                "distance": distance <= SAME_TRAJECTORY,
                "failures": failures <= _failures(other),
                TIME_METRIC: own.p50_us <= its.p50_us,
            }
            runs = (mp.name, other.name)
            cases.append(Case({"against": other.label}, all(met.values()), numbers, runs, against=unmet(met)))
    notes = [
        f"{names[r.name].label}: {evidence.distances[r.name]:.3g} m from the active set's trajectory at most, speed "
        f"down to {r.metrics['v_x_min']:.2f} m/s. Curves that differ can be an early end of the iteration."
        for r in evidence.of(RunRole.LOOSE)
    ]
    return Verdict(
        "C7",
        "three algorithms, active set chosen",
        f"the same trajectory within {SAME_TRAJECTORY:g} m, and for the active set no more failed solves and no more "
        "time per sample than for the other algorithm (both in this process)",
        tuple(cases),
        tuple(notes),
    )


def c8(evidence: Evidence) -> Verdict:
    """Decide whether the integrated structure takes no more time."""
    native = {t.controller: t for t in evidence.timings if t.way == AS_FMU}
    own = native.get("mpc")
    labels = {r.controller: r.label for r in evidence.of(RunRole.TWO_LEVEL)}
    cases = [_faster(own, native[c], label) for c, label in labels.items() if own is not None and c in native]
    return Verdict(
        "C8",
        "the integrated structure is computationally efficient",
        "time per sample (p50, FMU) not above the two-level method's",
        tuple(cases),
    )


CLAIMS: Final[Mapping[str, Callable[[Evidence], Verdict]]] = {
    "C1": c1,
    "C2": c2,
    "C3": c3,
    "C4": c4,
    "C5": c5,
    "C6": c6,
    "C7": c7,
    "C8": c8,
}


def _faster(own: Timing, other: Timing, label: str) -> Case:
    met = {TIME_METRIC: own.p50_us <= other.p50_us}
    return Case({"against": label}, all(met.values()), _times(own, other, label), (), against=unmet(met))


def _times(own: Timing, other: Timing, label: str) -> tuple[DecidingNumber, ...]:
    return DecidingNumber(TIME_METRIC, own.p50_us), DecidingNumber(TIME_METRIC, other.p50_us, of=label)


def _static(evidence: Evidence, role: RunRole) -> Iterable[Result]:
    return (r for r in evidence.of(role) if r.task == STATIC_TASK)


def _not_lower(mp: Mapping[str, float], other: Mapping[str, float], names: Iterable[str]) -> tuple[str, ...]:
    return unmet({name: mp[name] < other[name] for name in names})


def _lower(evidence: Evidence, *names: str) -> Iterator[Case]:
    return _pairs(evidence, names, lambda mp, other: _not_lower(mp, other, names))


def _pairs(
    evidence: Evidence,
    names: Iterable[str],
    against: Callable[[Mapping[str, float], Mapping[str, float]], tuple[str, ...]],
) -> Iterator[Case]:
    """Compare every MP run with every two-level run of the same task on the same plant.

    Args:
        evidence: The runs.
        names: The metrics that are told.
        against: Which metrics of two finished runs speak against the claim.
    """
    listed = tuple(names)
    for mp in _static(evidence, RunRole.MP):
        for other in evidence.of(RunRole.TWO_LEVEL, mp):
            numbers = mp.numbers(*listed) + other.numbers(*listed, of=other.label)
            factors = {"setting": mp.label, "against": other.label, "tyre": mp.tyre}
            runs = (mp.name, other.name)
            if mp.finished and other.finished:
                metrics = against(mp.metrics, other.metrics)
                yield Case(factors, not metrics, numbers, runs, against=metrics)
            else:
                yield Case(factors, None if mp.finished else False, numbers, runs, FAULT_NOTE)


def _failures(result: Result) -> float:
    return result.metrics.get("solver_fallbacks", 0.0) + result.metrics.get("solver_limits", 0.0)
