"""The page that says where a run comes from, or several: as Markdown."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from orchestrator.scenario import Scenario
from orchestrator.system import System


def facts(summary: Mapping[str, Any]) -> dict[str, str]:
    """What `summary.json` says in a few words; what it does not say is left out."""
    if not summary:
        return {"status": "cut short: there is no summary.json"}
    found = {"scenario": f"{summary['scenario']}: {summary['title']}", "status": summary["status"]}
    for name, unit in summary["units"].items():
        found[f"unit {name}"] = f"{unit['kind']}, {unit['runs_as']}"
    return found | dict(summary["versions"])


def page(name: str, told: Mapping[str, str], system: System) -> str:
    """The page of one run: what is `told` of it, then its parameters and connections."""
    rows = "\n".join(f"| {key} | {value} |" for key, value in told.items())
    text = f"# {name}\n\n| | |\n|---|---|\n{rows}\n"
    parameters = "\n".join(_parameters(system))
    if parameters:
        text += f"\n## Parameters\n\n| parameter | value | unit | meaning |\n|---|---|---|---|\n{parameters}\n"
    wires = "\n".join(f"* {connection}" for connection in system.connections)
    return text + (f"\n## Connections\n\n{wires}\n" if wires else "")


def comparison(names: Sequence[str], summaries: Sequence[Mapping[str, Any]], scenarios: Sequence[Scenario]) -> str:
    """The page of several runs: a column each, then the parameters in which they differ."""
    head = f"| | {' | '.join(names)} |\n|---|{'---|' * len(names)}\n"
    told = [facts(summary) | _measured(summary) for summary in summaries]
    keys = list(dict.fromkeys(key for one in told for key in one))
    text = f"# {' against '.join(names)}\n\n{head}" + _table({key: [one.get(key, "") for one in told] for key in keys})
    values = [{key: f"{value['value']} {value['unit']}" for key, value in s.sources.items()} for s in scenarios]
    parameters = {key: [one.get(key, "-") for one in values] for key in sorted({k for one in values for k in one})}
    differing = {key: found for key, found in parameters.items() if len(set(found)) > 1}
    return text + f"\n## Parameters that differ\n\n{head}{_table(differing)}" if differing else text


def _table(rows: Mapping[str, Sequence[str]]) -> str:
    return "".join(f"| {key} | {' | '.join(values)} |\n" for key, values in rows.items())


def _measured(summary: Mapping[str, Any]) -> dict[str, str]:
    verdicts = {name.replace("_", " "): "yes" if holds else "no" for name, holds in summary.get("verdicts", {}).items()}
    return verdicts | {name: f"{value:.4g}" for name, value in summary.get("metrics", {}).items()}


def _parameters(system: System) -> Iterator[str]:
    for name, source in system.units.items():
        values = {**source.interface.starts, **source.parameters}
        for variable in source.interface.parameters:
            if variable.name in values:
                q = variable.quantity
                yield f"| {name}.{variable.name} | {values[variable.name]} | {q.unit} | {q.description} |"
