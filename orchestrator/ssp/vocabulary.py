"""The words of SSP files that reader and writer share; each string of the format stands here once.

Element and attribute names are those of the standard System Structure and Parameterization, SSP 1.0 and 2.0. An element
of one name may stand in several namespaces (`Units` in descriptions and in parameter sets), so the two are kept apart.
"""

from __future__ import annotations

from enum import StrEnum
from typing import Final

from components.interfaces.quantity import Type

SSD: Final = "http://ssp-standard.org/SSP1/SystemStructureDescription"
SSC: Final = "http://ssp-standard.org/SSP1/SystemStructureCommon"
SSV: Final = "http://ssp-standard.org/SSP1/SystemStructureParameterValues"
SSM: Final = "http://ssp-standard.org/SSP1/SystemStructureParameterMapping"
SSB: Final = "http://ssp-standard.org/SSP1/SystemStructureSignalDictionary"
STANDARD_NAMESPACES: Final = frozenset({SSD, SSC, SSV, SSM, SSB})
OSP: Final = "http://opensimulationplatform.com/SSP/OSPAnnotations"
"""Annotations of the Open Simulation Platform, whose master is libcosim."""
OURS: Final = "urn:macrostep"
PREFIXES: Final = {SSD: "ssd", SSC: "ssc", SSV: "ssv", OSP: "osp"}
"""Prefixes of the namespaces in the files that are written here."""

ANNOTATION_TYPE: Final = "org.macrostep"
OSP_ANNOTATION_TYPE: Final = "com.opensimulationplatform"

FMU_TYPE: Final = "application/x-fmu-sharedlibrary"
DEFINITION_TYPE: Final = "application/x-ssp-definition"
PACKAGE_TYPE: Final = "application/x-ssp-package"
PARAMETER_SET_TYPE: Final = "application/x-ssp-parameter-set"
PARAMETER_MAPPING_TYPE: Final = "application/x-ssp-parameter-mapping"
BLOCK_TYPE: Final = "application/x-macrostep-block"
"""A block of this program, which the component's source names after `BLOCK_SOURCE`."""
MAPPING_TYPE: Final = "application/x-macrostep-mapping"
"""A mapping file, which names its FMU; the component's connectors are those of a socket."""
BLOCK_SOURCE: Final = f"{OURS}:block:"

DESCRIPTION_FILE: Final = "SystemStructure.ssd"
PACKAGE_SUFFIX: Final = ".ssp"
PARAMETER_SET_SUFFIX: Final = ".ssv"
MAPPING_SUFFIX: Final = ".toml"


def resource(file: str) -> str:
    """The path in the archive of a file that a description refers to."""
    return f"resources/{file}"


class SspVersion(StrEnum):
    """The versions of SSP that are read and written."""

    SSP1 = "1.0"
    SSP2 = "2.0"

    @staticmethod
    def of(text: str) -> SspVersion | None:
        """The version with the major number of a version attribute; None where there is none."""
        return next((v for v in SspVersion if v.partition(".")[0] == text.partition(".")[0]), None)


