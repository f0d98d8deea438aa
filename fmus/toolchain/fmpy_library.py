"""All that the project uses of FMPy; no other file imports it.

FMPy brings the C headers of FMI, the XML schemas of FMI and of SSP 1.0, a reader of model descriptions, a class for the
shared library of each kind of FMU, and SUNDIALS. Importing it takes a noticeable part of a second: a module that needs
this one in few of its functions only imports it there.

Some of what is used is no part of FMPy's public interface and has to be compared with each new version of FMPy:

* the package data in `c-code`, `schema`, `ssp/schema` and `logging`, by the names of folders and files;
* of an object of an FMU class: `dll`, the loaded library, whose functions are called directly in every step,
  `component`, the pointer to the instance, `_functions`, where its methods find those of FMI by their own names, and
  the other attributes that its constructor sets (`_Bound`);
* that it reads a model description with lxml's default parser (`_model`);
* the names of the methods of these classes, which tell the functions that FMPy expects of a library
  (`required_functions`);
* FMPy's library that formats the log messages of FMI 2.0, with its function `addLoggerProxy`
  (`FMI2_LOGGING_LIBRARY`);
* the attributes of its solver (`Sundials`);
* the wording of its reports on model descriptions, which name lines in their text only (`description_breaches`).
"""
# pyright: basic
# FMPy and ctypes carry few types; everything that leaves this file is annotated.

from __future__ import annotations

import zipfile
from collections.abc import Callable
from ctypes import CDLL
from dataclasses import dataclass
from functools import cache
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import fmpy
from fmpy import calloc, fmi1, fmi2, fmi3, free, freeLibrary, read_model_description
from fmpy.fmi1 import (
    FMICallException,
    fmi1CallbackAllocateMemoryTYPE,
    fmi1CallbackFreeMemoryTYPE,
    fmi1CallbackFunctions,
)
from fmpy.fmi2 import (
    fmi2CallbackAllocateMemoryTYPE,
    fmi2CallbackFreeMemoryTYPE,
    fmi2CallbackFunctions,
    fmi2CallbackLoggerTYPE,
    fmi2LastSuccessfulTime,
    fmi2Terminated,
)
from fmpy.fmi3 import (
    fmi3Error,
    fmi3Float64,
    fmi3IntervalChanged,
    fmi3IntervalQualifier,
    fmi3ValueReference,
)
from fmpy.model_description import ModelDescription, Unknown, ValidationError
from fmpy.validation import validate_fmu, validate_model_description
from lxml import etree

from fmus.toolchain.archives import MODEL_DESCRIPTION
from fmus.toolchain.description_breach import DescriptionBreach, as_phrase, breach_of
from fmus.toolchain.description_repair import contradictions_with_initial, named_version, separate_by_single_blanks
from fmus.toolchain.door import exception_in_words
from fmus.toolchain.fmi1_description import complete
from fmus.toolchain.function_library import BoundFunctions, FunctionLibrary
from fmus.toolchain.version import Version

if TYPE_CHECKING:
    from fmpy.sundials import CVodeSolver

