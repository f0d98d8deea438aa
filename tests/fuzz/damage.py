"""Damage to bytes and to texts, whatever these are."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from random import Random
from typing import Final

from tests.fuzz import hostile
from tests.fuzz.hostile import pick

_TOKEN: Final = re.compile(r"\w+|\s+|[^\w\s]")
_NUMBER: Final = re.compile(r"[-+]?\d[\d.eE+-]*")
_QUOTED: Final = re.compile(r'"[^"\n]*"')
_LARGE: Final = 2**21
"""The characters of a text that is not damaged further."""
_WHOLE: Final = (1, 2, 4, 8)
"""The sizes of integers in binary files."""


def repeatedly(random: Random, damage: Callable[[], None]) -> None:
    """Do damage once, or several times."""
    damage()
    while random.random() < 0.4:
        damage()


def span(random: Random, length: int) -> tuple[int, int]:
    """A part of something, mostly a short one."""
    start = random.randrange(length + 1)
    size = pick(random, (1, 1, 2, 4, 8, random.randrange(64), random.randrange(length + 1)))
    return start, min(length, start + size)


def bytes_damaged(content: bytes, random: Random, others: Sequence[bytes] = (b"",)) -> bytes:
    """Bytes, of which some were changed, lost, repeated or replaced by bytes of another file."""
    data = bytearray(content)

    def once() -> None:
        start, end = span(random, len(data))
        kind = random.randrange(9)
        if kind == 0 and data:
            data[min(start, len(data) - 1)] ^= 1 << random.randrange(8)
        elif kind == 1:
            del data[start:end]
        elif kind == 2:
            data[start:end] = data[start:end] * random.choice((2, 2, 3, 50))
        elif kind == 3:
            data[start:start] = pick(random, hostile.BYTES)
        elif kind == 4:
            del data[start:]
        elif kind == 5:
            size = pick(random, _WHOLE)
            number = pick(random, (0, 1, 2 ** (8 * size) - 1, 2 ** (8 * size - 1), random.getrandbits(8 * size)))
            data[start : start + size] = number.to_bytes(size, "little")
        elif kind == 6:
            other = pick(random, others)
            a, b = span(random, len(other))
            data[start:end] = other[a:b]
        elif kind == 7:
            data[start:end] = random.randbytes(end - start)
        else:
            to = random.randrange(len(data) + 1)
            moved = bytes(data[start:end])
            del data[start:end]
            data[to:to] = moved

    repeatedly(random, once)
    return bytes(data)


def text_damaged(content: str, random: Random, others: Sequence[str] = ("",)) -> str:
    """A text, of which words, numbers, lines or marks were changed, lost, repeated, moved or replaced."""

    def once() -> None:
        nonlocal content
        if len(content) > _LARGE:  # repeated further, it would say nothing new
            return
        kind = random.randrange(8)
        if kind in (0, 1):
            pattern = pick(random, (_NUMBER, _NUMBER, _QUOTED, _TOKEN))
            found = list(pattern.finditer(content))
            if found:
                at = pick(random, found)
                new = hostile.text(random)
                content = content[: at.start()] + (f'"{new}"' if pattern is _QUOTED else new) + content[at.end() :]
        elif kind in (2, 3):
            lines = content.splitlines(keepends=True)
            _items_damaged(lines, random, [line for other in others for line in other.splitlines(keepends=True)])
            content = "".join(lines)
        elif kind in (4, 5):
            parts = _TOKEN.findall(content)
            _items_damaged(parts, random, _TOKEN.findall(pick(random, others)))
            content = "".join(parts)
        elif kind == 6:
            at = random.randrange(len(content) + 1)
            mark = pick(random, ("[", "(", "{", "[[", "{a=", "a.", "-", "not ", '"', "\\", "=", "/*", "if "))
            content = content[:at] + mark * pick(random, hostile.DEEP) + content[at:]
        else:
            start, end = span(random, len(content))
            content = content[:start] + pick(random, ("", hostile.text(random))) + content[end:]

    repeatedly(random, once)
    return content


def encoded(content: str, random: Random) -> bytes:
    """A text as bytes, now and then in an unusual encoding, or with single bytes that were damaged."""
    kind = random.randrange(30)
    if kind == 0:
        return content.encode(pick(random, ("utf-16", "utf-16-le", "utf-8-sig", "utf-32")), "surrogatepass")
    if kind == 1:
        return content.encode("latin-1", "replace")
    plain = content.encode("utf-8", "surrogatepass")
    return bytes_damaged(plain, random) if kind == 2 else plain


def _items_damaged(items: list[str], random: Random, others: Sequence[str]) -> None:
    if not items:
        return
    at, to = random.randrange(len(items)), random.randrange(len(items))
    kind = random.randrange(6)
    if kind == 0:
        del items[at]
    elif kind == 1:
        items.insert(to, items[at])
    elif kind == 2:
        items[at], items[to] = items[to], items[at]
    elif kind == 3:
        items[at] = pick(random, others) if others else ""
    elif kind == 4:
        items[at:at] = [items[at]] * pick(random, (2, 10, 300))
    else:
        del items[min(at, to) : max(at, to)]
