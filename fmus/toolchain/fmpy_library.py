"""All that the project uses of FMPy; no other file imports it.

FMPy brings the C headers of FMI, the XML schemas of FMI and of SSP 1.0, a reader of model descriptions, a class for the
shared library of each kind of FMU, and SUNDIALS. Importing it takes a noticeable part of a second: a module that needs
this one in few of its functions only imports it there.

Some of what is used is no part of FMPy's public interface and has to be compared with each new version of FMPy:

* the package data in `c-code`, `schema`, `ssp/schema` and `logging`, by the names of folders and files;
* of an object of an FMU class: `dll`, the loaded library, whose functions are called directly in every step, and
  `component`, the pointer to the instance;
* the names of the methods of these classes, which tell the functions that FMPy expects of a library
  (`required_functions`);
* FMPy's library that formats the log messages of FMI 2.0, with its function `addLoggerProxy`
  (`FMI2_LOGGING_LIBRARY`);
* the attributes of its solver (`Sundials`);
* the wording of its reports on model descriptions, which name the line of the file in their text only
  (`description_breaches`).
"""
# pyright: basic
# FMPy and ctypes carry few types; everything that leaves this file is annotated.

from __future__ import annotations

import re
import zipfile
from collections.abc import Callable
from ctypes import CDLL
from dataclasses import dataclass
from functools import cache
from io import BytesIO
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
    fmi2LastSuccessfulTime,
    fmi2Terminated,
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

from fmus.toolchain.archives import MODEL_DESCRIPTION
from fmus.toolchain.version import Version

if TYPE_CHECKING:
    from fmpy.sundials import CVodeSolver

__all__ = [
    "C_HEADERS",
    "FMI2_LOGGING_LIBRARY",
    "SSP_SCHEMAS",
    "DescriptionBreach",
    "FMICallException",
    "FMU2Model",
    "FMU2Slave",
    "FMU3Model",
    "FMU3Slave",
    "ModelDescription",
    "ModelDescriptionError",
    "Sundials",
    "as_phrase",
    "calloc",
    "description_breaches",
    "description_schema",
    "fmi2CallbackAllocateMemoryTYPE",
    "fmi2CallbackFreeMemoryTYPE",
    "fmi2CallbackFunctions",
    "fmi2CallbackLoggerTYPE",
    "fmi2LastSuccessfulTime",
    "fmi2Terminated",
    "fmi3Error",
    "fmi3Float64",
    "fmi3IntervalChanged",
    "fmi3IntervalQualifier",
    "fmi3ValueReference",
    "free",
    "freeLibrary",
    "read_model",
    "required_functions",
    "ssp_schema",
    "sundials",
]

_PACKAGE: Final = Path(fmpy.__file__).parent
C_HEADERS: Final = _PACKAGE / "c-code"
"""The folder with the C headers of FMI, in which each carries its licence."""
SSP_SCHEMAS: Final = _PACKAGE / "ssp" / "schema"
"""The folder with the XML schemas of SSP 1.0."""
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


class ModelDescriptionError(ValueError):
    """FMPy cannot read a model description; the message, one line, says why."""


_LIST: Final = re.compile(rb"\b(dependencies|dependenciesKind|clocks)(\s*=\s*)(\"[^\"]*\"|'[^']*')")


def read_model(content: bytes, version: Version) -> ModelDescription:
    """FMPy's objects for a model description, whose rules it does not check here.

    Lists are given to FMPy with single blanks between their items, and later versions 2.x as 2.0, because it reads
    neither otherwise.

    Args:
        content: A modelDescription.xml that is well-formed.
        version: The version of FMI that it is read as.

    Raises:
        ModelDescriptionError: The description has values that FMPy does not expect.
    """
    content = _LIST.sub(lambda m: m[1] + m[2] + m[3][:1] + b" ".join(m[3][1:-1].split()) + m[3][:1], content)
    if version == Version.FMI2:
        content = re.sub(rb"(fmiVersion\s*=\s*[\"'])2\.0[^\"']*", rb"\g<1>2.0", content, count=1)
    packed = BytesIO()  # a separate archive, so that FMPy reads no file of the FMU that has not been checked
    with zipfile.ZipFile(packed, "w") as archive:
        archive.writestr(MODEL_DESCRIPTION, content)
    try:
        return read_model_description(packed, validate=False)
    except Exception as error:  # FMPy raises bare Exception, and whatever Python raises on values it does not expect
        reason = f"{type(error).__name__}: {error}" if isinstance(error, LookupError | TypeError) else str(error)
        raise ModelDescriptionError(as_phrase(reason)) from error


