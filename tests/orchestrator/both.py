"""An FMU with both interface types: `x` counts the steps as Co-Simulation, and is the time as Model Exchange."""

from __future__ import annotations

from pathlib import Path

from fmus.toolchain.version import Version
from tests.fmus.foreign import description2, description3, library, pack, scalar

CO_SIMULATION = '<CoSimulation modelIdentifier="m" canHandleVariableCommunicationStepSize="true"/>'
MODEL_EXCHANGE = '<ModelExchange modelIdentifier="m"/>'


def both(path: Path, version: Version, interfaces: str = MODEL_EXCHANGE + CO_SIMULATION) -> Path:
    """The FMU, or one that declares only some of its interface types."""
    if version is Version.FMI2:
        variables = [
            scalar("x", 0, "output", initial="exact", of_start="0"),
            scalar("der(x)", 1, "local", of_derivative="1"),
        ]
        derivatives = ['<Unknown index="2" dependencies=""/>']
        text = description2(
            variables,
            ['<Unknown index="1" dependencies=""/>'],
            interface=interfaces,
            derivatives=derivatives,
            initial=derivatives,
        )
    else:
        variables = [
            '<Float64 name="x" valueReference="1" causality="output" initial="exact" start="0"/>',
            '<Float64 name="der(x)" valueReference="2" derivative="1"/>',
        ]
        structure = ['<Output valueReference="1" dependencies=""/>', '<ContinuousStateDerivative valueReference="2"/>']
        structure += ['<InitialUnknown valueReference="2"/>']
        text = description3(variables, structure, interface=interfaces)
    return pack(path, version, text, library(path.parent / f"both{version}", version, f'#include "both{version}.c"'))
