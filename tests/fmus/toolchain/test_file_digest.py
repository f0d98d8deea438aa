"""The digest of a file is that of its bytes as they are now, and is computed once while they stay."""

from __future__ import annotations

import hashlib
import os

import pytest

from fmus.toolchain import file_digest
from fmus.toolchain.file_digest import digest_of


@pytest.fixture
def read(monkeypatch):
    """The files that were read."""
    paths = []

    def read(path, plain=file_digest._read):
        paths.append(path)
        return plain(path)

    monkeypatch.setattr(file_digest, "_read", read)
    return paths


def test_a_file_that_stays_is_read_once(tmp_path, read, monkeypatch):
    path = tmp_path / "file"
    path.write_bytes(b"content")
    monkeypatch.setattr(file_digest, "_SETTLED", 0.0)
    expected = hashlib.sha256(b"content").hexdigest()
    assert [digest_of(path) for _ in range(3)] == [expected] * 3
    assert read == [path]
    before = path.stat()
    path.write_bytes(b"CONTENT")  # of the same size, and dated back
    os.utime(path, ns=(before.st_atime_ns, before.st_mtime_ns))
    assert digest_of(path) == hashlib.sha256(b"CONTENT").hexdigest()


def test_one_that_has_just_been_written_is_read_each_time(tmp_path, read):
    path = tmp_path / "file"
    path.write_bytes(b"content")
    assert digest_of(path) == digest_of(path)
    assert read == [path] * 2


def test_one_that_is_not_there_is_told(tmp_path):
    with pytest.raises(FileNotFoundError):
        digest_of(tmp_path / "file")
