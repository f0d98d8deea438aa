"""All that the project uses of FMPy; no other file imports it.

FMPy brings the C headers of FMI, the XML schemas of FMI and of SSP 1.0, a reader of model descriptions, a class for the
shared library of each kind of FMU, and SUNDIALS. Importing it takes a noticeable part of a second: a module that needs
this one in few of its functions only imports it there.

Some of what is used is no part of FMPy's public interface and has to be compared with each new version of FMPy:

* the package data in `c-code`, `schema`, `ssp/schema` and `logging`, by the names of folders and files;
* of an object of an FMU class: `dll`, the loaded library, whose functions are called directly in every step, and
  `component`, the pointer to the instance; FMI 3.0's classes take no path of the library (`required_functions` and
  `fmus.reading.library` say why that matters);
* the names of the methods of these classes, which tell the functions that FMPy expects of a library;
* FMPy's library that formats the log messages of FMI 2.0, with its function `addLoggerProxy`;
* the attributes of its solver that `Sundials` lists.
"""
# pyright: basic
# FMPy and ctypes carry few types; everything that leaves this file is annotated.

from __future__ import annotations

from collections.abc import Callable
from ctypes import CDLL
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import fmpy
from fmpy import calloc, free, freeLibrary, read_model_description
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import (
    FMU2Model,
    FMU2Slave,
    fmi2CallbackAllocateMemoryTYPE,
    fmi2CallbackFreeMemoryTYPE,
    fmi2CallbackFunctions,
    fmi2CallbackLoggerTYPE,
)
from fmpy.fmi3 import (
    FMU3Model,
    FMU3Slave,
    fmi3Error,
    fmi3Float64,
    fmi3IntervalChanged,
    fmi3IntervalQualifier,
    fmi3ValueReference,
)
from fmpy.model_description import ModelDescription
from fmpy.validation import validate_model_description
from lxml import etree

from fmus.toolchain.version import Version

if TYPE_CHECKING:
    from fmpy.sundials import CVodeSolver

__all__ = [
    "C_HEADERS",
    "FMI2_LOGGING_LIBRARY",
    "SSP_SCHEMAS",
    "FMICallException",
    "FMU2Model",
    "FMU2Slave",
    "FMU3Model",
    "FMU3Slave",
    "ModelDescription",
    "Sundials",
    "calloc",
    "description_schema",
    "fmi2CallbackAllocateMemoryTYPE",
    "fmi2CallbackFreeMemoryTYPE",
    "fmi2CallbackFunctions",
    "fmi2CallbackLoggerTYPE",
    "fmi3Error",
    "fmi3Float64",
    "fmi3IntervalChanged",
    "fmi3IntervalQualifier",
    "fmi3ValueReference",
    "free",
    "freeLibrary",
    "read_model_description",
    "required_functions",
    "ssp_schema",
    "sundials",
    "validate_model_description",
]

_PACKAGE: Final = Path(fmpy.__file__).parent
C_HEADERS: Final = _PACKAGE / "c-code"
"""The folder with the C headers of FMI, in which each carries its licence"""
SSP_SCHEMAS: Final = _PACKAGE / "ssp" / "schema"
"""The folder with the XML schemas of SSP 1.0"""
FMI2_LOGGING_LIBRARY: Final = _PACKAGE / "logging" / fmpy.platform / f"logging{fmpy.sharedLibraryExtension}"
"""The library that formats the log messages of FMI 2.0 and, after `addLoggerProxy`, hands them to one receiver.

It is not there for every platform.
"""


@cache
def description_schema(version: Version) -> etree.XMLSchema:
    """The schema of modelDescription.xml."""
    return etree.XMLSchema(file=str(_PACKAGE / "schema" / f"fmi{version}" / f"fmi{version}ModelDescription.xsd"))


@cache
def ssp_schema(name: str) -> etree.XMLSchema:
    """A schema of SSP 1.0, by the name of its file (`SystemStructureDescription.xsd`)."""
    return etree.XMLSchema(file=str(SSP_SCHEMAS / name))


def required_functions(fmu_class: type, version: Version) -> list[str]:
    """The functions of FMI that FMPy looks up in the library of an FMU: the names of the methods of its class."""
    prefix = f"fmi{version}"
    return [name for name in dir(fmu_class) if name.startswith(prefix) and name[len(prefix) :][:1].isupper()]


@dataclass(frozen=True)
class Sundials:
    """What FMPy gives of SUNDIALS: its solver, and the functions of the libraries that the solver does not offer.

    The subclass in `fmus.units.solver` uses, of the solver's attributes, `cvode_mem` (the integrator), `sunctx` (the
    context of SUNDIALS), `x` and `px` (the vector of the states and its values), `abstol`, `A` and `LS` (the other
    objects, which FMPy leaves to be freed), `ehfun_` and `error_info` (the error handler and what it was told), the
    counts `nx` and `nz`, `discrete` (there are no continuous states), and the callbacks `f` and `g`, which it extends.
    """

    CVodeSolver: type[CVodeSolver]
    """FMPy's class around one integrator"""
    CVode: Callable[..., int]
    """Integrate; the last argument says whether by one internal step or up to a time"""
    CV_ROOT_RETURN: int
    """The status when an event indicator has crossed zero"""
    NV_DATA_S: Callable[[Any], Any]
    """The values of a vector"""
    N_VDestroy_Serial: Callable[[Any], None]
    """Free a vector"""
    core: CDLL
    """The library with contexts, matrices and linear solvers"""
    cvode: CDLL
    """The library with the integrator"""


@cache
def sundials() -> Sundials:
    """SUNDIALS, whose shared libraries are loaded when it is first asked for."""
    from fmpy.sundials import CVodeSolver  # noqa: PLC0415
    from fmpy.sundials.cvode import CV_ROOT_RETURN, CVode  # noqa: PLC0415
    from fmpy.sundials.libraries import sundials_core, sundials_cvode  # noqa: PLC0415
    from fmpy.sundials.nvector_serial import NV_DATA_S, N_VDestroy_Serial  # noqa: PLC0415

    return Sundials(CVodeSolver, CVode, CV_ROOT_RETURN, NV_DATA_S, N_VDestroy_Serial, sundials_core, sundials_cvode)
