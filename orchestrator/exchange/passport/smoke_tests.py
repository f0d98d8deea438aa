"""The smoke tests that an FMU carries, after FMI's layered standard for references (FMI-LS-REF).

Its manifest lists the files that belong to the FMU; those with the role `experiment` hold experiments: parameters
(SSV), stimuli and reference results (CSV: the time first, then a column per variable). They are run and compared.
"""

from __future__ import annotations

import csv
import io
import posixpath
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, Final

from components.interfaces.problem import RequestError
from fmus.reading.archive import Archive
from fmus.reading.unpack import read_file
from fmus.reading.xml_documents import parse_xml
from orchestrator.exchange.passport.bench import Bench, MeasurementError
from orchestrator.exchange.passport.experiment_run import Experiment, TimeSeries, drive_experiment, worst_deviation
from orchestrator.exchange.passport.passport_line import Line, Measured, Topic

LAYERED_MANIFEST: Final = "extra/org.fmi-standard.fmi-ls-ref/fmi-ls-manifest.xml"
CARRIED: Final = Topic("smoke.carried", "The smoke tests that it carries can be read")

_ROLES: Final = ("experiment", "experiment/smoke-test")
_CSV, _SSV = "text/csv", "application/x-ssp-parameter-set"


class UnreadableTestError(ValueError):
    """A smoke test that cannot be read; the message says why."""


@dataclass
class _Carried:
    """What was found in the archive."""

    experiments: list[Experiment] = field(default_factory=list[Experiment])
    faults: list[str] = field(default_factory=list[str])


def lines(bench: Bench, *, runs: bool) -> list[Line]:
    """The lines about smoke tests: one about all of them, and one for each.

    Args:
        bench: Where they are run.
        runs: Whether the FMU runs at all.
    """
    if LAYERED_MANIFEST not in bench.archive.files:
        return [CARRIED.does_not_apply("it carries none")]
    found = _Carried()
    try:
        found = carried(bench.archive)
    except RequestError as error:
        found.faults += [problem.found for problem in error.problems]
    if not found.experiments and not found.faults:
        return [CARRIED.does_not_apply("its manifest lists no smoke tests")]
    names = ", ".join(experiment.name for experiment in found.experiments)
    line = CARRIED.judged(found.faults, f"{len(found.experiments)} of them: {names}")
    return [line, *(_line(bench, experiment, runs=runs) for experiment in found.experiments)]


def carried(archive: Archive) -> _Carried:
    """The smoke tests in an FMU, and what keeps others from being read. Raises `RequestError`."""
    root = parse_xml(read_file(archive.path, LAYERED_MANIFEST), LAYERED_MANIFEST, "well-formed XML")
    found = _Carried()
    for related in root.iterfind("Related"):
        if related.get("role") in _ROLES:
            path = _resolved(LAYERED_MANIFEST, related.get("source", ""))
            if path not in archive.files:
                found.faults.append(f"`{related.get('source')}` is not in the file")
                continue
            set_ = parse_xml(read_file(archive.path, path), path, "well-formed XML")
            for node in set_.iterfind("Experiment"):
                try:
                    found.experiments.append(_experiment(archive, path, node))
                except UnreadableTestError as error:
                    found.faults.append(f"{node.get('name')}: {error}")
    return found


def _resolved(base: str, source: str) -> str:
    """The path in the archive of a URI that is relative to the file that names it."""
    return posixpath.normpath(posixpath.join(posixpath.dirname(base), source))


def _experiment(archive: Archive, path: str, node: Any) -> Experiment:
    texts = {child.tag: _text(archive, path, child) for child in node if child.tag != "Annotations"}
    numbers = {name: _number(node, name) for name in ("startTime", "stopTime", "stepSize", "tolerance")}
    if "References" not in texts:
        raise UnreadableTestError("it has no reference results")
    return Experiment(
        name=node.get("name") or posixpath.basename(path),
        start=numbers["startTime"],
        stop=numbers["stopTime"],
        step=numbers["stepSize"],
        tolerance=numbers["tolerance"],
        parameters=dict(_parameters(texts["Parameters"])) if "Parameters" in texts else {},
        stimuli=series(texts["Stimuli"]) if "Stimuli" in texts else None,
        references=series(texts["References"]),
    )


def _text(archive: Archive, path: str, node: Any) -> str:
    kind = node.get("type") or (_SSV if node.tag == "Parameters" else _CSV)
    if kind != (_SSV if node.tag == "Parameters" else _CSV):
        raise UnreadableTestError(f"`{node.get('source')}` has the type `{kind}`, which is not read here")
    for base in (path, LAYERED_MANIFEST):
        place = _resolved(base, node.get("source") or "")
        if place in archive.files:
            return read_file(archive.path, place).decode("utf-8-sig", "replace")
    raise UnreadableTestError(f"`{node.get('source')}` is not in the file")


def _number(node: Any, name: str) -> float | None:
    text = node.get(name)
    try:
        return None if text is None else float(text)
    except ValueError:
        raise UnreadableTestError(f"`{name}` is `{text}`, which is no number") from None


def _parameters(text: str) -> Iterator[tuple[str, str]]:
    """The values of a parameter set, as its texts."""
    root: Any = parse_xml(text.encode(), "the parameter set", "well-formed XML")
    for parameter in root.iter("{*}Parameter"):
        for value in parameter:
            if value.get("value") is not None:
                yield parameter.get("name"), value.get("value")


def series(text: str) -> TimeSeries:
    """A table of values over time: the first column is the time, whatever it is called.

    Raises:
        UnreadableTestError: It is no such table.
    """
    first = text.partition("\n")[0]
    rows = list(csv.reader(io.StringIO(text), delimiter=";" if ";" in first and "," not in first else ","))
    rows = [row for row in rows if any(cell.strip() for cell in row)]
    names = [cell.strip() for cell in rows[0]] if rows else []
    if len(rows) < 2:  # noqa: PLR2004 - names and one row
        raise UnreadableTestError("a table without rows")
    try:
        values = [[_value(cell) for cell in row] for row in rows[1:]]
        columns: Mapping[str, list[float]] = dict(zip(names, map(list, zip(*values, strict=True)), strict=True))
    except ValueError as error:
        raise UnreadableTestError(f"a table that cannot be read ({error})") from None
    return TimeSeries(tuple(columns[names[0]]), {name: tuple(columns[name]) for name in names[1:]})


def _value(cell: str) -> float:
    text = cell.strip().lower()
    return float({"true": "1", "false": "0"}.get(text, text))


def _line(bench: Bench, experiment: Experiment, *, runs: bool) -> Line:
    key = re.sub(r"\W+", "_", experiment.name).strip("_").lower() or "test"
    topic = Topic(f"smoke.test_{key}", f"Smoke test {experiment.name} gives its reference results")
    if not runs:
        return topic.does_not_apply("it does not run here")
    try:
        rows = bench.measure(drive_experiment, experiment)
        worst = worst_deviation(experiment, rows)
    except MeasurementError as error:
        return topic.fails(str(error))
    if worst is None:
        return topic.fails("no column of its reference results has the name of an output")
    text = f"`{worst.name}` deviates by {worst.relative:.2g} of its largest value at {worst.time:g} s"
    figures = {"deviation": Measured(worst.relative, "1"), "limit": Measured(experiment.limit, "1")}
    if worst.relative <= experiment.limit:
        return topic.passes(f"{text}, the most of {worst.compared} signals ({experiment.limit:g} may)", figures)
    return topic.fails(f"{text}; {experiment.limit:g} may", figures)
