"""Which names of files of other makers may become paths, whoever uses them."""

from __future__ import annotations

import pytest

from fmus.toolchain.file_names import is_file_name, path_problem, plain_path, shown_name


@pytest.mark.parametrize(
    "name", ["a", "a/b.c", "a\\b.c", "./a", "a//b", "a/../b", "é/ü.txt", "a b", "-o", "@x", "x" * 255, "a/" * 63 + "b"]
)
def test_names_that_stay_in_their_folder_are_taken(name):
    assert path_problem(name) == ""


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("", "is empty"),
        ("././", "is empty"),
        ("a\0b", "has control characters"),
        ("a\nb", "has control characters"),
        ("..", "would leave the folder"),
        ("a/../../b", "would leave the folder"),
        ("a/../../a/b", "would leave the folder"),
        ("/a", "would leave the folder"),
        ("\\a", "would leave the folder"),
        ("\\\\server\\a", "would leave the folder"),
        ("C:\\a", "would leave the folder"),
        ("c:a", "would leave the folder"),
        ("..\\a", "would leave the folder"),
        ("x" * 256, "has a part of more than 255 bytes"),
        ("é" * 128, "has a part of more than 255 bytes"),
        ("ab/" * 400, "has more than 1000 characters"),
        ("a/" * 64 + "b", "has more than 64 folders inside each other"),
        ("a\udcffb", "cannot be written in UTF-8"),
    ],
)
def test_names_that_would_do_harm_are_not(name, reason):
    assert path_problem(name) == reason


@pytest.mark.parametrize("name", ["con", "NUL.txt", "a/aux.c", "Com1"])
def test_names_of_devices_matter_on_windows_only(name):
    assert path_problem(name, windows=True) == "names a device of Windows"
    assert path_problem(name, windows=False) == ""


def test_one_file_has_one_spelling():
    assert {plain_path(name) for name in ("a/b", "a\\b", "./a//b", "a/./b", "a/b/")} == {"a/b"}


def test_a_file_name_has_no_folders():
    assert all(map(is_file_name, ("Rectifier", "a.b-c d", "x" * 200)))
    assert not any(map(is_file_name, ("", ".", "..", "a/b", "a\\b", "../a", "a:b", "a\0", "x" * 201)))


def test_a_long_name_is_shown_by_its_beginning():
    assert shown_name("abc") == "abc"
    assert shown_name("x" * 300) == f"{'x' * 80}... (300 characters)"
