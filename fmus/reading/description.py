"""Model descriptions: read once, and checked against the rules of FMI before anything in them is used.

A description that breaks a rule without which it has no meaning (a reference to a variable that does not exist) is
always refused. One that breaks another rule, the schema among them, is refused too, unless the reader is lenient: then
it is read all the same, and the breach becomes a remark. Breaches that most tools accept without a message, such as an
incomplete model structure, are remarks in both cases.
"""
# pyright: basic
# FMPy carries few types; everything that leaves this file is annotated.

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Any, Final

from lxml import etree

from components.interfaces.problem import Problem, RequestError, listed, raise_if_any, refuse
from fmus.reading.schema_breaches import schema_breaches
from fmus.reading.start_values import ReadingError
from fmus.reading.xml_documents import parse_xml
from fmus.toolchain.archives import MODEL_DESCRIPTION
from fmus.toolchain.description_breach import DescriptionBreach, as_phrase
from fmus.toolchain.door import exception_in_words
from fmus.toolchain.file_names import FILE_NAME, is_file_name, shown_name
from fmus.toolchain.fmpy_library import (
    ModelDescription,
    ModelDescriptionError,
    description_breaches,
    description_schema,
    read_model,
)
from fmus.toolchain.limits import MOST_VARIABLES
from fmus.toolchain.version import Version

_REMEDY: Final = "Have the file corrected by its maker, or run it as it is with --lenient."
WITHOUT_LENIENT: Final = "Open it without --lenient, to see the rules that it breaks."
"""What to do with a description that a lenient reader cannot read either."""
_VERSIONS: Final = "1.0, 2.0 or 3.0"
_MOST: Final = 20
"""The number of problems of one kind that are listed; a longer list would give no more information."""


@dataclass(frozen=True)
class Description:
    """A model description that can be used."""

    root: Any
    """The root element."""
    model: ModelDescription
    version: Version
    remarks: tuple[str, ...]
    """The rules that it breaks although it can be run."""
    breaks_rules: bool
    """Whether there are such rules."""


def read_description(content: bytes, where: str, *, lenient: bool) -> Description:
    """Read and check a model description.

    Args:
        content: The file.
        where: The FMU, as messages name it.
        lenient: Whether breaches of rules without which the FMU can be run become remarks.

    Raises:
        RequestError: The description cannot be used; the error has all problems that were found.
    """
    place = f"{where}, {MODEL_DESCRIPTION}"
    root = parse_xml(content, place, "well-formed XML without a document type declaration")
    version, remark = _version(root, place, lenient=lenient)
    remarks = [remark] if remark else []
    if version != Version.FMI1:
        _refuse_other_interfaces(root, place)
    raise_if_any(_limit_problems(root, place))
    by_schema = _schema_breaches(root, version)
    problems = [
        *_identifier_problems(root, version, place),
        *(
            _meaningless(place, line, text, "a name of its own for each variable")
            for line, text in islice(_unnamed(root), _MOST)
        ),
        *(_meaningless(place, *breach, "what the file declares") for breach in _first(_dangling(root, version))),
    ]
    if not lenient:
        problems = [*(_problem(place, line, as_phrase(text), version) for line, text in by_schema[:_MOST]), *problems]
    raise_if_any(problems[:_MOST])
    remarks += _schema_remarks(by_schema)
    model = _model(root, version, place, lenient=lenient)
    breaches = description_breaches(model, with_structure=True)
    if not lenient and breaches:
        # pythonfmu, among others, writes integers without a variability, and most tools accept them
        others = [breach for breach in breaches if not breach.concerns_variability]
        tolerated = _of_structure(model) if others else set[DescriptionBreach]()
        refused = [breach for breach in others if breach not in tolerated]
        raise_if_any(_problem(place, breach.line, breach.found, version) for breach in refused[:_MOST])
    remarks += _breach_remarks(list(dict.fromkeys(breaches)))
    return Description(root, model, version, tuple(remarks), bool(by_schema or breaches))


