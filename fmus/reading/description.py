"""Model descriptions: read once, and measured by the rules of FMI before anything of them is believed.

Some rules cannot be done without (a reference to a variable that is not there means nothing): what breaks one is
refused. The others, the schema among them, are as strict, unless the reader is lenient: then what breaks one is read
all the same, and said. What most tools accept without a word, a model structure that is not complete, is only said.
"""
# pyright: basic
# FMPy carries few types; everything that leaves this file is annotated.

from __future__ import annotations

import re
import zipfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from io import BytesIO
from typing import Any, Final

from lxml import etree

from components.interfaces.problem import Problem, raise_if_any, refuse
from fmus.reading.unpack import parse_xml
from fmus.toolchain.fmpy_library import (
    ModelDescription,
    description_schema,
    read_model_description,
    validate_model_description,
)
from fmus.toolchain.version import Version

FILE: Final = "modelDescription.xml"
_REMEDY: Final = "Have the file corrected by its maker, or run it as it is with --lenient."
_ACCEPTED: Final = ("must have variability",)
"""Rules that common exporters break (integers without a variability, by pythonfmu) and most tools let them"""
_MOST: Final = 20
"""Problems of one kind that are listed; a file with more of them is no better known by a longer list."""


@dataclass(frozen=True)
class Description:
    """A model description that has been understood."""

    root: Any
    """The root element"""
    model: ModelDescription
    version: Version
    remarks: tuple[str, ...]
    """Rules that it breaks and that do not keep it from running"""


def read_description(content: bytes, where: str, *, lenient: bool) -> Description:
    """Read and check a model description; `where` is the FMU. Raises `RequestError` with all that is wrong."""
    place = f"{where}, {FILE}"
    root = parse_xml(content, place, "well-formed XML without a document type declaration")
    version, told = _version(root, place, lenient=lenient)
    remarks = [told] if told else []
    _refuse_other_interfaces(root, place)
    broken = list(_schema_breaches(root, version))
    fatal = [_fatal(place, line, text, "a name of its own for each variable") for line, text in _unnamed(root)]
    fatal += [
        _fatal(place, line, text, "what the file declares") for line, text in dict.fromkeys(_dangling(root, version))
    ]
    if not lenient:
        fatal = [*(_problem(place, line, text, version) for line, text in broken[:_MOST]), *fatal]
    raise_if_any(fatal[:_MOST])
    remarks += [f"{FILE}, line {line}: {text}" for line, text in broken[:_MOST]]
    model = _model(content, root, place)
    breaches = validate_model_description(model)
    refused = [text for text in breaches if not any(words in text for words in _ACCEPTED)]
    if not lenient:
        raise_if_any(_problem(place, None, text, version) for text in refused[:_MOST])
    structure = validate_model_description(model, validate_model_structure=True)
    remarks += [f"{FILE}: {_tidy(text)}" for text in dict.fromkeys([*breaches, *structure])]
    return Description(root, model, version, tuple(remarks))


def _fatal(place: str, line: int, found: str, valid: str) -> Problem:
    """What nobody can make sense of."""
    return Problem(f"{place}, line {line}", found, valid)


def _problem(place: str, line: int | None, text: str, version: Version) -> Problem:
    """A rule that is broken, and can be overlooked."""
    found, line_in_text = _located(text)
    line = line or line_in_text
    at = f"{place}, line {line}" if line else place
    return Problem(at, found, f"what FMI {version}.0 allows", _REMEDY)


def _located(text: str) -> tuple[str, int | None]:
    """A message of FMPy without its line, and the line."""
    match = re.search(r" \(line (\d+)\)", text)
    if match is None:
        return _tidy(text), None
    return _tidy(text[: match.start()] + text[match.end() :]), int(match[1])


def _tidy(text: str) -> str:
    return " ".join(text.split()).rstrip(".").replace('"', "`")


def _version(root: Any, place: str, *, lenient: bool) -> tuple[Version, str | None]:
    """The version of FMI that the description names, and what is to be said of it."""
    named = root.get("fmiVersion")
    if root.tag != "fmiModelDescription" or named is None:
        valid = "`fmiModelDescription` with `fmiVersion`"
        raise refuse(place, f"a description of no FMU (its root is `{root.tag}`)", valid)
    if named == "2.0" or re.fullmatch(r"3\.0(\.\d+)?(-.+)?", named):
        return Version(int(named[0])), None
    if named[:2] in {"2.", "3."}:
        text = f"FMI version {named}, read as {named[0]}.0"
        if named[0] == "3" or lenient:  # later versions 3.x promise that an importer of 3.0 can read them
            return Version(int(named[0])), f"{FILE}: {text}"
        raise refuse(place, f"FMI version {named}", "2.0 or 3.0", _REMEDY)
    raise refuse(place, f"FMI version {named}", "2.0 or 3.0", "Export it again as FMI 2.0 or 3.0.")


