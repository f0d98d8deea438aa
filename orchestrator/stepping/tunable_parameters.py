"""Parameters that may be changed while a system runs, as their units declare them."""

from __future__ import annotations

from typing import Any

import numpy as np

from components.interfaces.problem import choices, refuse
from components.interfaces.record import Variable
from orchestrator.system.system import System


def is_parameter(system: System, path: str) -> bool:
    """Whether a full path names a parameter of a unit."""
    unit, _, name = path.partition(".")
    return unit in system.units and any(v.name == name for v in system.units[unit].interface.parameters)


def tunable_paths(system: System) -> list[str]:
    """The full paths of all parameters that may be changed while the system runs."""
    return [f"{unit}.{name}" for unit, source in system.units.items() for name in sorted(source.interface.tunable)]


def tunable_parameter(system: System, path: str) -> Variable:
    """A parameter that may be changed while the system runs.

    Args:
        system: The system.
        path: The full path of a parameter.

    Raises:
        RequestError: It may not.
    """
    unit, _, name = path.partition(".")
    tunable = system.units[unit].interface.tunable
    if name not in tunable:
        valid = f"an input, or a tunable parameter of `{unit}`: {choices(tunable)}"
        remedy = f"Set it before the run: --set {path}=VALUE."
        raise refuse(path, "a parameter that is fixed while the system runs", valid, remedy)
    return system.variable(path, role="parameters")


def value_at_start(system: System, path: str) -> Any:
    """The value that a parameter has from the start of a run.

    Args:
        system: The system.
        path: The full path of the parameter.
    """
    unit, _, name = path.partition(".")
    source = system.units[unit]
    value = source.parameters.get(name, source.interface.starts.get(name))
    variable = system.variable(path, role="parameters")
    return np.resize(np.array(value, dtype=object), variable.shape).tolist() if variable.shape else value
