from __future__ import annotations

import subprocess
import sys

import pytest

CODE = "from fmus.toolchain.memory_limit import *; memory_limit(2**31)(); {more}; print('in time')"


def run(more, before=""):
    command = [sys.executable, "-c", before + CODE.format(more=more)]
    return subprocess.run(command, capture_output=True, text=True, check=False)


@pytest.mark.skipif(sys.platform != "linux", reason="other systems do not keep to it")
def test_a_process_gets_no_more_memory_than_it_may_have():
    assert run("bytearray(2**20)").stdout == "in time\n"
    done = run("bytearray(2**32)")
    assert done.returncode == 1
    assert "MemoryError" in done.stderr


@pytest.mark.skipif(sys.platform != "linux", reason="other systems do not keep to it")
def test_a_lower_limit_stays():
    before = "import resource; resource.setrlimit(resource.RLIMIT_AS, (2**30, 2**30)); "
    assert run("print(resource.getrlimit(resource.RLIMIT_AS)[0] == 2**30)", before).stdout == "True\nin time\n"


@pytest.mark.skipif(sys.platform == "win32", reason="there are none")
def test_no_core_file_is_written():
    assert run("without_core_files(); import resource; print(resource.getrlimit(resource.RLIMIT_CORE))").stdout == (
        "(0, 0)\nin time\n"
    )