__all__ = [
    "C_HEADERS",
    "FMI2_LOGGING_LIBRARY",
    "SSP_SCHEMAS",
    "FMICallException",
    "FMU1Model",
    "FMU1Slave",
    "FMU2Model",
    "FMU2Slave",
    "FMU3Model",
    "FMU3Slave",
    "ModelDescription",
    "ModelDescriptionError",
    "Sundials",
    "calloc",
    "description_breaches",
    "description_schema",
    "fmi1CallbackAllocateMemoryTYPE",
    "fmi1CallbackFreeMemoryTYPE",
    "fmi1CallbackFunctions",
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
    "validate_fmu",
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
    number = "" if version == Version.FMI1 else version
    return etree.XMLSchema(file=str(_PACKAGE / "schema" / f"fmi{version}" / f"fmi{number}ModelDescription.xsd"))


@cache
def ssp_schema(name: str) -> etree.XMLSchema:
    """A schema of SSP 1.0, by the name of its file (`SystemStructureDescription.xsd`)."""
    return etree.XMLSchema(file=str(SSP_SCHEMAS / name))


class ModelDescriptionError(ValueError):
    """FMPy cannot read a model description; the message, one line, says why."""


def read_model(root: Any, version: Version) -> ModelDescription:
    """FMPy's objects for a model description, whose rules it does not check here.

    FMPy is given the document that has been parsed already, with what it does not read otherwise: lists with single
    blanks between their items, later versions 2.x as 2.0, and an `initial` for variables whose causality and
    variability exclude each other.

    Args:
        root: The root element of a modelDescription.xml, which remains as it is but for the blanks.
        version: The version of FMI that it is read as.

    Raises:
        ModelDescriptionError: The description has values that FMPy does not expect.
    """
    separate_by_single_blanks(root)
    with named_version(root, "2.0" if version == Version.FMI2 else root.get("fmiVersion")):
        try:
            return _model(root)
        except ModelDescriptionError:
            with contradictions_with_initial(root) as contradicting:
                if not contradicting:
                    raise
                return _model(root)


def _model(root: Any) -> ModelDescription:
    class Parsed:
        """The target of a parser whose result is the document that has been parsed before."""

        def start(self, *_: Any) -> None: ...
        def end(self, *_: Any) -> None: ...
        def close(self) -> Any:
            return root.getroottree()

    packed = BytesIO()
    with zipfile.ZipFile(packed, "w") as archive:
        archive.writestr(MODEL_DESCRIPTION, "<empty/>")
    parser = etree.XMLParser(target=Parsed())  # pyright: ignore[reportArgumentType] - only a part of it is needed
    etree.set_default_parser(parser)  # FMPy uses lxml's default parser, one per thread
    try:
        model = read_model_description(packed, validate=False)
        if model.fmiVersion == "1.0":
            complete(model, root, Unknown)
    except Exception as error:  # FMPy raises bare Exception with a text for people, and Python the others
        deliberate = type(error) in {Exception, ValidationError} and str(error)
        raise ModelDescriptionError(as_phrase(str(error)) if deliberate else exception_in_words(error)) from error
    finally:
        etree.set_default_parser(None)
    return model


def description_breaches(model: ModelDescription, *, with_structure: bool) -> list[DescriptionBreach]:
    """The rules of FMI that FMPy finds broken.

    Args:
        model: The description, as `read_model` gives it.
        with_structure: Whether the model structure has to be complete.
    """
    units, texts = {unit.name for unit in model.unitDefinitions}, list[str]()
    for v in model.modelVariables:
        for shown in (v, *v.aliases):
            if shown.displayUnit is not None and (v.unit or (v.declaredType and v.declaredType.unit)) not in units:
                line = f"(line {v.sourceline})"
                texts.append(f'The display unit "{shown.displayUnit}" of variable "{v.name}" {line} has no unit.')
                shown.displayUnit = None  # FMPy would look for it among those of its unit
    return [
        breach_of(text) for text in texts + validate_model_description(model, validate_model_structure=with_structure)
    ]


def required_functions(fmu_class: type, version: Version) -> list[str]:
    """The functions of FMI that FMPy looks up in the library of an FMU: the names of the methods of its class.

    Those of FMI 1.0 are without the model identifier that stands before them.
    """
    prefix = f"fmi{version}"
    names = [name for name in dir(fmu_class) if name.startswith(prefix) and name[len(prefix) :][:1].isupper()]
    return [f"fmi{name[len(prefix) :]}" for name in names] if version == Version.FMI1 else names


class _Bound:
    """A class of FMPy around a library that is loaded already, which may lack functions.

    FMPy would load it once more, and look up and inspect all functions of FMI. The other arguments are what an instance
    is made with: the GUID, the model identifier, the folder in which the FMU is unpacked, and the instance name.
    """

    def __init__(self, library: FunctionLibrary, guid: str, identifier: str, folder: str, name: str) -> None:
        self.dll, self._functions = library, BoundFunctions(library, type(self))
        self.guid, self.modelIdentifier, self.unzipDirectory, self.instanceName = guid, identifier, folder, name
        self.component = self.callbacks = self.fmiCallLogger = None


class FMU1Slave(_Bound, fmi1.FMU1Slave):
    """An FMI 1.0 Co-Simulation FMU."""


class FMU1Model(_Bound, fmi1.FMU1Model):
    """An FMI 1.0 Model Exchange FMU, with the modes of FMI 2.0, which it does not know."""

    def enterEventMode(self) -> None:  # noqa: N802 - FMI's name
        """Nothing: events are updated at any time."""

    def enterContinuousTimeMode(self) -> None:  # noqa: N802
        """Nothing."""


class FMU2Slave(_Bound, fmi2.FMU2Slave):
    """An FMI 2.0 Co-Simulation FMU."""


class FMU2Model(_Bound, fmi2.FMU2Model):
    """An FMI 2.0 Model Exchange FMU."""


class FMU3Slave(_Bound, fmi3.FMU3Slave):
    """An FMI 3.0 Co-Simulation FMU."""


class FMU3Model(_Bound, fmi3.FMU3Model):
    """An FMI 3.0 Model Exchange FMU."""


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
