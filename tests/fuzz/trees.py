"""Damage to documents whose structure is known: XML, JSON and TOML."""

from __future__ import annotations

import copy
import json
import re
from collections.abc import Sequence
from random import Random
from typing import Any, Final

from lxml import etree

from tests.fuzz import hostile
from tests.fuzz.damage import encoded, repeatedly, text_damaged
from tests.fuzz.hostile import pick

_ATTRIBUTE: Final = re.compile(r'(?<==")[^"]*(?=")')
_PLACEHOLDER: Final = "placeholder-{}"
_KEY: Final = re.compile(r"^[^\s=#\[][^=\n]*(?==)", re.MULTILINE)
_LITERAL: Final = re.compile(r'"[^"\n]*"|[-+]?\d[\w.+-]*|true|false')
_LITERALS: Final = (
    *(
        "9" * 5000,
        "-" + "9" * 5000,
        "0x" + "f" * 5000,
        "1e999",
        "inf",
        "-nan",
        "nan",
        "-0",
        "-0.0",
        "1979-05-27",
        "07:32:00",
    ),
    *(
        "0001-01-01T00:00:00-23:59",
        "9999-12-31T23:59:59+23:59",
        "true",
        "''",
        '"""x"""',
        "[]",
        "{}",
        "[1, 'a']",
        "[[1], [2]]",
    ),
    *(
        '"\\ud800"',
        '"\\uD800"',
        '"\\U0010FFFF"',
        "{ value = 1 }",
        "{ a = { b = 1 } }",
        "1_000",
        "0b1",
        "0o7",
        "00",
        "1__0",
    ),
    *(
        '{ value = 1, unit = "m" }',
        '{ value = [], unit = "1", source = "s" }',
        '{ value = {}, unit = "s", source = "" }',
    ),
    *('{ value = 1979-05-27, unit = "s", source = "s" }', '{ value = "x", unit = "s", source = "s" }'),
    *('{ value = nan, unit = "s", source = "s" }', '{ value = inf, unit = "1", source = "s" }'),
)


def xml_damaged(content: bytes, random: Random, others: Sequence[bytes]) -> bytes:
    """A document whose elements and attributes were changed, lost, repeated, moved or replaced."""
    if random.random() < 0.1:
        return encoded(text_damaged(content.decode(), random, [other.decode() for other in others]), random)
    root = etree.fromstring(content)
    raw: list[str] = []
    repeatedly(random, lambda: _elements_damaged(root, random, others, raw))
    text = etree.tostring(root, encoding="unicode")
    for i, value in enumerate(raw):
        text = text.replace(_PLACEHOLDER.format(i), value)
    if random.random() < 0.05:
        deep = pick(random, hostile.DEEP)
        at = pick(random, [match.end() for match in re.finditer(">", text)] or [0])
        text = text[:at] + "<a>" * deep + "</a>" * deep + text[at:]
    if random.random() < 0.02:
        text = '<!DOCTYPE a [<!ENTITY x "y">]>' + text
    return encoded('<?xml version="1.0" encoding="UTF-8"?>\n' + text, random)


def _elements_damaged(root: Any, random: Random, others: Sequence[bytes], raw: list[str]) -> None:  # noqa: C901 - one kind of damage after the other
    elements = [element for element in root.iter() if isinstance(element.tag, str)]
    one, other = pick(random, elements), pick(random, elements)
    parent = one.getparent()
    kind = random.randrange(12)
    if kind <= 4 and one.attrib:
        name = pick(random, sorted(one.attrib))
        if kind == 0:
            del one.attrib[name]
        elif kind == 1 and other.attrib:
            one.set(name, other.get(pick(random, sorted(other.attrib))))
        else:
            one.set(name, _unchecked(hostile.text(random), raw))
    elif kind == 5:
        one.set(pick(random, _known_attributes(elements)), _unchecked(hostile.text(random), raw))
    elif kind == 6 and parent is not None:
        parent.remove(one)
    elif kind == 7 and parent is not None:
        for _ in range(pick(random, (1, 1, 2, 50))):
            parent.insert(random.randrange(len(parent) + 1), copy.deepcopy(one))
    elif kind == 8:
        one.insert(random.randrange(len(one) + 1), copy.deepcopy(other))
    elif kind == 9:
        one.tag = other.tag
    elif kind == 10:
        found = [e for e in etree.fromstring(pick(random, others)).iter() if isinstance(e.tag, str)]
        one.insert(random.randrange(len(one) + 1), copy.deepcopy(pick(random, found)))
    else:
        one.text = _unchecked(hostile.text(random), raw)


def _unchecked(value: str, raw: list[str]) -> str:
    """A value that lxml takes; another is put in its place afterwards, as no maker's tool would check it either."""
    raw.append(value.replace("&", "&amp;").replace('"', "&quot;").replace("<", "&lt;") if len(raw) % 4 else value)
    return _PLACEHOLDER.format(len(raw) - 1)


def _known_attributes(elements: Sequence[Any]) -> list[str]:
    return sorted({name for element in elements for name in element.attrib}) or ["name"]


def json_damaged(content: bytes, random: Random, others: Sequence[bytes]) -> bytes:
    """JSON whose values were changed, lost, repeated or replaced by values of other types."""
    text = content.decode()
    if random.random() < 0.2:
        return encoded(text_damaged(text, random, [other.decode() for other in others]), random)
    holder: Any = {"": json.loads(text)}
    repeatedly(random, lambda: _node_damaged(holder, random))
    return encoded(json.dumps(holder.get("")), random)


def _node_damaged(holder: Any, random: Random) -> None:
    places = list(_places(holder))
    where, key = pick(random, places)
    kind = random.randrange(6)
    if kind <= 2:
        where[key] = hostile.value(random)
    elif kind == 3 and where is not holder:
        del where[key]
    elif kind == 4:
        other, at = pick(random, places)
        where[key] = copy.deepcopy(other[at])
    elif isinstance(where[key], dict):
        where[key][hostile.text(random)] = hostile.value(random)
    else:
        where[key] = [where[key]]


def _places(node: Any) -> Any:
    """Every container below a node, with each of its keys."""
    items = node.items() if isinstance(node, dict) else enumerate(node)
    for key, value in list(items):
        yield node, key
        if isinstance(value, dict | list):
            yield from _places(value)


def toml_damaged(content: bytes, random: Random, others: Sequence[bytes]) -> bytes:
    """TOML whose keys, values, tables and lines were changed, lost, repeated or replaced."""
    text = content.decode()

    def once() -> None:
        nonlocal text
        kind = random.randrange(5)
        if kind <= 1 and (found := list(_LITERAL.finditer(text))):
            at, new = pick(random, found), pick(random, (*_LITERALS, json.dumps(hostile.text(random))))
            text = text[: at.start()] + new + text[at.end() :]
        elif kind == 2 and (found := list(_KEY.finditer(text))):
            at = pick(random, found)
            new = pick(
                random, ("a.b", '""', '"\\u0000"', "a", '"é"', json.dumps(hostile.text(random)), pick(random, found)[0])
            )
            text = text[: at.start()] + new + text[at.end() :]
        elif kind == 3 and (found := list(_KEY.finditer(text))):
            at = pick(random, found)
            end = text.find("\n", at.end())
            text = f"{text[: at.end()]}= {pick(random, _LITERALS)}{text[end:] if end >= 0 else ''}"
        else:
            text = text_damaged(text, random, [other.decode() for other in others])

    repeatedly(random, once)
    return encoded(text, random)
