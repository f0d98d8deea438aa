"""Writing the values of a unit as a parameter set of SSP (SSV)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from components.interfaces.quantity import Quantity
from components.interfaces.record import Variable
from orchestrator.ssp.element_names import element_names, ssp_version
from orchestrator.ssp.types import add_dimensions, add_type
from orchestrator.ssp.vocabulary import SSC, SSV, Attribute, SspVersion, Tag
from orchestrator.ssp.xml import Node, add, add_units, literal, new_root
from orchestrator.system.experiment import Scenario


def parameter_set(scenario: Scenario, unit: str) -> Node:
    """The values of a unit's parameters, of its other start values, and of its inputs that nothing drives."""
    source, version = scenario.system.units[unit], ssp_version(scenario.system)
    ssp1 = version is SspVersion.SSP1
    root = new_root(SSV, Tag.PARAMETER_SET, SSC)
    root.set(Attribute.VERSION, version)
    root.set(Attribute.NAME, scenario.name)
    parameters = add(root, SSV, Tag.PARAMETERS)
    held = scenario.system.held_by(unit)
    quantities: list[Quantity] = []
    for role, values in (("parameters", source.parameters), ("initials", source.parameters), ("inputs", held)):
        for variable in (v for v in getattr(source.interface, role) if v.name in values):
            quantities.append(variable.quantity)
            scalars = np.asarray(values[variable.name], dtype=object).ravel()  # objects: bytes keep their zeros
            texts = [literal(x, variable.quantity) for x in scalars.tolist()]
            names = element_names(source, variable.name, role, flat=ssp1)
            origin = str(scenario.sources.get(f"{unit}.{variable.name}", {}).get("source", ""))
            for name, of_name in zip(names, [[text] for text in texts] if ssp1 else [texts], strict=True):
                parameter = add(parameters, SSV, Tag.PARAMETER, {Attribute.NAME: name})
                if origin:
                    parameter.set(Attribute.DESCRIPTION, origin)
                _add_value(parameter, variable, of_name, ssp1=ssp1)
    add_units(root, quantities, space=SSV)
    return root


def _add_value(parameter: Node, variable: Variable, texts: Sequence[str], *, ssp1: bool) -> None:
    typed = add_type(parameter, SSV, variable.quantity, ssp1=ssp1)
    if variable.quantity.type.is_number or ssp1:
        typed.set(Attribute.VALUE, " ".join(texts))
    else:
        for text in texts:
            add(typed, SSV, Tag.VALUE, {Attribute.VALUE: text})
    if not ssp1:
        add_dimensions(parameter, variable)
