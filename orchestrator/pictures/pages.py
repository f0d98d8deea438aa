"""The page about a run, or about several runs, as Markdown: where they come from, and how they ended."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, Final

from orchestrator.pictures import plots
from orchestrator.pictures.signals import signals
from orchestrator.results.provenance import facts
from orchestrator.system.experiment import Scenario
from orchestrator.system.shown import parameter_values
from orchestrator.system.system import System

_DRAWN: Final = "".join(
    f"* {line}\n"
    for line in (
        "**blue box**: the ego vehicle; its **trail** goes from green on the path to red far from it",
        "**orange boxes**: obstacles, each with its number; the pale line around one is its safety boundary",
        "**violet line** with P0 to P14: the path that is followed; **white line**: the plan over the horizon",
        "**yellow lines**: the corridor in which the plan has to stay",
        "**grey lines** in plots: limits and desired values; signals that are held are drawn as steps",
    )
)
"""The legend of the pictures."""


def page(name: str, about: Mapping[str, str], system: System) -> str:
    """The page of one run: its provenance, its parameters and its connections.

    Args:
        name: What the run is called.
        about: Its provenance, as `provenance.facts` gives it.
        system: What was run.
    """
    text = f"# {name}\n\n" + table(("", ""), about.items()) + f"\n## What is drawn\n\n{_DRAWN}"
    if drawn := list(_plotted(system)):
        text += "\n" + table(("plot", "quantity", "limits and desired values"), drawn)
    if parameters := list(_parameters(system)):
        text += "\n## Parameters\n\n" + table(("parameter", "value", "unit", "meaning"), parameters)
    wires = "\n".join(f"* {connection}" for connection in system.connections)
    return text + (f"\n## Connections\n\n{wires}\n" if wires else "")


def comparison(names: Sequence[str], summaries: Sequence[Mapping[str, Any]], scenarios: Sequence[Scenario]) -> str:
    """The page of several runs: a column for each, then the parameters in which they differ.

    Args:
        names: What the runs are called.
        summaries: The content of `summary.json` of each; empty for a run that was cut short.
        scenarios: What was run.
    """
    head = ("", *names)
    about = [facts(summary) | _measured(summary) for summary in summaries]
    keys = list(dict.fromkeys(key for one in about for key in one))
    rows = [(key, *(one.get(key, "") for one in about)) for key in keys]
    text = f"# {' against '.join(names)}\n\n" + table(head, rows)
    values = [{key: f"{value['value']} {value['unit']}" for key, value in s.sources.items()} for s in scenarios]
    parameters = {key: [one.get(key, "-") for one in values] for key in sorted({k for one in values for k in one})}
    differing = [(key, *different) for key, different in parameters.items() if len(set(different)) > 1]
    text += f"\n\N{GREEK CAPITAL LETTER DELTA} in a plot is the difference from {names[0]}.\n"
    return text + "\n## Parameters that differ\n\n" + table(head, differing) if differing else text


def table(head: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A table in Markdown.

    Args:
        head: The titles of its columns.
        rows: Its rows.
    """
    first = "".join(f"| {name} " if name else "| " for name in head)
    lines = [first, "|---" * len(head), *(f"| {' | '.join(map(_cell, row))} " for row in rows)]
    return "".join(f"{line}|\n" for line in lines)


def _cell(content: object) -> str:
    """The content of a cell, in one line; the texts of foreign FMUs may hold characters that would end it."""
    lines = (" ".join(line.split()) for line in str(content).splitlines())
    return ", ".join(line for line in lines if line).replace("|", r"\|")


def _measured(summary: Mapping[str, Any]) -> dict[str, str]:
    verdicts = {name.replace("_", " "): "yes" if holds else "no" for name, holds in summary.get("verdicts", {}).items()}
    return verdicts | {name: f"{value:.4g}" for name, value in summary.get("metrics", {}).items()}


def _plotted(system: System) -> Iterator[tuple[str, str, str]]:
    """What each plot of the first page shows, whose title has only room for a name and a unit."""
    everything = signals(system)
    limits = plots.limits(system, everything)
    for plot in (plot for answers in plots.questions(system, everything).values() for plot in answers):
        for one in plot.split(limits):
            near = (f"{limit.name} {limit.value:.4g} {'' if plot.unit == '1' else plot.unit}" for limit in one.limits)
            yield one.signals[0].path, plot.quantity.lower(), ", ".join(map(str.strip, near))


def _parameters(system: System) -> Iterator[tuple[object, ...]]:
    for name, source in system.units.items():
        values = parameter_values(system, name)
        for variable in source.interface.parameters:
            if variable.name in values:
                q = variable.quantity
                yield f"{name}.{variable.name}", values[variable.name], q.unit, q.description
