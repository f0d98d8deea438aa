"""Messages reach the instance that they are of, by its environment, or else by its name."""

from __future__ import annotations

import pytest

from fmus.units import fmi2_logger
from fmus.units.fmi2_logger import formatting_logger, register, release


@pytest.fixture
def two():
    heard = {"a": [], "b": []}
    keys = {name: register(name, lambda *said, name=name: heard[name].append(said)) for name in heard}
    yield keys, heard
    for key in keys.values():
        release(key)


def test_each_instance_hears_its_own_messages(two):
    keys, heard = two
    fmi2_logger._logged(keys["a"], b"a", 3, b"logStatusError", b"wrong")
    fmi2_logger._logged(keys["b"], b"a", 1, b"", None)
    assert heard == {"a": [(3, b"wrong")], "b": [(1, b"")]}


def test_an_fmu_that_does_not_pass_its_environment_on_is_known_by_its_name(two):
    _, heard = two
    fmi2_logger._logged(None, b"b", 2, b"", b"discarded")
    assert heard == {"a": [], "b": [(2, b"discarded")]}


def test_a_message_of_nobody_is_dropped(two):
    keys, heard = two
    release(keys["a"])
    fmi2_logger._logged(keys["a"], b"a", 3, b"", b"late")
    fmi2_logger._logged(None, None, 3, b"", b"whose?")
    assert heard == {"a": [], "b": []}
    assert formatting_logger() is formatting_logger()