def _refuse_other_interfaces(root: Any, place: str) -> None:
    if root.find("CoSimulation") is None and root.find("ModelExchange") is None:
        found = "only Scheduled Execution" if root.find("ScheduledExecution") is not None else "no interface type"
        remedy = "Export it again for Co-Simulation or Model Exchange."
        raise refuse(place, found, "Co-Simulation or Model Exchange", remedy)


def _schema_breaches(root: Any, version: Version) -> Iterator[tuple[int, str]]:
    schema = description_schema(version)
    if not schema.validate(root):
        yield from ((e.line, re.sub(r"\{[^}]*\}", "", e.message)) for e in schema.error_log)


def _unnamed(root: Any) -> Iterator[tuple[int, str]]:
    """Variables that cannot be told apart, with their lines."""
    seen: set[str] = set()
    for element in root.iterfind("ModelVariables/*"):
        for attribute in ("name", "valueReference"):
            if element.get(attribute) is None:
                yield element.sourceline, f"a variable without `{attribute}`"
        for named in (element, *element.iterfind("Alias")):
            name = named.get("name")
            if name is not None and name in seen:
                yield named.sourceline, f"two variables with the name `{name}`"
            seen.add(name or "")


def _dangling(root: Any, version: Version) -> Iterator[tuple[int, str]]:
    """What refers to something that is not there, with its line."""
    variables = list(root.iterfind("ModelVariables/*"))
    if version == Version.FMI2:
        known = {str(i + 1) for i in range(len(variables))}
        what, references = "variable number", _fmi2_references(root)
    else:
        known = {element.get("valueReference") for element in variables}
        what, references = "value reference", _fmi3_references(root)
    for element, attribute, values in references:
        for value in values:
            if (str(int(value)) if value.isdigit() else value) not in known:
                text = f"`{attribute}` of {etree.QName(element).localname}, {what} {value}, which is not there"
                yield element.sourceline, text
    types = {element.get("name") for element in root.iterfind("TypeDefinitions/*")}
    for element in root.iterfind("ModelVariables//*[@declaredType]"):
        if element.get("declaredType") not in types:
            yield element.sourceline, f"the declared type `{element.get('declaredType')}`, which is not there"


def _fmi2_references(root: Any) -> Iterator[tuple[Any, str, Sequence[str]]]:
    for element in root.iterfind("ModelStructure/*/Unknown"):
        yield element, "index", [element.get("index", "")]
        yield element, "dependencies", element.get("dependencies", "").split()
    for element in root.iterfind("ModelVariables/ScalarVariable/Real[@derivative]"):
        yield element, "derivative", [element.get("derivative")]


def _fmi3_references(root: Any) -> Iterator[tuple[Any, str, Sequence[str]]]:
    for element in root.iterfind("ModelStructure/*"):
        if isinstance(element.tag, str) and element.tag != "Annotations":
            yield element, "valueReference", [element.get("valueReference", "")]
            yield element, "dependencies", element.get("dependencies", "").split()
    for element in root.iterfind("ModelVariables/*"):
        for attribute in ("derivative", "previous", "clocks"):
            yield element, attribute, element.get(attribute, "").split()
        for dimension in element.iterfind("Dimension[@valueReference]"):
            yield dimension, "valueReference", [dimension.get("valueReference")]


_LIST: Final = re.compile(rb"\b(dependencies|dependenciesKind|clocks)(\s*=\s*)(\"[^\"]*\"|'[^']*')")


def _model(content: bytes, root: Any, place: str) -> ModelDescription:
    """What FMPy makes of the description, whose rules are checked elsewhere."""
    content = _LIST.sub(lambda m: m[1] + m[2] + m[3][:1] + b" ".join(m[3][1:-1].split()) + m[3][:1], content)
    if root.get("fmiVersion")[:2] == "2.":
        content = re.sub(rb"(fmiVersion\s*=\s*[\"'])2\.0[^\"']*", rb"\g<1>2.0", content, count=1)
    packed = BytesIO()  # an archive of its own, so that FMPy parses nothing that has not been looked at
    with zipfile.ZipFile(packed, "w") as archive:
        archive.writestr(FILE, content)
    try:
        return read_model_description(packed, validate=False)
    except Exception as error:  # FMPy raises bare Exception, and whatever Python raises on values it does not expect
        said = f"{type(error).__name__}: {error}" if isinstance(error, LookupError | TypeError) else str(error)
        raise refuse(place, f"a description that cannot be understood ({_tidy(said)})", "what FMI allows") from error
