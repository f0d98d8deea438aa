"""The functions of FMI that a run calls of the library of an FMU; the others may be absent."""
# pyright: basic
# FMPy carries few types; everything that leaves this file is annotated.

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, Final

from components.interfaces.quantity import Type
from components.interfaces.record import Variable
from fmus.reading.archive import Archive
from fmus.toolchain.fmpy_library import (
    FMU1Model,
    FMU1Slave,
    FMU2Model,
    FMU2Slave,
    FMU3Model,
    FMU3Slave,
    required_functions,
)
from fmus.toolchain.version import Version
from fmus.unit_interface import Interface

_LIFE: Final = {
    Version.FMI1: (),
    Version.FMI2: (
        "Instantiate",
        "SetupExperiment",
        "EnterInitializationMode",
        "ExitInitializationMode",
        "Terminate",
        "FreeInstance",
    ),
    Version.FMI3: ("EnterInitializationMode", "ExitInitializationMode", "Terminate", "FreeInstance"),
}
_CO_SIMULATION: Final = {
    Version.FMI1: ("InstantiateSlave", "InitializeSlave", "DoStep", "TerminateSlave", "FreeSlaveInstance"),
    Version.FMI2: ("DoStep",),
    Version.FMI3: ("InstantiateCoSimulation", "DoStep"),
}
_EVENT_MODE: Final = ("EnterEventMode", "UpdateDiscreteStates", "EnterStepMode")
_MODEL_EXCHANGE: Final = {
    Version.FMI1: ("InstantiateModel", "Initialize", "EventUpdate", "SetTime", "Terminate", "FreeModelInstance"),
    Version.FMI2: ("EnterEventMode", "NewDiscreteStates", "EnterContinuousTimeMode", "SetTime"),
    Version.FMI3: (
        "InstantiateModelExchange",
        "EnterEventMode",
        "UpdateDiscreteStates",
        "EnterContinuousTimeMode",
        "SetTime",
        "GetNumberOfContinuousStates",
        "GetNumberOfEventIndicators",
    ),
}
_STATES: Final = {
    Version.FMI1: ("SetContinuousStates", "GetContinuousStates", "GetDerivatives", "GetNominalContinuousStates"),
    Version.FMI2: ("SetContinuousStates", "GetContinuousStates", "GetDerivatives", "GetNominalsOfContinuousStates"),
    Version.FMI3: (
        "SetContinuousStates",
        "GetContinuousStates",
        "GetContinuousStateDerivatives",
        "GetNominalsOfContinuousStates",
    ),
}
_ROLL_BACK: Final = {
    Version.FMI1: (),
    Version.FMI2: ("GetFMUstate", "SetFMUstate", "FreeFMUstate"),
    Version.FMI3: ("GetFMUState", "SetFMUState", "FreeFMUState"),
}
_FMI2_TYPES: Final = {
    Type.FLOAT64: "Real",
    Type.INT32: "Integer",
    Type.ENUMERATION: "Integer",
    Type.BOOLEAN: "Boolean",
    Type.STRING: "String",
}


def all_functions(archive: Archive) -> list[str]:
    """All functions that FMI demands of the library of an FMU with the interface type that is used."""
    classes = {
        Version.FMI1: (FMU1Slave, FMU1Model),
        Version.FMI2: (FMU2Slave, FMU2Model),
        Version.FMI3: (FMU3Slave, FMU3Model),
    }
    return required_functions(classes[archive.version][archive.is_model_exchange], archive.version)


def known_function(version: Version) -> str:
    """A function that the library of every FMU offers, by which a prefix of its names is recognised."""
    return f"{function_names(version)}GetReal" if version == Version.FMI1 else f"fmi{version}FreeInstance"


def function_names(version: Version) -> str:
    """How the names of all functions begin; in FMI 1.0 the model identifier stands before it."""
    return "fmi" if version == Version.FMI1 else f"fmi{version}"


def needed_functions(archive: Archive) -> frozenset[str]:
    """Those that a run calls of the library of an FMU with the interface type that is used."""
    model, version, interface = archive.description, archive.version, archive.interface
    names = [*_LIFE[version], *_access(version, interface)]
    if not archive.is_model_exchange:
        names += _CO_SIMULATION[version]
        names += _EVENT_MODE if interface.event_mode else ()
        names += _ROLL_BACK[version] if interface.rolls_back else ()
    else:
        names += _MODEL_EXCHANGE[version]
        names += _STATES[version] if model.numberOfContinuousStates else ()
        names += ("GetEventIndicators",) if model.numberOfEventIndicators else ()
        names += ("CompletedIntegratorStep",) if _notified(model.modelExchange) else ()
    return frozenset(f"{function_names(version)}{name}" for name in names)


def _notified(model_exchange: Any) -> bool:
    """Whether the FMU has to be notified of each step of the integrator."""
    return bool(model_exchange.needsCompletedIntegratorStep)


def _access(version: Version, interface: Interface) -> Iterable[str]:
    for verb, variables in (("Set", (*interface.inputs, *interface.parameters)), ("Get", interface.outputs)):
        yield from (f"{verb}{_type_name(variable, version)}" for variable in variables)


def _type_name(variable: Variable, version: Version) -> Any:
    kind = variable.quantity.type
    if version != Version.FMI3:
        return _FMI2_TYPES[kind]
    return "Int64" if kind is Type.ENUMERATION else kind.value