@dataclass(frozen=True)
class DescriptionBreach:
    """A rule of FMI that a model description breaks."""

    report: str
    """FMPy's report in one line."""
    found: str
    """The report without the line of the file."""
    line: int | None
    """The line of modelDescription.xml, where FMPy names one."""
    concerns_variability: bool
    """Whether the breach is a variability that the variable's type does not allow."""


def description_breaches(model: ModelDescription, *, with_structure: bool) -> list[DescriptionBreach]:
    """The rules of FMI that FMPy finds broken.

    Args:
        model: The description, as `read_model` gives it.
        with_structure: Whether the model structure has to be complete.
    """
    return [_breach(text) for text in validate_model_description(model, validate_model_structure=with_structure)]


def _breach(text: str) -> DescriptionBreach:
    match = re.search(r" \(line (\d+)\)", text)
    return DescriptionBreach(
        report=as_phrase(text),
        found=as_phrase(text if match is None else text[: match.start()] + text[match.end() :]),
        line=None if match is None else int(match[1]),
        concerns_variability="must have variability" in text,
    )


def as_phrase(text: str) -> str:
    """A message of FMPy or of libxml2 as a part of one of ours: in one line, without full stop and quotation marks."""
    return " ".join(text.split()).rstrip(".").replace('"', "`")


def required_functions(fmu_class: type, version: Version) -> list[str]:
    """The functions of FMI that FMPy looks up in the library of an FMU: the names of the methods of its class."""
    prefix = f"fmi{version}"
    return [name for name in dir(fmu_class) if name.startswith(prefix) and name[len(prefix) :][:1].isupper()]


@dataclass(frozen=True)
class Sundials:
    """The parts of SUNDIALS that FMPy provides: its solver, and library functions that the solver does not offer.

    The subclass in `fmus.units.cvode_integrator` uses, of the solver's attributes, `cvode_mem` (the integrator),
    `sunctx` (the context of SUNDIALS), `x` and `px` (the vector of the states and its values), `abstol`, `A` and `LS`
    (the other objects, which FMPy leaves to be freed), `ehfun_` and `error_info` (the error handler and the last
    error), the counts `nx` and `nz`, `discrete` (there are no continuous states), and the callbacks `f` and `g`, which
    it extends.
    """

    CVodeSolver: type[CVodeSolver]
    """FMPy's class around one integrator."""
    CVode: Callable[..., int]
    """Integrate; the last argument says whether by one internal step or up to a time."""
    CV_ROOT_RETURN: int
    """The status when an event indicator has crossed zero."""
    NV_DATA_S: Callable[[Any], Any]
    """The values of a vector."""
    N_VDestroy_Serial: Callable[[Any], None]
    """Free a vector."""
    core: CDLL
    """The library with contexts, matrices and linear solvers."""
    cvode: CDLL
    """The library with the integrator."""


@cache
def sundials() -> Sundials:
    """SUNDIALS, whose shared libraries are loaded when it is first asked for."""
    from fmpy.sundials import CVodeSolver  # noqa: PLC0415
    from fmpy.sundials.cvode import CV_ROOT_RETURN, CVode  # noqa: PLC0415
    from fmpy.sundials.libraries import sundials_core, sundials_cvode  # noqa: PLC0415
    from fmpy.sundials.nvector_serial import NV_DATA_S, N_VDestroy_Serial  # noqa: PLC0415

    return Sundials(CVodeSolver, CVode, CV_ROOT_RETURN, NV_DATA_S, N_VDestroy_Serial, sundials_core, sundials_cvode)
