"""The library of the native stepper, and where it is kept (`kept_libraries.py`)."""

from __future__ import annotations

import ctypes
import os

import pytest

from fmus.toolchain import stepper_library as module
from fmus.toolchain.compiler import Compiler, find_compiler
from fmus.toolchain.kept_libraries import kept_library
from orchestrator.stepping.master import Simulation
from orchestrator.stepping.python_stepper import PythonStepper
from tests.orchestrator.blocks import Sum, system

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="there is no compiler")


@pytest.fixture(autouse=True)
def fresh(tmp_path, monkeypatch):
    """A process that has not looked for the library, with a cache of its own."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setattr(module, "_loaded", [])


def kept():
    return list(kept_library("any").parent.glob("*.library"))


def test_it_is_compiled_once_and_kept(monkeypatch):
    first = module.stepper_library()
    assert isinstance(first.library, ctypes.CDLL)
    assert module.stepper_library() is first
    (file,) = kept()
    monkeypatch.setattr(module, "_loaded", [])
    monkeypatch.setattr(Compiler, "compile", None)  # it would be called
    assert module.stepper_library().library._name == str(file)


def test_a_damaged_one_is_compiled_again():
    module.stepper_library()
    (file,) = kept()
    file.unlink()  # this process has it loaded: writing to it would be writing to what it runs
    file.write_bytes(b"no library")
    module._loaded.clear()
    assert module.stepper_library().library is not None
    assert file.stat().st_size > 1000


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_a_cache_that_cannot_be_written_is_done_without(tmp_path):
    (tmp_path / "cache").mkdir(mode=0o500)
    assert module.stepper_library().library is not None


def test_a_cache_that_is_a_file_is_done_without(tmp_path):
    (tmp_path / "cache").write_text("in the way")
    assert module.stepper_library().library is not None


def test_without_a_compiler_python_steps_and_nothing_is_said(monkeypatch):
    monkeypatch.setenv("PATH", "")
    monkeypatch.delenv("CC", raising=False)
    assert module.stepper_library() == module.StepperLibrary(None)
    simulation = Simulation(system({"s": Sum()}, {"s.a": "s.b"}), h=1.0, until=2.0)
    simulation.run()
    assert (type(simulation._stepper), simulation.remarks) == (PythonStepper, [])


def test_a_compiler_that_fails_leaves_it_to_python_and_is_told(tmp_path, monkeypatch):
    script = tmp_path / "broken"
    script.write_text('#!/bin/sh\n[ "$1" = --version ] && echo broken 1.0 && exit 0\necho "no room" >&2\nexit 4\n')
    script.chmod(0o755)
    monkeypatch.setenv("CC", str(script))
    simulation = Simulation(system({"s": Sum()}, {"s.a": "s.b"}), h=1.0, until=2.0)
    simulation.run()
    assert type(simulation._stepper) is PythonStepper
    (remark,) = simulation.remarks
    assert remark.startswith(f"stepped by Python, which is slower: {script} failed (4) on ")
    assert simulation.columns()["s.b.value"].tolist() == [1.0, 2.0, 4.0]
