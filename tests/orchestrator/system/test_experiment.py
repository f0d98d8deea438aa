"""Algorithms, steps and stop times, and what is said of those that cannot be."""

from __future__ import annotations

import pytest

from components.interfaces.problem import RequestError
from orchestrator.system.experiment import algorithm_named


def test_an_unknown_algorithm_is_refused_with_those_there_are():
    with pytest.raises(RequestError) as error:
        algorithm_named("gauss")
    assert str(error.value) == "algorithm: found `gauss`; valid: clocked, jacobi, sequential"
