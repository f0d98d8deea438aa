"""Archives that are broken, or meant to do harm, are refused before anything of them is used."""

from __future__ import annotations

import os
import zipfile

import pytest

from components.interfaces.problem import RequestError
from fmus.reading import unpack

VALID = "an archive"


def archive(path, entries, method=zipfile.ZIP_DEFLATED):
    with zipfile.ZipFile(path, "w", method) as made:
        for name, content in entries.items():
            made.writestr(name, content)
    return path


def refusal(path, folder):
    folder.mkdir(exist_ok=True)
    with pytest.raises(RequestError) as error:
        unpack.unpack(path, folder, path.name, VALID)
    return str(error.value)


def test_files_and_folders_come_out_as_they_went_in(tmp_path):
    path = archive(tmp_path / "a.zip", {"a.txt": "1", "b/": "", "b/c.bin": b"\0\1", "d\\e.txt": "2"})
    folder = tmp_path / "out"
    folder.mkdir()
    unpack.unpack(path, folder, "a.zip", VALID)
    found = {p.relative_to(folder).as_posix(): p.read_bytes() for p in folder.rglob("*") if p.is_file()}
    assert found == {"a.txt": b"1", "b/c.bin": b"\0\1", "d/e.txt": b"2"}


def test_what_is_no_archive_is_refused(tmp_path):
    assert refusal(tmp_path / "none.zip", tmp_path / "o") == "none.zip: found no such file; valid: an archive"
    (tmp_path / "text.zip").write_text("hello")
    assert refusal(tmp_path / "text.zip", tmp_path / "o") == (
        "text.zip: found a file that is no zip archive; valid: an archive"
    )


def test_corrupt_archives_are_refused(tmp_path):
    path = archive(tmp_path / "a.zip", {"a.txt": "hello hello"}, zipfile.ZIP_STORED)
    content = path.read_bytes()
    path.write_bytes(content.replace(b"hello hello", b"hello hallo"))
    assert refusal(path, tmp_path / "o") == (
        "a.zip: found a corrupt archive (Bad CRC-32 for file 'a.txt'); valid: an archive. Pack or copy it again."
    )
    path.write_bytes(content[:-10])
    assert refusal(path, tmp_path / "o") == "a.zip: found a file that is no zip archive; valid: an archive"
    packed = archive(tmp_path / "b.zip", {"a.txt": bytes(range(256)) * 40})
    broken = bytearray(packed.read_bytes())
    broken[60:200] = b"\xff" * 140
    packed.write_bytes(bytes(broken))
    assert "b.zip: found a corrupt archive (Error -3 while decompressing data" in refusal(packed, tmp_path / "o")


@pytest.mark.parametrize("name", ["../evil.txt", "/evil.txt", "a/../../evil.txt", "..\\evil.txt", "C:\\evil.txt"])
def test_entries_that_would_leave_the_folder_are_refused_and_nothing_is_written(tmp_path, name):
    path = archive(tmp_path / "a.zip", {"good.txt": "1", name: "x"})
    assert refusal(path, tmp_path / "o") == (
        f"a.zip: found an entry that would leave the folder, {name}; valid: an archive"
    )
    assert list((tmp_path / "o").iterdir()) == []


def test_encrypted_entries_are_refused(tmp_path):
    path = archive(tmp_path / "a.zip", {"a.txt": "1"})
    content = bytearray(path.read_bytes())
    for signature, at in ((b"PK\3\4", 6), (b"PK\1\2", 8)):
        content[content.index(signature) + at] |= 1
    path.write_bytes(bytes(content))
    assert refusal(path, tmp_path / "o") == (
        "a.zip: found an encrypted entry, a.txt; valid: an archive. Pack it without a password."
    )


def test_links_are_refused(tmp_path):
    link = zipfile.ZipInfo("binaries/link.so")
    link.external_attr = 0o120777 << 16
    path = tmp_path / "a.zip"
    with zipfile.ZipFile(path, "w") as made:
        made.writestr(link, "/etc/passwd")
    assert refusal(path, tmp_path / "o") == (
        "a.zip: found a symbolic link, binaries/link.so; valid: an archive. Pack the file that it leads to."
    )


