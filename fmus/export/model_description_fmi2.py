"""modelDescription.xml of FMI 2.0: every array element is a ScalarVariable of its own."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from lxml import etree

from components.interfaces.quantity import Type
from fmus.export import description_parts as parts
from fmus.export.dependencies import Dependencies
from fmus.export.fmi_variables import FmiVariable, Interface

_ELEMENTS = {Type.FLOAT64: "Real", Type.INT32: "Integer", Type.BOOLEAN: "Boolean", Type.ENUMERATION: "Enumeration"}
_INITIAL: Mapping[str, Mapping[str, str]] = {
    "parameter": {"initial": "exact"},
    "input": {},
    "output": {"initial": "calculated"},
}


def model_description_fmi2(depends: Dependencies, token: str, sources: Iterable[str]) -> bytes:
    """The file. It names no `time`: FMI Library objects to an independent variable in FMI 2.0."""
    interface = depends.interface
    root = parts.root(interface, "2.0", "guid", token)
    _co_simulation(root, interface, sources)
    parts.add_units(root, parts.units(interface))
    _types(root, interface)
    parts.add_log_categories(root)
    parts.add_default_experiment(root)
    if not interface.sampled:
        annotations = etree.SubElement(root, "VendorAnnotations")
        parts.add_promise(etree.SubElement(annotations, "Tool", name=parts.ANNOTATION), interface)
    variables = etree.SubElement(root, "ModelVariables")
    for v in interface:
        _variable(variables, v)
    _structure(root, depends)
    return parts.to_bytes(root)


def _co_simulation(root: parts.Element, interface: Interface, sources: Iterable[str]) -> None:
    element = etree.SubElement(
        root,
        "CoSimulation",
        modelIdentifier=interface.block.name,
        canHandleVariableCommunicationStepSize="true",
        canBeInstantiatedOnlyOncePerProcess="false",
        canNotUseMemoryManagementFunctions="true",
        canGetAndSetFMUstate="true",
        canSerializeFMUstate="true",
        providesDirectionalDerivative="false",
    )
    files = etree.SubElement(element, "SourceFiles")
    for name in sources:
        etree.SubElement(files, "File", name=name)


def _types(root: parts.Element, interface: Interface) -> None:
    definitions = etree.SubElement(root, "TypeDefinitions")
    for unit in parts.units(interface):
        name = parts.quantity_of(unit)
        etree.SubElement(etree.SubElement(definitions, "SimpleType", name=name), "Real", quantity=name, unit=unit)
    for kind in parts.enumerations(interface):
        simple = etree.SubElement(definitions, "SimpleType", name=kind.__name__)
        parts.add_items(etree.SubElement(simple, "Enumeration", quantity=kind.__name__), kind)


def _variable(parent: parts.Element, v: FmiVariable) -> None:
    """One ScalarVariable for each element."""
    for k, (name, reference) in enumerate(zip(v.variable.elements, v.references, strict=True)):
        scalar = etree.SubElement(
            parent,
            "ScalarVariable",
            {
                "name": name,
                "valueReference": str(reference),
                "description": v.variable.quantity.description,
                "causality": v.causality,
                "variability": v.variability,
                **_INITIAL[v.causality],
            },
        )
        etree.SubElement(scalar, _ELEMENTS[v.variable.quantity.type], parts.value_attributes(v, v.start[k : k + 1]))


def _structure(root: parts.Element, depends: Dependencies) -> None:
    """Outputs and initial unknowns. The index of a variable, counted from 1, equals its value reference here."""
    interface = depends.interface
    structure = etree.SubElement(root, "ModelStructure")
    outputs = etree.SubElement(structure, "Outputs")
    initial = etree.SubElement(structure, "InitialUnknowns")
    for output in interface.outputs:
        for k, reference in enumerate(output.references):
            on = depends.of(output, range(k, k + 1))
            by_inputs = [v.reference + i for v in interface.inputs for i in on(v)]
            by_parameters = [v.reference + i for v in interface.parameters for i in on(v)]
            _unknown(outputs, reference, by_inputs)
            _unknown(initial, reference, by_parameters + by_inputs)


def _unknown(parent: parts.Element, index: int, dependencies: Iterable[int]) -> None:
    etree.SubElement(parent, "Unknown", index=str(index), dependencies=" ".join(map(str, dependencies)))
