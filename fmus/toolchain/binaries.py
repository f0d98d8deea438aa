"""What a file of machine code says of itself: its platform, the functions it offers, and the libraries it needs.

It is read without being loaded, so that nothing of it runs. Of ELF (Linux) everything is read, of PE (Windows) and
Mach-O (macOS) the platform only.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

_ELF: Final = {3: "x86", 20: "ppc", 21: "ppc64", 22: "s390x", 40: "arm", 62: "x86_64", 183: "aarch64", 243: "riscv64"}
_PE: Final = {0x14C: "x86", 0x1C4: "arm", 0x8664: "x86_64", 0xAA64: "aarch64"}
_MACH_O: Final = {7: "x86", 12: "arm", 0x01000007: "x86_64", 0x0100000C: "aarch64"}
_MACH_O_MAGIC: Final = {0xFEEDFACE, 0xFEEDFACF}
_MACH_O_FAT: Final = 0xCAFEBABE
_MOST_PARTS: Final = 16
"""The most platforms of one file of macOS; a Java class begins with the same bytes and a larger number."""
_SHARED: Final = 3
_DYNAMIC, _DYNAMIC_SYMBOLS = 6, 11
_NEEDED: Final = 1
GIT_LFS_POINTER: Final = "a pointer of Git LFS instead of the file itself"
"""What stands in the place of a file that was copied from a repository without Git LFS, in words."""
_LFS: Final = b"version https://git-lfs"
_SHOWN: Final = 40
"""The number of characters of a text that a message shows."""


@dataclass(frozen=True)
class MachineCode:
    """What a file says of itself."""

    platforms: tuple[str, ...] = ()
    """The platforms that it is for, as FMI 3.0 names them; none for a file that is no library."""
    problem: str = ""
    """What the file is in words, where it is no library."""
    exports: frozenset[str] | None = None
    """The names of the functions that it offers; None where they are not known."""
    needed: tuple[str, ...] = ()
    """The names of the libraries that it needs."""


def machine_code(content: bytes) -> MachineCode:
    """Read what a file says of itself, by its first bytes."""
    try:
        return _read(content)
    except (struct.error, ValueError, IndexError):
        return MachineCode(problem="a damaged library")


def _read(content: bytes) -> MachineCode:
    if content.startswith(b"\x7fELF"):
        return _elf(content)
    if content.startswith(b"MZ"):
        (at,) = struct.unpack_from("<I", content, 0x3C)
        return MachineCode((f"{_named(_PE, struct.unpack_from('<H', content, at + 4)[0])}-windows",))
    if content.startswith(b"!<arch>"):
        return MachineCode(problem="a static library")
    if struct.unpack_from("<I", content.ljust(4))[0] in _MACH_O_MAGIC:
        return MachineCode((f"{_named(_MACH_O, struct.unpack_from('<I', content, 4)[0])}-darwin",))
    if struct.unpack_from(">I", content.ljust(4))[0] == _MACH_O_FAT:
        (count,) = struct.unpack_from(">I", content, 4)
        if count <= _MOST_PARTS:
            processors = [struct.unpack_from(">I", content, 8 + 20 * part)[0] for part in range(count)]
            return MachineCode(tuple(f"{_named(_MACH_O, p)}-darwin" for p in processors))
    return MachineCode(problem=_no_library(content))


def _no_library(content: bytes) -> str:
    if not content:
        return "an empty file"
    if content.startswith(_LFS):
        return GIT_LFS_POINTER
    try:
        text = content[:1000].decode().strip()
    except UnicodeDecodeError:
        text = ""
    if "\0" in text or not text:
        return "a file that is no library"
    first = text.splitlines()[0]
    return f"a text (`{first[:_SHOWN]}{'...' if len(first) > _SHOWN else ''}`)"


def _named(known: dict[int, str], number: int) -> str:
    return known.get(number, f"processor {number}")


@dataclass(frozen=True)
class _Section:
    """A section of an ELF file; offsets and sizes in bytes."""

    kind: int
    offset: int
    size: int
    link: int


def _elf(content: bytes) -> MachineCode:
    wide, order = content[4] == 2, {1: "<", 2: ">"}.get(content[5])  # noqa: PLR2004 - 64 bits
    if order is None or content[4] not in {1, 2}:
        raise ValueError
    kind, machine = struct.unpack_from(f"{order}HH", content, 16)
    platform = f"{_named(_ELF, machine)}-linux"
    if kind != _SHARED:
        return MachineCode(problem="a file of machine code that is no shared library")
    sections = list(_sections(content, order, wide=wide))
    exports: frozenset[str] | None = None
    needed: tuple[str, ...] = ()
    for section in sections:
        if section.kind not in {_DYNAMIC, _DYNAMIC_SYMBOLS} or section.link >= len(sections):
            continue
        names = sections[section.link]
        text = content[names.offset : names.offset + names.size]
        table = content[section.offset : section.offset + section.size]
        if section.kind == _DYNAMIC_SYMBOLS:
            exports = frozenset(_text(text, at) for at in _offered(table, order, wide=wide))
        else:
            entries = struct.iter_unpack(f"{order}{'qQ' if wide else 'iI'}", table)
            needed = tuple(_text(text, value) for tag, value in entries if tag == _NEEDED)
    return MachineCode((platform,), exports=exports, needed=needed)


def _sections(content: bytes, order: str, *, wide: bool) -> Iterator[_Section]:
    (start,) = struct.unpack_from(f"{order}{'Q' if wide else 'I'}", content, 40 if wide else 32)
    size, count = struct.unpack_from(f"{order}HH", content, 58 if wide else 46)
    for number in range(count if start else 0):
        header = struct.unpack_from(f"{order}{'IIQQQQIIQQ' if wide else '10I'}", content, start + number * size)
        yield _Section(header[1], header[4], header[5], header[6])


def _offered(table: bytes, order: str, *, wide: bool) -> Iterator[int]:
    """Where the names stand of the symbols that are defined in the file itself."""
    if wide:
        yield from (name for name, _, _, at, _, _ in struct.iter_unpack(f"{order}IBBHQQ", table) if at)
    else:
        yield from (name for name, _, _, _, _, at in struct.iter_unpack(f"{order}IIIBBH", table) if at)


def _text(table: bytes, at: int) -> str:
    return table[at : table.index(b"\0", at)].decode("utf-8", "replace")