def _schema_remarks(breaches: Sequence[tuple[int, str]]) -> list[str]:
    """One remark for each element and attribute that break the schema in one way."""
    kinds: dict[tuple[str, str], list[tuple[int, str]]] = {}
    for line, text in breaches:
        element, _, reason = text.partition(": ")
        kinds.setdefault((element, re.sub(r"'[^']*'", "", reason)), []).append((line, text))
    remarks: list[str] = []
    for (line, text), *others in kinds.values():
        lines = list(dict.fromkeys(str(other) for other, _ in others))
        more = f" (the same {len(others)} more times, in line {listed(lines)})" if others else ""
        remarks.append(f"{MODEL_DESCRIPTION}, line {line}: {text}{more}")
    return remarks[:_MOST]


def _breach_remarks(breaches: Sequence[DescriptionBreach]) -> list[str]:
    """One remark for each rule that is broken, with the number of variables and some of their names."""
    kinds: dict[str, list[DescriptionBreach]] = {}
    for breach in breaches:
        kinds.setdefault(breach.kind, []).append(breach)
    remarks: list[str] = []
    for first, *others in kinds.values():
        names = listed([f"`{other.variable}`" for other in others])
        remarks.append(f"{MODEL_DESCRIPTION}: {first.report}{f' (the same of {names})' if others else ''}")
    return remarks


def _meaningless(place: str, line: int, found: str, valid: str) -> Problem:
    """A rule that is broken, without which the description has no meaning."""
    return Problem(f"{place}, line {line}", found, valid)


def _problem(place: str, line: int | None, found: str, version: Version) -> Problem:
    """A rule that is broken, which a lenient reader overlooks."""
    at = f"{place}, line {line}" if line else place
    return Problem(at, found, f"what FMI {version}.0 allows", _REMEDY)


def not_understood(error: Exception, where: str, *, lenient: bool = False) -> RequestError:
    """The refusal of a variable that cannot be understood, with its line where that is known."""
    line = error.line if isinstance(error, ReadingError) else None
    place = f"{where}, {MODEL_DESCRIPTION}{f', line {line}' if line else ''}"
    known = isinstance(error, ReadingError)
    found = f"a variable that cannot be understood ({error if known else exception_in_words(error)})"
    return refuse(place, found, "what FMI allows", WITHOUT_LENIENT if lenient and not known else "")


def _model(root: Any, version: Version, place: str, *, lenient: bool) -> ModelDescription:
    try:
        return read_model(root, version)
    except ModelDescriptionError as error:
        found = f"a description that cannot be understood ({error})"
        remedy = WITHOUT_LENIENT if lenient else ""
        raise refuse(place, found, "what FMI allows", remedy) from error


def _of_structure(model: ModelDescription) -> set[DescriptionBreach]:
    """The breaches of an incomplete model structure, which most tools accept without a message."""
    others = {*description_breaches(model, with_structure=False)}
    return {breach for breach in description_breaches(model, with_structure=True) if breach not in others}


def _version(root: Any, place: str, *, lenient: bool) -> tuple[Version, str | None]:
    """The version of FMI that the description is read as, and a remark if it names another one."""
    named = root.get("fmiVersion")
    if root.tag != "fmiModelDescription" or named is None:
        valid = "`fmiModelDescription` with `fmiVersion`"
        raise refuse(place, f"a description of no FMU (its root is `{root.tag}`)", valid)
    if named in {"1.0", "2.0"} or re.fullmatch(r"3\.0(\.\d+)?(-.+)?", named):
        return Version(int(named[0])), None
    if named[:2] in {"2.", "3."}:
        text = f"FMI version {named}, read as {named[0]}.0"
        if named[0] == "3" or lenient:  # FMI promises that an importer of 3.0 can read later versions 3.x
            return Version(int(named[0])), f"{MODEL_DESCRIPTION}: {text}"
        raise refuse(place, f"FMI version {named}", _VERSIONS, _REMEDY)
    raise refuse(place, f"FMI version {named}", _VERSIONS, "Export it again as FMI 2.0 or 3.0.")


