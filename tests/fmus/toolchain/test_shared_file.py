"""A file that two processes map keeps its size, whoever wants to change it."""

from __future__ import annotations

import mmap
import os
import sys

import pytest

from fmus.toolchain.shared_file import SharedFile, let_go


def test_the_size_is_fixed(tmp_path):
    file = SharedFile(tmp_path, "columns")
    with file.path.open("a+b") as opened:
        opened.truncate(4096)
        memory = mmap.mmap(opened.fileno(), 4096)
    file.fix()
    with file.path.open("a+b") as opened:
        opened.truncate(4096)  # as it is
        if sys.platform == "linux":
            for size in (0, 8192):
                with pytest.raises(PermissionError):
                    os.ftruncate(opened.fileno(), size)
    file.close()
    file.close()
    memory[0] = 1
    assert memory[0] == 1


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere the file has a name, and nothing is inherited")
def test_what_has_been_inherited_is_closed_once_it_is_mapped(tmp_path):
    file = SharedFile(tmp_path, "columns")
    (descriptor,) = file.descriptors
    let_go(file.path)
    with pytest.raises(OSError, match="Bad file descriptor"):
        os.fstat(descriptor)
    let_go(tmp_path / "3")  # an ordinary file is left alone
