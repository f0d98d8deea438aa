"""The words of the format stand once in the sources of `orchestrator/ssp/`: in `vocabulary.py`."""

from __future__ import annotations

import ast
from enum import StrEnum
from pathlib import Path

import pytest

from components.interfaces.quantity import Type
from orchestrator.ssp import vocabulary
from orchestrator.ssp.vocabulary import TYPES, Attribute, ConnectorKind, SspVersion, Tag

FOLDER = Path(vocabulary.__file__).parent
OTHERS = sorted(path for path in FOLDER.glob("*.py") if path.stem != "vocabulary")
CONSTANTS = {value for name, value in vars(vocabulary).items() if name.isupper() and isinstance(value, str)}
NOT_OF_THE_FORMAT = {
    "annotation.py": {"step"},  # entries of the annotation, in JSON
    "parameter_set_writer.py": {"source"},  # where a value comes from, in a scenario
    "ssp_units.py": {"unit"},  # what a unit without a name is called
}


def strings(path: Path) -> set[str]:
    """All texts in a file but for its docstrings; of an f-string the parts between the braces."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    alone = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    constants = [n for n in ast.walk(tree) if isinstance(n, ast.Constant) and id(n) not in alone]
    return {node.value for node in constants if isinstance(node.value, str)}


@pytest.mark.parametrize("path", OTHERS, ids=lambda path: path.name)
def test_no_other_file_spells_a_word_of_the_format(path):
    words = {str(word) for kind in (Tag, Attribute, ConnectorKind, SspVersion) for word in kind} | CONSTANTS
    assert strings(path) & words - NOT_OF_THE_FORMAT.get(path.name, set()) == set()
    long = {word for word in CONSTANTS if "/" in word or ":" in word or len(word) > len(SspVersion.SSP1)}
    long |= {str(version) for version in SspVersion}
    assert [(text, word) for text in strings(path) for word in long if word in text] == []


def test_no_word_stands_twice():
    for kind in (Tag, Attribute, ConnectorKind, SspVersion):
        assert issubclass(kind, StrEnum)
        assert len(kind) == len(kind.__members__), kind
    names = [name for name, value in vars(vocabulary).items() if name.isupper() and isinstance(value, str)]
    assert len(names) == len(CONSTANTS)


@pytest.mark.parametrize(
    ("text", "version"),
    [("1.0", SspVersion.SSP1), ("1", SspVersion.SSP1), ("2.1", SspVersion.SSP2), ("3.0", None), ("", None)],
)
def test_the_major_number_decides_the_version(text, version):
    assert SspVersion.of(text) is version


def test_every_type_of_signals_has_an_element():
    assert set(TYPES.values()) == set(Type)
    assert {name: TYPES[name] for name in ("Real", "Integer", "Float64")} == {
        "Real": Type.FLOAT64, "Integer": Type.INT32, "Float64": Type.FLOAT64
    }  # fmt: skip
