"""The report as Markdown, from its content as plain data: what stands here stands in `report.json` too."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Final

from orchestrator.reproduction.report.metric_names import COLUMNS, number
from orchestrator.reproduction.report.tables import details, run_link, table, verdict_table
from orchestrator.reproduction.varied.varied_text import varied_section

_TABLES: Final = (
    ("Safety and accuracy", ("gap_obstacle", "gap_edge", "corridor_violations", "path_error_rms", "path_error_max")),
    (
        "Smoothness",
        (
            "r_peak",
            "r_rms",
            "r_total_variation",
            "r_sign_changes",
            "r_dot_rms",
            "r_dot_peak",
            "delta_f_rate_rms",
            "a_y_peak",
        ),
    ),
    ("Limits and speed", ("mu_f_max", "mu_r_max", "v_x_min", "v_x_max")),
    ("Solver", ("solver_iterations_max", "solver_kkt_max", "solver_limits", "solver_fallbacks")),
)
"""The table of metrics in parts that fit a page; together they have all columns."""


def markdown(told: Mapping[str, Any]) -> str:
    """The whole report."""
    parts = [
        _head(told),
        "## Verdicts",
        verdict_table(told["claims"]),
        *(_figure(figure) for figure in told["figures"]),
        "## What decides each verdict",
        *_details(told["claims"], told),
        "## Beyond the paper",
        verdict_table(told["goals"]),
        *_details(told["goals"], told),
        *(varied_section(told["varied"]) if told["varied"] else ()),
        "## Metrics of the runs",
        *_metrics([run for run in told["runs"] if run["role"] != "sweep"]),
        "## Gains of the two-level method",
        "Sweep points have recordings and all signals, but no figures in their run folders.",
        *_metrics([run for run in told["runs"] if run["role"] == "sweep"]),
        *_timings(told["timings"]),
        "## How to run one again",
        table(
            ("run", "command", ""), ([run_link(r), f"`{r['command']}`", "; ".join(r["remarks"])] for r in told["runs"])
        ),
        "Versions: " + ", ".join(f"{name} {version}" for name, version in told["versions"].items()) + ".",
    ]
    return "\n\n".join(part for part in parts if part) + "\n"


def _head(told: Mapping[str, Any]) -> str:
    return (
        "# The paper, reproduced\n\n"
        "*Model predictive approach to integrated path planning and tracking for autonomous vehicles* (C. Huang, "
        "B. Li, M. Kishida): all its experiments, and what becomes of its claims. Every number is a metric in the "
        "`summary.json` of a run folder below `runs/`, or is computed from its `signals.parquet`; `report.json` has "
        "them all. What the paper leaves open is ours and stands in the scenarios with that word as its source. "
        f"There are {len(told['runs'])} runs."
    )


def _details(verdicts: Sequence[Mapping[str, Any]], told: Mapping[str, Any]) -> Iterator[str]:
    runs = {run["name"]: run for run in told["runs"]}
    for verdict in verdicts:
        yield from details(verdict, runs, told["timings"]["claims"].get(verdict["claim"], ()))


def _figure(figure: Mapping[str, str]) -> str:
    return f"![{figure['caption']}]({figure['file']})\n\n*{figure['caption']}*"


def _metrics(runs: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    listed = {name for _, names in _TABLES for name in names}
    others = tuple(dict.fromkeys(n for run in runs for n in run["metrics"] if n not in listed))
    for heading, names in (*_TABLES, ("Others", others)):
        shown = [name for name in names if any(name in run["metrics"] for run in runs)]
        if not shown:
            continue
        yield f"### {heading}"
        head = ("run", "", "plant", *(COLUMNS.get(name, name) for name in shown), "recording")
        yield table(head, (_row(run, shown) for run in runs))


def _row(run: Mapping[str, Any], names: Sequence[str]) -> list[str]:
    metrics = run["metrics"]
    values = [number(metrics[name]) if name in metrics else "-" for name in names]
    ended = "" if run["status"] == "finished" else f" (ended in a fault: {run['fault']['reason']})"
    return [run_link(run), run["label"] + ended, run["plant"], *values, f"[open]({run['recording']})"]


def _timings(timings: Mapping[str, Any]) -> Iterator[str]:
    if not timings["controllers"]:
        return
    yield "## Time per sample"
    yield (
        f"Path planning and solve, measured in one go on the states of `{timings['states']}`; ratios to "
        f"`{timings['ratio_to']}`. This is the only part that differs from one reproduction to the next."
    )
    rows = (
        [
            f"`{t['controller']}`",
            t["way"],
            f"{t['p50_us']:.1f}",
            f"{t['p99_us']:.1f}",
            number(t["ratio_p50"]),
            number(t["ratio_p99"]),
        ]
        for t in timings["controllers"]
    )
    yield table(("controller", "runs as", "p50 [us]", "p99 [us]", "ratio of p50", "ratio of p99"), rows)
