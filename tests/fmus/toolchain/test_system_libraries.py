"""Why a library is not loaded; how it is found out of real libraries is shown with whole FMUs."""

from __future__ import annotations

import pytest

from fmus.toolchain.system_libraries import DEBIAN_PACKAGES, not_loaded


def test_one_library_that_is_missing_is_named_with_its_package():
    needed = ["libc.so.6", "libgfortran.so.3"]
    assert not_loaded("whatever", needed, ["m.so"]) == (
        "a library that needs libgfortran.so.3, which is not on this machine",
        "Install it (Debian: apt-get install libgfortran3).",
    )


def test_a_library_that_stands_beside_it_is_named_as_such():
    assert not_loaded("whatever", ["libinner.so"], ["m.so", "libinner.so"]) == (
        "a library that does not look for libinner.so in its own folder",
        "Have it linked with the run path $ORIGIN.",
    )


@pytest.mark.parametrize(
    ("reason", "found"),
    [
        (
            "/lib/libc.so.6: version `GLIBC_2.99' not found (required by m.so)",
            "a library that needs GLIBC 2.99, which is newer than that of this machine",
        ),
        ("m.so: undefined symbol: dgemm_", "a library that uses `dgemm_`, which no library has that it names"),
        ("m.so: no reason", "a library that cannot be loaded (m.so: no reason)"),
    ],
)
def test_what_the_loader_says_becomes_a_part_of_a_message(reason, found):
    assert not_loaded(reason, ["libc.so.6"], [])[0] == found


def test_packages_are_named_in_order():
    assert list(DEBIAN_PACKAGES) == sorted(DEBIAN_PACKAGES, key=str.lower)
