"""modelDescription.xml of FMI 2.0: each element of an array is a ScalarVariable."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from lxml import etree

from components.interfaces.quantity import Type
from fmus.export import description_parts as parts
from fmus.export.dependencies import Dependencies
from fmus.export.fmi_variables import FmiVariable, FmiVariables

_ELEMENTS = {Type.FLOAT64: "Real", Type.INT32: "Integer", Type.BOOLEAN: "Boolean", Type.ENUMERATION: "Enumeration"}
_INITIAL: Mapping[str, Mapping[str, str]] = {
    "parameter": {"initial": "exact"},
    "input": {},
    "output": {"initial": "calculated"},
}


def model_description_fmi2(depends: Dependencies, token: str, sources: Iterable[str]) -> bytes:
    """The file. It declares no independent variable, because FMI Library reports an error for one in FMI 2.0.

    Args:
        depends: The variables and their dependencies.
        token: The GUID.
        sources: The names of the C files that are compiled.
    """
    variables = depends.variables
    root = parts.root(variables, "2.0", "guid", token)
    _co_simulation(root, variables, sources)
    parts.add_unit_definitions(root, parts.units_of_measurement(variables))
    _types(root, variables)
    parts.add_log_categories(root)
    parts.add_default_experiment(root)
    if not variables.sampled:
        annotations = etree.SubElement(root, "VendorAnnotations")
        parts.add_output_annotation(etree.SubElement(annotations, "Tool", name=parts.ANNOTATION), variables)
    model_variables = etree.SubElement(root, "ModelVariables")
    for v in variables:
        _variable(model_variables, v)
    _structure(root, depends)
    return parts.to_bytes(root)


def _co_simulation(root: parts.XmlElement, variables: FmiVariables, sources: Iterable[str]) -> None:
    element = etree.SubElement(
        root,
        "CoSimulation",
        modelIdentifier=variables.block.name,
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


def _types(root: parts.XmlElement, variables: FmiVariables) -> None:
    definitions = etree.Element("TypeDefinitions")
    for unit in parts.units_of_measurement(variables):
        name = parts.quantity_of(unit)
        etree.SubElement(etree.SubElement(definitions, "SimpleType", name=name), "Real", quantity=name, unit=unit)
    for enumeration in parts.enumerations(variables):
        simple = etree.SubElement(definitions, "SimpleType", name=enumeration.name)
        parts.add_items(etree.SubElement(simple, "Enumeration", quantity=enumeration.name), enumeration)
    parts.add_if_filled(root, definitions)


def _variable(parent: parts.XmlElement, v: FmiVariable) -> None:
    """A ScalarVariable for each element."""
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


def _structure(root: parts.XmlElement, depends: Dependencies) -> None:
    """Outputs and initial unknowns, by index: counted from 1, it equals the value reference in these files."""
    variables = depends.variables
    structure = etree.SubElement(root, "ModelStructure")
    outputs = etree.SubElement(structure, "Outputs")
    initial = etree.SubElement(structure, "InitialUnknowns")
    for output in variables.outputs:
        for k, reference in enumerate(output.references):
            on = depends.of(output, range(k, k + 1))
            by_inputs = [v.reference + i for v in variables.inputs for i in on(v)]
            by_parameters = [v.reference + i for v in variables.parameters for i in on(v)]
            _unknown(outputs, reference, by_inputs)
            _unknown(initial, reference, by_parameters + by_inputs)


def _unknown(parent: parts.XmlElement, index: int, dependencies: Iterable[int]) -> None:
    etree.SubElement(parent, "Unknown", index=str(index), dependencies=" ".join(map(str, dependencies)))