@pytest.mark.filterwarnings("ignore:Duplicate name")
def test_two_entries_of_one_name_are_refused_where_they_differ(tmp_path):
    path = tmp_path / "a.zip"
    with zipfile.ZipFile(path, "w") as made:
        made.writestr("a.txt", "1")
        made.writestr("a.txt", "2")
    assert refusal(path, tmp_path / "o") == (
        "a.zip: found two entries of one name with different bytes, a.txt; valid: an archive. Pack it again."
    )


@pytest.mark.filterwarnings("ignore:Duplicate name")
def test_a_file_that_stands_twice_in_an_archive_with_the_same_bytes_is_unpacked_and_told(tmp_path):
    path = tmp_path / "a.zip"
    with zipfile.ZipFile(path, "w") as made:
        for name in ("b/", "a.txt", "b/", "b/c.txt", "a.txt"):
            made.writestr(name, "1" if name.endswith("txt") else "")
    told = ("the archive has a.txt more than once, with the same bytes",)
    (tmp_path / "o").mkdir()
    assert unpack.unpack(path, tmp_path / "o", "a.zip", VALID) == told
    assert (tmp_path / "o" / "a.txt").read_text() == "1"
    assert unpack.read(path, {"a.txt"}, "a.zip", VALID).remarks == told


@pytest.mark.filterwarnings("ignore:Duplicate name")
def test_entries_that_claim_to_be_equal_are_compared_byte_by_byte(tmp_path):
    path = tmp_path / "a.zip"
    with zipfile.ZipFile(path, "w") as made:
        made.writestr("a.txt", "hello hello")
        made.writestr("a.txt", "hello hello")
    path.write_bytes(path.read_bytes().replace(b"hello hello", b"hello hallo", 1))
    assert refusal(path, tmp_path / "o").startswith("a.zip: found a corrupt archive (Bad CRC-32 for file 'a.txt')")


def test_files_can_be_read_without_unpacking_and_damage_to_others_is_noticed(tmp_path):
    path = archive(tmp_path / "a.zip", {"a.txt": "1", "b/": "", "b/c.txt": "hello hello"}, zipfile.ZIP_STORED)
    found = unpack.read(path, {"a.txt", "x"}, "a.zip", VALID)
    assert (found.names, found.files, found.remarks) == ({"a.txt", "b/c.txt"}, {"a.txt": b"1"}, ())
    assert unpack.read_file(path, "b/c.txt") == b"hello hello"
    path.write_bytes(path.read_bytes().replace(b"hello hello", b"hello hallo"))
    with pytest.raises(RequestError) as error:
        unpack.read(path, {"a.txt"}, "a.zip", VALID)
    assert str(error.value) == (
        "a.zip: found a corrupt archive (b/c.txt is damaged); valid: an archive. Pack or copy it again."
    )


def test_zip_bombs_are_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(unpack, "SUSPICIOUS_SIZE", 2**20)
    path = archive(tmp_path / "a.zip", {"a.bin": bytes(4 * 2**20)})
    text = refusal(path, tmp_path / "o")
    assert text.startswith("a.zip: found a zip bomb (4 MiB in an archive of 0.00")
    monkeypatch.setattr(unpack, "MOST_ENTRIES", 1)
    path = archive(tmp_path / "b.zip", {"a": "", "b": ""})
    assert refusal(path, tmp_path / "o") == "b.zip: found 2 entries; valid: at most 1"


def test_a_file_that_is_read_into_memory_is_no_bomb_either(tmp_path):
    path = archive(tmp_path / "a.zip", {"a.xml": bytes(5 * 2**20), "b.bin": bytes(5 * 2**20)})
    with pytest.raises(RequestError) as error:
        unpack.read(path, {"a.xml"}, "a.zip", VALID)
    assert str(error.value).startswith("a.zip: found a zip bomb (a.xml: 5 MiB out of 0.00")
    assert unpack.read(path, {"x"}, "a.zip", VALID).names == {"a.xml", "b.bin"}
    with pytest.raises(RequestError, match="a zip bomb"):
        unpack.read_file(path, "a.xml")