class Tag(StrEnum):
    """Names of elements, without their namespaces."""

    DESCRIPTION = "SystemStructureDescription"
    SYSTEM = "System"
    ELEMENTS = "Elements"
    COMPONENT = "Component"
    SIGNAL_DICTIONARY_REFERENCE = "SignalDictionaryReference"
    CONNECTORS = "Connectors"
    CONNECTOR = "Connector"
    CONNECTIONS = "Connections"
    CONNECTION = "Connection"
    SIGNAL_DICTIONARIES = "SignalDictionaries"
    SIGNAL_DICTIONARY = "SignalDictionary"
    DICTIONARY_ENTRY = "DictionaryEntry"
    DEFAULT_EXPERIMENT = "DefaultExperiment"

    PARAMETER_BINDINGS = "ParameterBindings"
    PARAMETER_BINDING = "ParameterBinding"
    PARAMETER_VALUES = "ParameterValues"
    PARAMETER_SET = "ParameterSet"
    PARAMETERS = "Parameters"
    PARAMETER = "Parameter"
    VALUE = "Value"
    PARAMETER_MAPPING = "ParameterMapping"
    MAPPING_ENTRY = "MappingEntry"

    REAL = "Real"
    INTEGER = "Integer"
    CLOCK = "Clock"
    DIMENSION = "Dimension"
    ENUMERATIONS = "Enumerations"
    ENUMERATION = "Enumeration"
    ITEM = "Item"
    UNITS = "Units"
    UNIT = "Unit"
    BASE_UNIT = "BaseUnit"
    DISPLAY_UNIT = "DisplayUnit"

    LINEAR_TRANSFORMATION = "LinearTransformation"
    BOOLEAN_MAPPING = "BooleanMappingTransformation"
    INTEGER_MAPPING = "IntegerMappingTransformation"
    ENUMERATION_MAPPING = "EnumerationMappingTransformation"
    MAP_ENTRY = "MapEntry"

    ELEMENT_GEOMETRY = "ElementGeometry"
    SYSTEM_GEOMETRY = "SystemGeometry"
    CONNECTOR_GEOMETRY = "ConnectorGeometry"
    CONNECTION_GEOMETRY = "ConnectionGeometry"
    GRAPHICAL_ELEMENTS = "GraphicalElements"
    META_DATA = "MetaData"
    SIGNATURE = "Signature"
    ANNOTATIONS = "Annotations"
    ANNOTATION = "Annotation"

    # inside annotations: of this program, of the Open Simulation Platform, and of OMSimulator
    SCENARIO = "Scenario"
    ALGORITHM = "Algorithm"
    FIXED_STEP_ALGORITHM = "FixedStepAlgorithm"
    STEP_SIZE_HINT = "StepSizeHint"
    FIXED_STEP_MASTER = "FixedStepMaster"


class Attribute(StrEnum):
    """Names of attributes."""

    VERSION = "version"
    NAME = "name"
    DESCRIPTION = "description"
    ID = "id"
    KIND = "kind"
    TYPE = "type"
    SOURCE = "source"
    SOURCE_BASE = "sourceBase"
    PREFIX = "prefix"
    DICTIONARY = "dictionary"
    IMPLEMENTATION = "implementation"
    UNIT = "unit"
    SIZE = "size"
    VALUE = "value"
    FACTOR = "factor"
    OFFSET = "offset"
    TARGET = "target"
    START_ELEMENT = "startElement"
    START_CONNECTOR = "startConnector"
    START_INDICES = "startIndices"
    END_ELEMENT = "endElement"
    END_CONNECTOR = "endConnector"
    END_INDICES = "endIndices"
    SUPPRESS_UNIT_CONVERSION = "suppressUnitConversion"
    START_TIME = "startTime"
    STOP_TIME = "stopTime"
    BASE_STEP_SIZE = "baseStepSize"
    STEP_SIZE = "stepSize"


class ConnectorKind(StrEnum):
    """The kinds of connectors."""

    INPUT = "input"
    OUTPUT = "output"
    INOUT = "inout"
    PARAMETER = "parameter"
    STRUCTURAL_PARAMETER = "structuralParameter"
    CALCULATED_PARAMETER = "calculatedParameter"
    CONSTANT = "constant"
    LOCAL = "local"


ANY_IMPLEMENTATION: Final = "any"
"""What stands for the name of an interface type of FMI where the SSP asks for none."""
SSP1_TYPES: Final = {Tag.REAL: Type.FLOAT64, Tag.INTEGER: Type.INT32}
"""The type elements of SSP 1.0 that SSP 2.0 names otherwise."""
TYPES: Final = {str(tag): kind for tag, kind in SSP1_TYPES.items()} | {str(kind): kind for kind in Type}
"""The types that type elements mean; a clock has none."""
