"""Names of platforms, and where a binary for one lies."""

from __future__ import annotations

import platform
import sys

import pytest

from fmus.toolchain.platform_names import binary_path, platform_tuple
from fmus.toolchain.version import Version


@pytest.mark.parametrize(
    ("system", "processor", "known", "fmi2"),
    [
        ("linux", "x86_64", "x86_64-linux", "binaries/linux64/bicycle.so"),
        ("linux", "aarch64", "aarch64-linux", "binaries/aarch64-linux/bicycle.so"),
        ("darwin", "arm64", "aarch64-darwin", "binaries/darwin64/bicycle.dylib"),
        ("darwin", "x86_64", "x86_64-darwin", "binaries/darwin64/bicycle.dylib"),
        ("win32", "AMD64", "x86_64-windows", "binaries/win64/bicycle.dll"),
    ],
)
def test_names(monkeypatch: pytest.MonkeyPatch, system: str, processor: str, known: str, fmi2: str) -> None:
    monkeypatch.setattr(sys, "platform", system)
    monkeypatch.setattr(platform, "machine", lambda: processor)
    assert platform_tuple() == known
    assert binary_path(Version.FMI2, "bicycle") == fmi2
    assert binary_path(Version.FMI3, "bicycle").startswith(f"binaries/{known}/bicycle.")
