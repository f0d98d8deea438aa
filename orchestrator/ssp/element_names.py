"""The version of SSP for a system, and the names in it: FMI 2.0 knows no arrays, only scalars such as `x[2]`."""

from __future__ import annotations

from orchestrator.ssp.vocabulary import SspVersion
from orchestrator.system.connection import Connection
from orchestrator.system.source import UnitSource
from orchestrator.system.system import System


def is_fmi2(system: System) -> bool:
    """Whether all units are FMI 2.0 FMUs without a mapping."""
    return all(source.is_fmi2 for source in system.units.values())


def ssp_version(system: System) -> SspVersion:
    """The first version of SSP that can express a system: SSP 1.0 cannot express what FMI 3.0 adds."""
    return SspVersion.SSP1 if is_fmi2(system) else SspVersion.SSP2


def element_names(source: UnitSource, name: str, role: str, *, flat: bool) -> list[str]:
    """The names of a variable in a file.

    Args:
        source: The source of the unit.
        name: The variable.
        role: `inputs`, `outputs`, `parameters` or `initials`.
        flat: Whether arrays are written element by element, as FMI 2.0 has them.

    Returns:
        The name of the variable; of a flat array the names of all its elements, spelled as in the FMU.
    """
    variable = source.interface.variable(role, name)
    return [*source.element_names(variable, role)] if flat and variable.shape else [name]


def connected_names(system: System, connection: Connection, *, flat: bool) -> list[tuple[str, str]]:
    """The names of the output and the input of a connection; one pair for each element where arrays are flat."""
    outputs = element_names(system.units[connection.source], connection.output, "outputs", flat=flat)
    inputs = element_names(system.units[connection.unit], connection.input, "inputs", flat=flat)
    if flat and connection.output_element is not None:
        outputs = [outputs[connection.output_element.at]]
    if flat and connection.input_element is not None:
        inputs = [inputs[connection.input_element.at]]
    return list(zip(outputs, inputs, strict=True))