def _refuse_other_interfaces(root: Any, place: str) -> None:
    if root.find("CoSimulation") is None and root.find("ModelExchange") is None:
        found = "only Scheduled Execution" if root.find("ScheduledExecution") is not None else "no interface type"
        remedy = "Export it again for Co-Simulation or Model Exchange."
        raise refuse(place, found, "Co-Simulation or Model Exchange", remedy)


def _limit_problems(root: Any, place: str) -> Iterator[Problem]:
    """More variables than can be read."""
    if (number := len(root.findall("ModelVariables/*"))) > MOST_VARIABLES:
        yield Problem(place, f"{number} variables", f"at most {MOST_VARIABLES}", "Export a smaller part of the model.")


def _identifier_problems(root: Any, version: Version, place: str) -> Iterator[Problem]:
    """Model identifiers that cannot be the name of a library, which they become."""
    kinds = ("CoSimulation", "ModelExchange")
    for element in [root] if version is Version.FMI1 else [e for kind in kinds for e in root.iterfind(kind)]:
        identifier = element.get("modelIdentifier")
        if identifier is None or not is_file_name(identifier):
            found = "no modelIdentifier" if identifier is None else f"the modelIdentifier `{shown_name(identifier)}`"
            yield _meaningless(place, element.sourceline, found, f"the name of the library: {FILE_NAME}")


def _schema_breaches(root: Any, version: Version) -> list[tuple[int, str]]:
    found = schema_breaches(root, description_schema(version))
    return [(line, re.sub(r"\{(?:http|urn)[^{}]*\}", "", text)) for line, text in found]


def _first(breaches: Iterable[tuple[int, str]]) -> list[tuple[int, str]]:
    """The first of very many breaches, each once."""
    found: dict[tuple[int, str], None] = {}
    for breach in breaches:
        found[breach] = None
        if len(found) == _MOST:
            break
    return [*found]


def _unnamed(root: Any) -> Iterator[tuple[int, str]]:
    """Variables without a name or reference, or with a name that another one has, with their lines."""
    variables = [element for element in root.iterfind("ModelVariables/*") if isinstance(element.tag, str)]
    aliases = root.findall("ModelVariables/*/Alias")
    for attribute, elements in (("name", [*variables, *aliases]), ("valueReference", variables)):
        yield from ((e.sourceline, f"a variable without `{attribute}`") for e in elements if e.get(attribute) is None)
    seen: set[str] = set()
    for element in (*variables, *aliases):
        name = element.get("name")
        if name is not None and name in seen:
            yield element.sourceline, f"two variables with the name `{name}`"
        seen.add(name or "")


def _dangling(root: Any, version: Version) -> Iterator[tuple[int, str]]:
    """References to variables and types that are not there, with their lines."""
    variables = list(root.iterfind("ModelVariables/*"))
    if version == Version.FMI1:
        known = {element.get("name") for element in variables}
        what, references = "variable", _fmi1_references(root)
    elif version == Version.FMI2:
        known = {str(i + 1) for i in range(len(variables))}
        what, references = "variable number", _fmi2_references(root)
    else:
        known = {element.get("valueReference") for element in variables}
        what, references = "value reference", _fmi3_references(root)
    for element, attribute, values in references:
        for value in values:
            if _plain_number(value) not in known:
                text = f"`{attribute}` of {etree.QName(element).localname}, {what} {value}, which is not there"
                yield element.sourceline, text
    types = {element.get("name") for element in root.iterfind("TypeDefinitions/*")}
    for element in root.iterfind("ModelVariables//*[@declaredType]"):
        if element.get("declaredType") not in types:
            yield element.sourceline, f"the declared type `{element.get('declaredType')}`, which is not there"


def _plain_number(text: str) -> str:
    """A whole number without leading zeros; any other text as it is."""
    return (text.lstrip("0") or "0") if text.isascii() and text.isdigit() else text


def _fmi1_references(root: Any) -> Iterator[tuple[Any, str, Sequence[str]]]:
    for element in root.iterfind("ModelVariables/ScalarVariable/DirectDependency/Name"):
        yield element, "Name", [(element.text or "").strip()]


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
