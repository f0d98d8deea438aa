"""The page that says where a run comes from, or several: as Markdown."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from orchestrator.pictures.plots import parameter_values
from orchestrator.system.experiment import Scenario
from orchestrator.system.system import System


def facts(summary: Mapping[str, Any]) -> dict[str, str]:
    """What `summary.json` says in a few words; what it does not say is left out."""
    if not summary:
        return {"status": "cut short: there is no summary.json"}
    found = {"scenario": f"{summary['scenario']}: {summary['title']}", "status": summary["status"]}
    if "fault" in summary:
        found |= fault(summary["fault"])
    for name, unit in summary["units"].items():
        found[f"unit {name}"] = f"{unit['kind']}, {unit['runs_as']}"
    return found | dict(summary["versions"])


def fault(told: Mapping[str, Any]) -> dict[str, str]:
    """What ended a run before its time, and when; `told` are tick, time [s], unit and reason."""
    at = f"tick {told['tick']} (t = {told['time']:g} s)"
    return {"fault": f"unit `{told['unit']}`: {told['reason']}", "fault at": at}


def page(name: str, told: Mapping[str, str], system: System) -> str:
    """The page of one run: what is `told` of it, then its parameters and connections."""
    text = f"# {name}\n\n" + _table(("", ""), told.items())
    if parameters := list(_parameters(system)):
        text += "\n## Parameters\n\n" + _table(("parameter", "value", "unit", "meaning"), parameters)
    wires = "\n".join(f"* {connection}" for connection in system.connections)
    return text + (f"\n## Connections\n\n{wires}\n" if wires else "")


def comparison(names: Sequence[str], summaries: Sequence[Mapping[str, Any]], scenarios: Sequence[Scenario]) -> str:
    """The page of several runs: a column each, then the parameters in which they differ."""
    head = ("", *names)
    told = [facts(summary) | _measured(summary) for summary in summaries]
    keys = list(dict.fromkeys(key for one in told for key in one))
    rows = [(key, *(one.get(key, "") for one in told)) for key in keys]
    text = f"# {' against '.join(names)}\n\n" + _table(head, rows)
    values = [{key: f"{value['value']} {value['unit']}" for key, value in s.sources.items()} for s in scenarios]
    parameters = {key: [one.get(key, "-") for one in values] for key in sorted({k for one in values for k in one})}
    differing = [(key, *found) for key, found in parameters.items() if len(set(found)) > 1]
    return text + "\n## Parameters that differ\n\n" + _table(head, differing) if differing else text


def _table(head: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    first = "".join(f"| {name} " if name else "| " for name in head)
    lines = [first, "|---" * len(head), *(f"| {' | '.join(map(_cell, row))} " for row in rows)]
    return "".join(f"{line}|\n" for line in lines)


def _cell(content: object) -> str:
    """What stands in a cell; the texts of other makers may hold what would end it."""
    return " ".join(str(content).split()).replace("|", r"\|")


def _measured(summary: Mapping[str, Any]) -> dict[str, str]:
    verdicts = {name.replace("_", " "): "yes" if holds else "no" for name, holds in summary.get("verdicts", {}).items()}
    return verdicts | {name: f"{value:.4g}" for name, value in summary.get("metrics", {}).items()}


def _parameters(system: System) -> Iterator[tuple[object, ...]]:
    for name, source in system.units.items():
        values = parameter_values(system, name)
        for variable in source.interface.parameters:
            if variable.name in values:
                q = variable.quantity
                yield f"{name}.{variable.name}", values[variable.name], q.unit, q.description
