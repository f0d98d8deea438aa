"""The experiment that an SSP suggests: its stop time, and the macro step that annotations give."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from fmus.unit_interface import SuggestedExperiment
from orchestrator.scenario.options import Options
from orchestrator.scenario.suggested_times import suggested_step, whole_steps
from orchestrator.ssp.annotation import ScenarioAnnotation
from orchestrator.ssp.archive import Document
from orchestrator.ssp.types import number
from orchestrator.ssp.vocabulary import OSP, OSP_ANNOTATION_TYPE, SSC, SSD, Attribute, Tag
from orchestrator.ssp.xml import Node, add, qualified
from orchestrator.system.experiment import STEP, macro_step

_STEP_HINTS: Final = (
    (Tag.FIXED_STEP_ALGORITHM, Attribute.BASE_STEP_SIZE),
    (Tag.FIXED_STEP_MASTER, Attribute.STEP_SIZE),
)
"""The annotations of libcosim and OMSimulator that give a macro step."""


@dataclass(frozen=True)
class DefaultExperiment:
    """The times of a run.

    Attributes:
        step: The macro step [s].
        start: The start time [s].
        until: The stop time [s].
        remarks: What a person should know of them.
    """

    step: float
    start: float
    until: float
    remarks: tuple[str, ...]


def read_experiment(
    document: Document,
    annotation: ScenarioAnnotation | None,
    options: Options,
    suggestions: Mapping[str, SuggestedExperiment],
) -> DefaultExperiment:
    """The experiment of a description; the findings get what is wrong with it.

    Args:
        document: The description.
        annotation: The annotation of this program, if there is one.
        options: The times that replace those of the file.
        suggestions: What the units suggest where the file says nothing.
    """
    findings = document.findings
    remarks: tuple[str, ...] = ()
    node = document.root.find(qualified(SSD, Tag.DEFAULT_EXPERIMENT))
    start = until = None
    if node is not None:
        start, until = (number(document, node, name) for name in (Attribute.START_TIME, Attribute.STOP_TIME))
    start = (start or 0.0) if options.start_time is None else options.start_time
    until = until if options.stop_time is None else options.stop_time
    if until is None:
        where = document.at(document.root if node is None else node)
        findings.add_problem(where, "no stop time", "a number of seconds", "Say how long with --stop-time.")
    step = options.step
    if step is None:
        step = annotation.step if annotation else _hinted_step(document)
    if step is None:
        step, why = suggested_step(suggestions)
        remarks = (f"the SSP says no macro step: {step:g} s is used{why and ', '}{why}; --step changes it",)
        if until is not None and options.stop_time is None:
            until, cut = whole_steps(start, step, until)
            remarks += cut
    return DefaultExperiment(findings.attempt(lambda: macro_step(step)) or STEP, start, until or 0.0, remarks)


def _hinted_step(document: Document) -> float | None:
    for tag, attribute in _STEP_HINTS:
        for node in document.root.iterfind(f".//{{*}}{tag}"):
            if (step := number(document, node, attribute)) is not None and step > 0:
                return step
    return None


def add_experiment(root: Node, h: float, start: float, until: float) -> None:
    """Add the experiment to a description; the macro step, which SSP has no place for, stands where libcosim reads it.

    Args:
        root: The root element.
        h: The macro step [s].
        start: The start time [s].
        until: The stop time [s].
    """
    times = {Attribute.START_TIME: f"{start!r}" if start else "0", Attribute.STOP_TIME: repr(until)}
    experiment = add(root, SSD, Tag.DEFAULT_EXPERIMENT, times)
    algorithm = add(new_annotation(experiment, OSP_ANNOTATION_TYPE), OSP, Tag.ALGORITHM)
    add(algorithm, OSP, Tag.FIXED_STEP_ALGORITHM, {Attribute.BASE_STEP_SIZE: repr(h)})


def add_step_hint(component: Node, step: float) -> None:
    """Add the step [s] of a component, where libcosim reads it."""
    annotation = new_annotation(component, OSP_ANNOTATION_TYPE)
    add(annotation, OSP, Tag.STEP_SIZE_HINT, {Attribute.VALUE: repr(step)})


def new_annotation(parent: Node, kind: str) -> Node:
    """A new annotation of a type, as the only one of an element."""
    return add(add(parent, SSD, Tag.ANNOTATIONS), SSC, Tag.ANNOTATION, {Attribute.TYPE: kind})
