"""The C interface of each version of FMI, as far as the units call it: one description per version, as data."""
# pyright: basic
# FMPy carries few types; everything that leaves this file is annotated.

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final, NamedTuple

import numpy as np

from components.interfaces.quantity import DTYPES, Type
from fmus.toolchain.fmpy_library import FMU1Model, FMU1Slave, FMU2Model, FMU2Slave, FMU3Model, FMU3Slave


class NativeAccess(NamedTuple):
    """How values of one type are passed to and from a library."""

    function: str
    """The part of the access functions' names after `Get` or `Set`."""
    dtype: type[np.generic]
    """How the library stores a value."""


@dataclass(frozen=True)
class FmiApi:
    """The differences between the versions of FMI for a caller of the functions of a library."""

    prefix: str
    """The beginning of all function names."""
    co_simulation: type[Any]
    """FMPy's class for a Co-Simulation FMU."""
    model_exchange: type[Any]
    """FMPy's class for a Model Exchange FMU."""
    access: Mapping[Type, NativeAccess]
    """The access to values by type, for the types of this version of FMI."""
    counts_values: bool
    """Whether access functions take the number of values in addition to that of the variables."""
    get_state: str
    """FMPy's name of the function that saves the FMU state."""
    set_state: str
    free_state: str
    token: str
    """The name of the text by which a library recognises its modelDescription.xml, in this version of FMI."""


FMI1_API: Final = FmiApi(
    prefix="fmi",
    co_simulation=FMU1Slave,
    model_exchange=FMU1Model,
    access={
        Type.FLOAT64: NativeAccess("Real", np.float64),
        Type.INT32: NativeAccess("Integer", np.int32),
        Type.BOOLEAN: NativeAccess("Boolean", np.int8),
        Type.ENUMERATION: NativeAccess("Integer", np.int32),
        Type.STRING: NativeAccess("String", np.object_),
    },
    counts_values=False,
    get_state="",  # FMI 1.0 saves no states
    set_state="",
    free_state="",
    token="GUID",  # noqa: S106 - no secret
)
FMI2_API: Final = FmiApi(
    prefix="fmi2",
    co_simulation=FMU2Slave,
    model_exchange=FMU2Model,
    access={
        Type.FLOAT64: NativeAccess("Real", np.float64),
        Type.INT32: NativeAccess("Integer", np.int32),
        Type.BOOLEAN: NativeAccess("Boolean", np.int32),
        Type.ENUMERATION: NativeAccess("Integer", np.int32),
        Type.STRING: NativeAccess("String", np.object_),
    },
    counts_values=False,
    get_state="getFMUstate",
    set_state="setFMUstate",
    free_state="freeFMUstate",
    token="GUID",  # noqa: S106 - no secret
)
FMI3_API: Final = FmiApi(
    prefix="fmi3",
    co_simulation=FMU3Slave,
    model_exchange=FMU3Model,
    access={
        **{kind: NativeAccess(kind.value, dtype) for kind, dtype in DTYPES.items()},
        Type.ENUMERATION: NativeAccess("Int64", np.int64),
    },
    counts_values=True,
    get_state="getFMUState",
    set_state="setFMUState",
    free_state="freeFMUState",
    token="token",  # noqa: S106 - no secret
)
