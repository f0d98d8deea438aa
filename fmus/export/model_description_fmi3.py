"""modelDescription.xml of FMI 3.0: arrays are variables with dimensions."""

from __future__ import annotations

import math
from collections.abc import Iterable

from lxml import etree

from components.interfaces.quantity import Type
from fmus.export import description_parts as parts
from fmus.export.dependencies import Dependencies
from fmus.export.fmi_variables import TIME_REFERENCE, FmiVariable, FmiVariables, SampleClock

_INITIAL = {"parameter": "exact", "input": "exact", "output": "calculated"}
_SECOND = "s"


def model_description_fmi3(depends: Dependencies, token: str) -> bytes:
    """The file.

    Args:
        depends: The variables and their dependencies.
        token: The instantiation token.
    """
    variables = depends.variables
    root = parts.root(variables, "3.0", "instantiationToken", token)
    _co_simulation(root, variables)
    units = list(dict.fromkeys([_SECOND, *parts.units_of_measurement(variables)]))
    parts.add_unit_definitions(root, units)
    _types(root, variables, units)
    parts.add_log_categories(root)
    parts.add_default_experiment(root)
    model_variables = etree.SubElement(root, "ModelVariables")
    _time(model_variables)
    for v in variables:
        _variable(model_variables, v)
    if variables.clock is not None:
        _clock(model_variables, variables.clock)
    _structure(root, depends)
    if not variables.sampled:
        annotations = etree.SubElement(root, "Annotations")
        parts.add_output_annotation(etree.SubElement(annotations, "Annotation", type=parts.ANNOTATION), variables)
    return parts.to_bytes(root)


def _co_simulation(root: parts.XmlElement, variables: FmiVariables) -> None:
    max_step = variables.block.max_step
    element = etree.SubElement(
        root,
        "CoSimulation",
        modelIdentifier=variables.block.name,
        canHandleVariableCommunicationStepSize="true",
        canBeInstantiatedOnlyOncePerProcess="false",
        canGetAndSetFMUState="true",
        canSerializeFMUState="true",
        providesDirectionalDerivatives="false",
        hasEventMode=parts.text(Type.BOOLEAN, variables.clock is not None),
    )
    if math.isfinite(max_step):
        element.set("fixedInternalStepSize", parts.number(max_step))


def _types(root: parts.XmlElement, variables: FmiVariables, units: Iterable[str]) -> None:
    definitions = etree.SubElement(root, "TypeDefinitions")
    for unit in units:
        name = parts.quantity_of(unit)
        etree.SubElement(definitions, "Float64Type", name=name, quantity=name, unit=unit)
    for enumeration in parts.enumerations(variables):
        name = enumeration.name
        parts.add_items(etree.SubElement(definitions, "EnumerationType", name=name, quantity=name), enumeration)


def _time(parent: parts.XmlElement) -> None:
    etree.SubElement(
        parent,
        "Float64",
        name="time",
        valueReference=str(TIME_REFERENCE),
        description="time of the communication point",
        causality="independent",
        variability="continuous",
        declaredType=parts.quantity_of(_SECOND),
        unit=_SECOND,
    )


def _variable(parent: parts.XmlElement, v: FmiVariable) -> None:
    element = etree.SubElement(
        parent,
        v.variable.quantity.type.value,
        {
            "name": v.name,
            "valueReference": str(v.reference),
            "description": v.variable.quantity.description,
            "causality": v.causality,
            "variability": v.variability,
            "initial": _INITIAL[v.causality],
            **parts.value_attributes(v, v.start),
        },
    )
    for length in v.variable.quantity.shape:
        etree.SubElement(element, "Dimension", start=str(length))


def _clock(parent: parts.XmlElement, clock: SampleClock) -> None:
    """The clock, without clocked variables, so that importers without Event Mode can use the FMU.

    The variables of a sampled block have no attribute `clocks`, because FMI 3.0 makes two demands that would exclude
    each other otherwise: "clocked variables can acquire new values and can be queried only when their Clock is
    active, except during InitializationMode" (2.2.9.3 Model Partitions and Clocked Variables), hence never in Step
    Mode; and an importer without Event Mode, which has nothing but Step Mode, instantiates with eventModeUsed =
    fmi3False "to force the FMU to detect and handle events internally" (4.4, hasEventMode). As plain discrete
    variables the outputs can be read in both cases, and they hold from one tick to the next. runtime/fmi3_events.c
    says which kind of periodic clock it is, and why.
    """
    etree.SubElement(
        parent,
        "Clock",
        name=clock.name,
        valueReference=str(clock.reference),
        description=clock.description,
        causality="input",
        variability="discrete",
        intervalVariability="fixed",
        intervalDecimal=parts.number(clock.interval),
    )


def _structure(root: parts.XmlElement, depends: Dependencies) -> None:
    """Outputs and initial unknowns; an array depends on everything that any of its elements depends on."""
    variables = depends.variables
    structure = etree.SubElement(root, "ModelStructure")
    by_inputs: dict[int, list[int]] = {}
    by_parameters: dict[int, list[int]] = {}
    for output in variables.outputs:
        on = depends.of(output, range(output.variable.size))
        by_inputs[output.reference] = [v.reference for v in variables.inputs if on(v)]
        by_parameters[output.reference] = [v.reference for v in variables.parameters if on(v)]
    for reference, inputs in by_inputs.items():
        _unknown(structure, "Output", reference, inputs)
    for reference, inputs in by_inputs.items():
        _unknown(structure, "InitialUnknown", reference, by_parameters[reference] + inputs)


def _unknown(parent: parts.XmlElement, tag: str, reference: int, dependencies: Iterable[int]) -> None:
    listed = " ".join(map(str, dependencies))
    etree.SubElement(parent, tag, valueReference=str(reference), dependencies=listed)
