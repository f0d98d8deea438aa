"""Archives whose structure is damaged: headers, the central directory, compression, names."""

from __future__ import annotations

import io
import struct
import zipfile
from random import Random
from typing import Final

from tests.fuzz import hostile
from tests.fuzz.damage import bytes_damaged, repeatedly
from tests.fuzz.hostile import pick

_METHODS: Final = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED, zipfile.ZIP_DEFLATED, zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA)
_HEADERS: Final = {b"PK\x03\x04": 30, b"PK\x01\x02": 46, b"PK\x05\x06": 22}
"""The length of what is fixed in each kind of header."""


def packed(files: dict[str, bytes], random: Random | None = None) -> bytes:
    """An archive of files; with a generator, compressed in any of the ways that there are."""
    target = io.BytesIO()
    with zipfile.ZipFile(target, "w") as archive:
        for name, content in files.items():
            method = zipfile.ZIP_STORED if random is None else pick(random, _METHODS)
            info = zipfile.ZipInfo(name)  # with the same date each time
            archive.writestr(info, content, method)
    return target.getvalue()


def zip_damaged(files: dict[str, bytes], random: Random) -> bytes:
    """An archive whose entries, headers or data were damaged."""
    files = dict(files)
    if random.random() < 0.5:
        _entries_damaged(files, random)
    data = bytearray(packed(files, random))
    if random.random() < 0.7:
        repeatedly(random, lambda: _header_damaged(data, random))
        return bytes(data)
    return bytes_damaged(bytes(data), random)


def _entries_damaged(files: dict[str, bytes], random: Random) -> None:
    """Give files other names, or others their content, or leave them out."""
    name = pick(random, sorted(files))
    kind = random.randrange(5)
    new = pick(random, (hostile.text(random), pick(random, hostile.PATHS), "a/" * 1500 + "b", name + "/", name.upper()))
    new = new.encode("utf-8", "replace").decode().partition("\x00")[0][:60000] or "?"
    if kind == 0:
        files[new] = files.pop(name)
    elif kind == 1:
        files[new] = files[name]
    elif kind == 2:
        del files[name]
        files[new] = b""
    elif kind == 3:
        files[name] = files[pick(random, sorted(files))]
    else:
        files[f"{name}/below"] = b"x"


def _header_damaged(data: bytearray, random: Random) -> None:
    """Change a number in a header, or a byte of a name, or drop the header."""
    mark = pick(random, tuple(_HEADERS))
    places = [i for i in range(len(data)) if data.startswith(mark, i)] if len(data) < 1 << 20 else []
    if not places:
        return
    at, length = pick(random, places), _HEADERS[mark]
    kind = random.randrange(4)
    if kind == 0:
        size = pick(random, (2, 2, 4))
        field = at + random.randrange(4, length - size + 1)
        number = pick(
            random, (0, 1, 8, 12, 14, 99, 2**16 - 1, 2**32 - 1, random.getrandbits(16), random.getrandbits(32))
        )
        data[field : field + size] = (number % 256**size).to_bytes(size, "little")
    elif kind == 1:
        data[at + length : at + length + 1] = pick(random, (b"\xff", b"\x00", b"/", b"\\", b".", b"\xc3"))
    elif kind == 2:
        del data[at : at + pick(random, (1, 4, length))]
    else:
        flags = at + (8 if mark == b"PK\x01\x02" else 6)
        data[flags : flags + 2] = struct.pack("<H", 1 << random.randrange(16))
