"""modelDescription.xml of FMI 3.0: arrays are variables with dimensions."""

from __future__ import annotations

import math
from collections.abc import Iterable

from lxml import etree

from components.interfaces.quantity import Type
from fmus.export import description_parts as parts
from fmus.export.dependencies import Dependencies
from fmus.export.fmi_variables import TIME_REFERENCE, Clock, FmiVariable, Interface

_INITIAL = {"parameter": "exact", "input": "exact", "output": "calculated"}
_SECOND = "s"


def model_description_fmi3(depends: Dependencies, token: str) -> bytes:
    """The file."""
    interface = depends.interface
    root = parts.root(interface, "3.0", "instantiationToken", token)
    _co_simulation(root, interface)
    units = list(dict.fromkeys([_SECOND, *parts.units(interface)]))
    parts.add_units(root, units)
    _types(root, interface, units)
    parts.add_log_categories(root)
    parts.add_default_experiment(root)
    variables = etree.SubElement(root, "ModelVariables")
    _time(variables)
    for v in interface:
        _variable(variables, v)
    if interface.clock is not None:
        _clock(variables, interface.clock)
    _structure(root, depends)
    if not interface.sampled:
        annotations = etree.SubElement(root, "Annotations")
        parts.add_promise(etree.SubElement(annotations, "Annotation", type=parts.ANNOTATION), interface)
    return parts.to_bytes(root)


def _co_simulation(root: parts.Element, interface: Interface) -> None:
    max_step = interface.block.max_step
    element = etree.SubElement(
        root,
        "CoSimulation",
        modelIdentifier=interface.block.name,
        canHandleVariableCommunicationStepSize="true",
        canBeInstantiatedOnlyOncePerProcess="false",
        canGetAndSetFMUState="true",
        canSerializeFMUState="true",
        providesDirectionalDerivatives="false",
        hasEventMode=parts.text(Type.BOOLEAN, interface.clock is not None),
    )
    if math.isfinite(max_step):
        element.set("fixedInternalStepSize", parts.number(max_step))


def _types(root: parts.Element, interface: Interface, units: Iterable[str]) -> None:
    definitions = etree.SubElement(root, "TypeDefinitions")
    for unit in units:
        name = parts.quantity_of(unit)
        etree.SubElement(definitions, "Float64Type", name=name, quantity=name, unit=unit)
    for kind in parts.enumerations(interface):
        enumeration = etree.SubElement(definitions, "EnumerationType", name=kind.__name__, quantity=kind.__name__)
        parts.add_items(enumeration, kind)


def _time(parent: parts.Element) -> None:
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


def _variable(parent: parts.Element, v: FmiVariable) -> None:
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


def _clock(parent: parts.Element, clock: Clock) -> None:
    """The clock alone, without clocked variables, so that importers without event mode can use the FMU.

    The variables of a sampled block carry no attribute `clocks`. FMI 3.0 asks for two things that exclude each other
    otherwise: "clocked variables can acquire new values and can be queried only when their Clock is active, except
    during InitializationMode" (2.2.9.3 Model Partitions and Clocked Variables), hence never in Step Mode; and an
    importer without event mode, which knows nothing but Step Mode, instantiates with eventModeUsed = fmi3False "to
    force the FMU to detect and handle events internally" (4.4, hasEventMode). As plain discrete variables the outputs
    can be read in both cases, and hold from one tick to the next. Which kind of periodic clock it is, and why, stands
    in runtime/fmi3_events.c.
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


def _structure(root: parts.Element, depends: Dependencies) -> None:
    """Outputs and initial unknowns; an array depends on all that any of its elements depends on."""
    interface = depends.interface
    structure = etree.SubElement(root, "ModelStructure")
    by_inputs: dict[int, list[int]] = {}
    by_parameters: dict[int, list[int]] = {}
    for output in interface.outputs:
        on = depends.of(output, range(output.variable.size))
        by_inputs[output.reference] = [v.reference for v in interface.inputs if on(v)]
        by_parameters[output.reference] = [v.reference for v in interface.parameters if on(v)]
    for reference, found in by_inputs.items():
        _unknown(structure, "Output", reference, found)
    for reference, found in by_inputs.items():
        _unknown(structure, "InitialUnknown", reference, by_parameters[reference] + found)


def _unknown(parent: parts.Element, kind: str, reference: int, dependencies: Iterable[int]) -> None:
    listed = " ".join(map(str, dependencies))
    etree.SubElement(parent, kind, valueReference=str(reference), dependencies=listed)