@pytest.mark.parametrize(
    ("entries", "found"),
    [
        (["a.txt", "a.txt/b"], "a file that is a folder, too, a.txt"),
        (["a.txt", "./a.txt"], "two entries of one name with different bytes, ./a.txt"),
        (["a/b", "a//b"], "two entries of one name with different bytes, a//b"),
        (["a\\b", "a/b"], "two entries of one name with different bytes, a/b"),
        (["x" * 300], f"an entry that has a part of more than 255 bytes, {'x' * 80}... (300 characters)"),
        (
            ["d/" * 100 + "x"],
            f"an entry that has more than 64 folders inside each other, {'d/' * 40}... (201 characters)",
        ),
        (["a\nb"], "an entry that has control characters, a\nb"),
    ],
)
def test_names_that_cannot_be_files_here_are_refused(tmp_path, entries, found):
    path = tmp_path / "a.zip"
    with zipfile.ZipFile(path, "w") as made:
        for number, name in enumerate(entries):
            made.writestr(name, str(number))
    assert refusal(path, tmp_path / "o") == f"a.zip: found {found}; valid: an archive" + (
        ". Pack it again." if "a file" in found or "two" in found else ""
    )
    assert list((tmp_path / "o").iterdir()) == []


def test_names_that_are_no_utf8_are_told(tmp_path):
    path = archive(tmp_path / "a.zip", {"é.txt": "1"})
    path.write_bytes(path.read_bytes().replace("é".encode(), b"\xff\xfe"))
    assert refusal(path, tmp_path / "o") == (
        "a.zip: found an entry whose name is not in UTF-8 as it says (b'\\xff\\xfe.txt'); valid: an archive."
        " Pack it again with another tool."
    )


def test_damage_is_told_whatever_the_method_is(tmp_path):
    for method in (zipfile.ZIP_DEFLATED, zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA):
        path = archive(tmp_path / "a.zip", {"a.txt": bytes(range(256)) * 40}, method)
        broken = bytearray(path.read_bytes())
        broken[60:200] = b"\xff" * 140
        path.write_bytes(bytes(broken))
        assert "a.zip: found a corrupt archive (" in refusal(path, tmp_path / "o")


def test_a_method_that_python_does_not_know_is_told(tmp_path):
    path = archive(tmp_path / "a.zip", {"a.txt": "1"})
    content = bytearray(path.read_bytes())
    for signature, at in ((b"PK\3\4", 8), (b"PK\1\2", 10)):
        content[content.index(signature) + at] = 93
    path.write_bytes(bytes(content))
    assert refusal(path, tmp_path / "o") == (
        "a.zip: found an entry packed by the method 93, a.txt; valid: an archive."
        " Pack it again with the method `deflate`."
    )


@pytest.mark.skipif(os.geteuid() == 0, reason="everything can be written to by root")
def test_a_folder_that_cannot_be_written_to_is_told(tmp_path):
    path = archive(tmp_path / "a.zip", {"a.txt": "1"})
    (tmp_path / "o").mkdir(mode=0o500)
    assert refusal(path, tmp_path / "o") == (
        f"{tmp_path / 'o'}: found a folder that cannot be written to (Permission denied); valid: a writable folder."
        " Name another one."
    )


def test_what_lies_in_the_temporary_folder_does_not_matter(tmp_path, monkeypatch):
    place = tmp_path / "place"
    place.mkdir()
    (place / "sources").symlink_to(tmp_path)
    monkeypatch.setattr("tempfile.tempdir", str(place))
    path = archive(tmp_path / "a.zip", {"sources/a.c": "1"})
    assert unpack.read(path, {"sources/a.c"}, "a.zip", "an archive").files == {"sources/a.c": b"1"}
