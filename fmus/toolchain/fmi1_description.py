"""Descriptions of FMI 1.0 in the words of FMI 2.0: what FMPy leaves out is added to its objects.

FMI 1.0 has no model structure, but names at each output the inputs that it depends on directly. It has no `initial`: a
variable with a start value may be set before the initialisation, and a parameter without one is computed by the FMU.
Its Co-Simulation FMUs tell their capabilities in an element of their own.
"""
# pyright: basic
# FMPy carries few types; everything that leaves this file is annotated.

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

_TRUE: Final = {"true", "1"}
_CAPABILITIES: Final = (
    "canHandleVariableCommunicationStepSize",
    "canInterpolateInputs",
    "canBeInstantiatedOnlyOncePerProcess",
    "canNotUseMemoryManagementFunctions",
)


def complete(model: Any, root: Any, unknown: Callable[..., Any]) -> None:
    """Add to a description what FMPy leaves out.

    Args:
        model: FMPy's objects.
        root: The root element of the description.
        unknown: FMPy's class for an output and what it depends on.

    Raises:
        LookupError: An output depends on a variable that is not there.
    """
    for variable in model.modelVariables:
        if variable.causality == "none":
            variable.causality = "local"
        if variable.causality == "parameter" and variable.start is None:
            variable.causality = "calculatedParameter"
        if variable.causality in {"output", "local"} and variable.start is not None:
            variable.initial = "exact"
    _connect_aliases(model, root)
    by_name = {variable.name: variable for variable in model.modelVariables}
    for element in root.iterfind("ModelVariables/ScalarVariable[@causality='output']"):
        dependency = element.find("DirectDependency")
        names = None if dependency is None else [(name.text or "").strip() for name in dependency.iterfind("Name")]
        dependencies = None if names is None else [by_name[name] for name in names]
        variable = by_name[element.get("name")]
        if variable.causality == "output":
            model.outputs.append(unknown(variable=variable, dependencies=dependencies, sourceline=element.sourceline))
    if model.coSimulation is None:
        model.modelExchange.needsCompletedIntegratorStep = True
        return
    for capabilities in root.iterfind("Implementation/*/Capabilities"):
        for name in _CAPABILITIES:
            setattr(model.coSimulation, name, capabilities.get(name) in _TRUE)
    model.coSimulation.needsExecutionTool = root.find("Implementation/CoSimulation_Tool") is not None


def negated_names(root: Any) -> frozenset[str]:
    """The names of the variables whose values are the negative ones of those of the library."""
    return frozenset(e.get("name") for e in root.iterfind("ModelVariables/ScalarVariable[@alias='negatedAlias']"))


def _connect_aliases(model: Any, root: Any) -> None:
    """Note at second names of a variable, other than outputs, the variable, so that it is not set twice."""
    elements = root.iterfind("ModelVariables/ScalarVariable[@alias]")
    second = {element.get("name") for element in elements if element.get("alias") != "noAlias"}
    first = {(v.type, v.valueReference): v for v in model.modelVariables if v.name not in second}
    for variable in model.modelVariables:
        if variable.name in second and variable.causality != "output":
            whole = first.get((variable.type, variable.valueReference))
            if whole is not None and variable.causality in {"local", "calculatedParameter", whole.causality}:
                variable.alias = whole
