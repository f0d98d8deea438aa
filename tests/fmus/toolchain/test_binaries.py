"""What a file of machine code says of itself, on libraries that are compiled here and on headers of other systems."""

from __future__ import annotations

import struct
import subprocess

import pytest

from fmus.toolchain.binaries import MachineCode, machine_code
from fmus.toolchain.compiler import required_compiler
from fmus.toolchain.platform_names import platform_tuple

SOURCE = """
#include <math.h>
double seen(double x) { return fmod(x, 3.0); }
static int hidden(void) { return 1; }
int also_seen(void) { return hidden(); }
"""


def compiled(folder, *options):
    (folder / "m.c").write_text(SOURCE)
    target = folder / "made"
    subprocess.run([*required_compiler().command, str(folder / "m.c"), *options, "-o", str(target), "-lm"], check=True)
    return target.read_bytes()


def test_a_library_names_its_platform_its_functions_and_what_it_needs(tmp_path):
    code = machine_code(compiled(tmp_path, "-shared", "-fPIC", "-Wl,--no-as-needed"))
    assert code.platforms == (platform_tuple(),)
    assert code.problem == ""
    assert code.exports is not None
    assert {"seen", "also_seen"} <= code.exports
    assert not {"hidden", "fmod"} & code.exports
    assert set(code.needed) >= {"libc.so.6", "libm.so.6"}


def test_machine_code_that_is_no_shared_library_is_told_as_what_it_is(tmp_path):
    assert machine_code(compiled(tmp_path, "-c")).problem == "a file of machine code that is no shared library"
    assert machine_code(b"!<arch>\nm.o/").problem == "a static library"


def elf(machine, *, wide=True, order="<"):
    """The header of a shared library without sections."""
    start = b"\x7fELF" + bytes([2 if wide else 1, 1 if order == "<" else 2, 1]) + bytes(9)
    return (start + struct.pack(f"{order}HH", 3, machine)).ljust(64, b"\0")


def pe(machine):
    """The header of a DLL."""
    return b"MZ".ljust(0x3C, b"\0") + struct.pack("<I", 0x80) + bytes(0x40) + b"PE\0\0" + struct.pack("<H", machine)


@pytest.mark.parametrize(
    ("content", "platforms"),
    [
        (elf(62), ("x86_64-linux",)),
        (elf(183), ("aarch64-linux",)),
        (elf(3, wide=False), ("x86-linux",)),
        (elf(21, order=">"), ("ppc64-linux",)),
        (elf(999), ("processor 999-linux",)),
        (pe(0x8664), ("x86_64-windows",)),
        (pe(0x14C), ("x86-windows",)),
        (struct.pack("<II", 0xFEEDFACF, 0x0100000C), ("aarch64-darwin",)),
        (
            struct.pack(">II", 0xCAFEBABE, 2) + struct.pack(">5I", 0x01000007, *[0] * 4) * 2,
            ("x86_64-darwin", "x86_64-darwin"),
        ),
    ],
)
def test_the_platform_is_read_of_the_header(content, platforms):
    assert machine_code(content).platforms == platforms


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        (b"", "an empty file"),
        (b"\x7fELF", "a damaged library"),
        (b"\x7fELF nothing of the kind", "a damaged library"),
        (b"MZ", "a damaged library"),
        (b"version https://git-lfs.github.com/spec/v1\n", "a pointer of Git LFS instead of the file itself"),
        (b"Not found\n<html>", "a text (`Not found`)"),
        (b"x" * 90, f"a text (`{'x' * 40}...`)"),
        (b"\xff\xfe\x00\x00", "a file that is no library"),
        (b"x", "a text (`x`)"),
        (struct.pack(">II", 0xCAFEBABE, 55), "a file that is no library"),  # a Java class
    ],
)
def test_what_is_no_library_is_told_as_what_it_is(content, problem):
    assert machine_code(content) == MachineCode(problem=problem)


def test_a_library_that_is_cut_anywhere_is_read_or_told_as_damaged(tmp_path):
    content = compiled(tmp_path, "-shared", "-fPIC")
    for end in range(0, len(content), 97):
        code = machine_code(content[:end])
        assert code.platforms == (platform_tuple(),) or code.problem
