"""Opening an FMU whose description has 100 000 variables, which is read once, against FMPy's reader of descriptions."""

from __future__ import annotations

from functools import partial

import pytest
from fmpy import read_model_description

from fmus.reading.opening import open_fmu
from fmus.toolchain.version import Version
from tests.fmus.foreign import description2, library, pack, scalar

VARIABLES = 100_000
BUDGET = "twice the time of FMPy's read_model_description in the same run"


@pytest.fixture(scope="module")
def large(tmp_path_factory):
    """An FMU with parameters, of which every tenth is an output instead."""
    folder = tmp_path_factory.mktemp("large")
    variables = [
        scalar(f"part{i // 100}.v{i % 100}", i, "parameter", variability="fixed", of_start="1")
        if i % 10
        else scalar(f"part{i // 100}.v{i % 100}", i, "output")
        for i in range(VARIABLES)
    ]
    outputs = [f'<Unknown index="{i + 1}" dependencies=""/>' for i in range(0, VARIABLES, 10)]
    text = description2(variables, outputs, initial=outputs)
    binary = library(folder, Version.FMI2, '#include "echo2.c"')
    return pack(folder / "m.fmu", Version.FMI2, text, binary)


@pytest.mark.parametrize("reader", [read_model_description, open_fmu], ids=["fmpy", "open_fmu"])
def test_opening(benchmark, large, reader):
    """One reading of the file."""
    benchmark.pedantic(partial(reader, large), rounds=5, warmup_rounds=1)
    benchmark.extra_info["budget"] = BUDGET
