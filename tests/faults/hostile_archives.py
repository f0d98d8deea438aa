"""Archives that are damaged, or made to do harm: each is refused in words, and nothing comes out of its folder."""

from __future__ import annotations

import io
import struct
import warnings
import zipfile
from collections.abc import Callable
from functools import partial
from pathlib import Path
from random import Random

from components.interfaces.problem import RequestError
from fmus.reading.opening import open_fmu
from fmus.reading.unpack import unpack
from fmus.toolchain.version import Version
from orchestrator.ssp import reader
from tests.faults.scoring import fault
from tests.fmus.foreign import description2, scalar
from tests.orchestrator.ssps import body, component, echo_library, ssd

GROUP = "hostile archives"
DESCRIPTION = description2(
    [scalar("u", 1, "input", of_start="0"), scalar("y", 101, "output")], ['<Unknown index="2"/>']
)
LOCAL, CENTRAL, END = b"PK\3\4", b"PK\1\2", b"PK\5\6"
Entry = tuple[str | zipfile.ZipInfo, bytes | str]


def archive(*entries: Entry, method: int = zipfile.ZIP_DEFLATED, good: bool = True) -> bytes:
    """A zip archive: a good FMU, unless it is not wanted, and entries."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", method) as made, warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of names that stand twice
        if good:
            made.writestr("modelDescription.xml", DESCRIPTION)
            made.writestr("binaries/linux64/m.so", echo_library(Version.FMI2).read_bytes())
        for name, content in entries:
            made.writestr(name, content)
    return stream.getvalue()


def patched(content: bytes, signature: bytes, at: int, value: bytes, last: bool = True) -> bytes:  # noqa: FBT001, FBT002
    """An archive with other bytes in the last (or first) header of a kind."""
    place = (content.rindex if last else content.index)(signature) + at
    return content[:place] + value + content[place + len(value) :]


def both(content: bytes, local: int, central: int, value: bytes) -> bytes:
    """An archive with other bytes in both headers of its last entry."""
    return patched(patched(content, LOCAL, local, value), CENTRAL, central, value)


def linked(name: str, mode: int) -> zipfile.ZipInfo:
    """An entry with a mode of Unix."""
    entry = zipfile.ZipInfo(name)
    entry.create_system, entry.external_attr = 3, mode << 16
    return entry


def many(number: int) -> bytes:
    """An archive with very many empty files."""
    return archive(*((f"{n}", b"") for n in range(number)), good=False)


def nested(depth: int, width: int) -> bytes:
    """An SSP in which `width` components are the next one, and so on."""
    inner = b""
    for _ in range(depth):
        used = "".join(
            component(f"c{k}", "i.ssp", attributes='type="application/x-ssp-package"')
            for k in range(width if inner else 0)
        )
        entries: list[Entry] = [
            ("SystemStructure.ssd", ssd(body(used))),
            *([("resources/i.ssp", inner)] if inner else []),
        ]
        inner = archive(*entries, good=False)
    return inner


def source(name: str) -> bytes:
    """An SSP with one component."""
    text = ssd(body('<ssd:Component name="a" source="X"/>')).replace('"X"', f'"{name}"')
    return archive(("SystemStructure.ssd", text), ("resources/a.fmu", archive()), good=False)


def identifier(name: str) -> bytes:
    """An FMU with a model identifier and sources."""
    text = DESCRIPTION.replace('modelIdentifier="m"', f'modelIdentifier="{name}"')
    return archive(("modelDescription.xml", text), ("sources/all.c", "int x;"), good=False)


def lied(size: int) -> bytes:
    """An archive whose last entry has another size than it says."""
    content = archive(("resources/a.bin", b"abc" * 1000))
    return both(content, 22, 24, struct.pack("<I", size))


RANDOM = bytes(Random(0).randbytes(3000))  # noqa: S311 - repeatable
FMUS: dict[str, tuple[Callable[[], bytes], str]] = {
    "entry ..": (lambda: archive(("../x", "1")), "would leave the folder, ../x"),
    "entry deep ..": (lambda: archive(("a/b/../../../x", "1")), "would leave the folder"),
    "entry absolute": (lambda: archive(("/tmp/x", "1")), "would leave the folder"),  # noqa: S108
    "entry with backslashes ..": (lambda: archive(("..\\..\\x", "1")), "would leave the folder"),
    "entry with a drive": (lambda: archive(("C:\\x", "1")), "would leave the folder"),
    "entry of a network": (lambda: archive(("\\\\host\\share\\x", "1")), "would leave the folder"),
    "entry that leaves and comes back": (lambda: archive(("a/../../o/x", "1")), "would leave the folder"),
    "folder ..": (lambda: archive(("../d/", "")), "would leave the folder"),
    "link": (lambda: archive((linked("l", 0o120777), "/etc/passwd")), "a symbolic link, l"),
    "link to a folder, and a file in it": (
        lambda: archive((linked("l", 0o120777), "/"), ("l/x", "1")),
        "a symbolic link, l",
    ),
    "name of control characters": (lambda: archive(("a\r\nb", "1")), "has control characters"),
    "escape sequence in a name": (lambda: archive(("a\x1b[2Jb", "1")), "has control characters"),
    "name of 300 characters": (lambda: archive(("x" * 300, "1")), "has a part of more than 255 bytes"),
    "name of 60 000 characters": (lambda: archive(("x" * 60_000, "1")), "has more than 1000 characters"),
    "folders 400 deep": (lambda: archive(("d/" * 400 + "x", "1")), "folders inside each other"),
    "name that is no UTF-8": (lambda: archive(("é" * 3, "1")).replace("é".encode(), b"\xff\xfe"), "not in UTF-8"),
    "file that is a folder": (lambda: archive(("r", "1"), ("r/x", "2")), "a file that is a folder, too, r"),
    "description twice": (lambda: archive(("modelDescription.xml", "<a/>")), "two entries of one name"),
    "description twice, spelled otherwise": (
        lambda: archive((".//modelDescription.xml", "<a/>")),
        "two entries of one",
    ),
    "library twice": (lambda: archive(("binaries\\linux64/m.so", "x")), "two entries of one name"),
    "encrypted": (lambda: both(archive(("a", "1")), 6, 8, b"\1\0"), "an encrypted entry, a"),
    "method deflate64": (lambda: both(archive(("a", "1")), 8, 10, b"\x09\0"), "packed by the method 9, a"),
    "method zstandard": (lambda: both(archive(("a", "1")), 8, 10, b"\x5d\0"), "packed by the method 93, a"),
    "method unknown": (lambda: both(archive(("a", "1")), 8, 10, b"\xff\xff"), "packed by the method 65535, a"),
    "damaged deflate": (lambda: archive(("a", RANDOM)).replace(RANDOM[50:60], b"\0" * 10), "a corrupt archive"),
    "damaged bzip2": (
        lambda: patched(archive(("a", RANDOM), method=zipfile.ZIP_BZIP2), LOCAL, 90, b"\xff" * 40),
        "a corrupt archive",
    ),
    "damaged LZMA": (
        lambda: patched(archive(("a", RANDOM), method=zipfile.ZIP_LZMA), LOCAL, 60, b"\xff" * 40),
        "a corrupt archive",
    ),
    "LZMA with wrong properties": (
        lambda: patched(archive(("a", RANDOM), method=zipfile.ZIP_LZMA), LOCAL, 35, b"\xff" * 5),
        "a corrupt archive",
    ),
    "wrong CRC": (lambda: both(archive(("a", "1")), 14, 16, b"\1\2\3\4"), "a corrupt archive (a is damaged)"),
    "size too small": (lambda: lied(10), "a corrupt archive"),
    "size too large": (lambda: lied(10_000), "a corrupt archive"),
    "size of 4 GB": (lambda: lied(2**32 - 2), "a zip bomb"),
    "place of an entry beyond the end": (
        lambda: patched(archive(("a", "1")), CENTRAL, 42, b"\xff\xff\xff\x7f"),
        "a corrupt archive",
    ),
    "two names for one entry": (lambda: patched(archive(("a", "1")), CENTRAL, 46, b"b"), "a corrupt archive"),
    "central directory beyond the end": (lambda: patched(archive(), END, 16, b"\xff\xff\xff\x7f"), "zip archive"),
    "wrong number of entries": (lambda: patched(archive(), END, 8, b"\xff\x7f\xff\x7f"), ""),
    "cut in half": (lambda: archive()[:4000], "no zip archive"),
    "end alone": (lambda: END + bytes(18), "an archive without modelDescription.xml"),
    "empty file": (lambda: b"", "no zip archive"),
    "text": (lambda: b"<a/>" * 1000, "no zip archive"),
    "200 000 entries": (lambda: many(200_000), "200000 entries; valid: at most 100000"),
    "zeros without end": (lambda: archive(("a", bytes(300 * 2**20))), "a zip bomb (300 MiB in an archive of"),
    "description of 40 MiB in 40 kB": (
        lambda: archive(("modelDescription.xml", b"<a>" + b"<b/>" * 10_000_000), good=False),
        "a zip bomb (modelDescription.xml: 38 MiB out of",
    ),
    "elements that take 900 MiB": (
        lambda: archive(("modelDescription.xml", b"<a>" + b"<b/>" * 7_500_000), method=0, good=False),
        "XML whose elements would take",
    ),
    "identifier ..": (lambda: identifier("../../x"), "the modelIdentifier `../../x`"),
    "identifier absolute": (lambda: identifier("/tmp/x"), "the modelIdentifier `/tmp/x`"),  # noqa: S108
    "identifier of a folder": (lambda: identifier("a\\b"), "the modelIdentifier `a\\b`"),
    "identifier without end": (lambda: identifier("m" * 5000), "the modelIdentifier `mmmm"),
}
LONG = ("200 000 entries",)
"""Those that take more than a few seconds."""
SSPS: dict[str, tuple[Callable[[], bytes], str]] = {
    "bomb of SSPs in SSPs": (lambda: nested(8, 10), "becomes more than 1000 systems from other places"),
    "SSPs 60 deep": (lambda: nested(60, 1), "systems without a circle"),
    "source ..": (lambda: source("../../a.fmu"), "`../../a.fmu`, which leaves the archive"),
    "source absolute": (lambda: source("/etc/passwd"), "`/etc/passwd`, which leaves the archive"),
    "source encoded ..": (lambda: source("%2e%2e/%2e%2e/etc/passwd"), "which leaves the archive"),
    "source of half an address": (lambda: source("http://["), "the address `http://[`"),
    "source file:": (lambda: source("file:///etc/passwd"), "the address `file:///etc/passwd`"),
    "source without end": (lambda: source("a" * 5000), "which has more than 1000 characters"),
    "source 900 deep": (lambda: source("d/" * 450 + "x"), "folders inside each other"),
    "source that is a folder": (lambda: source("resources"), "the file `resources`, which is not there"),
    "source with a null": (lambda: source("a%00b"), "which has control characters"),
}


def read_fmu(path: Path, folder: Path) -> None:
    """Read an FMU as a lenient reader does, and unpack it."""
    open_fmu(path, lenient=True)
    unpack(path, folder, path.name, "an FMU")


def read_ssp(path: Path, _folder: Path) -> None:
    """Read a system."""
    reader.read(path)


def stand(make: Callable[[], bytes], words: str, suffix: str, folder: Path, _random: Random) -> None:
    """The archive is refused with these words, or taken where there are none; nothing lies where it does not belong."""
    outer = folder / "a" / "b"
    (inner := outer / "o").mkdir(parents=True)
    path = outer / f"theirs{suffix}"
    path.write_bytes(make())
    refusal = ""
    try:
        (read_ssp if suffix == ".ssp" else read_fmu)(path, inner)
    except RequestError as error:
        refusal = str(error)
    assert words in refusal, refusal
    assert bool(words) == bool(refusal), refusal
    assert [*folder.iterdir()] == [folder / "a"]
    assert {p.name for p in outer.iterdir()} == {"o", path.name}
    assert not (words and [*inner.rglob("*")])


for _suffix, _known in ((".fmu", FMUS), (".ssp", SSPS)):
    for _name, (_make, _words) in _known.items():
        fault(GROUP, _name, short=_name not in LONG)(partial(stand, _make, _words, _suffix))
