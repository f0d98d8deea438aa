"""Opening FMUs: one whose description has 100 000 variables, and those of the static scenario again and again.

The large one is compared with FMPy's reader of descriptions, the others with FMPy opening the same files.
"""

from __future__ import annotations

import shutil
from functools import partial

import pytest
from fmpy import extract, read_model_description
from fmpy.fmi3 import FMU3Slave

from fmus.reading import kept_files
from fmus.reading.opening import open_fmu
from fmus.toolchain import file_digest
from fmus.toolchain.version import Version
from orchestrator import Simulation, load
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


@pytest.fixture(scope="module")
def static(built_fmus):
    return load("static")


def test_fmpy_opens_the_fmus_of_static(benchmark, static):
    """Unpacking, loading, instantiating and freeing the three FMUs, and removing what was unpacked."""
    files = [source.describe().file for source in static.system.units.values()]
    descriptions = [read_model_description(str(file), validate=False) for file in files]

    def opened():
        for file, model in zip(files, descriptions, strict=True):
            folder = extract(file)
            fmu = FMU3Slave(guid=model.guid, unzipDirectory=folder, modelIdentifier=model.coSimulation.modelIdentifier)
            fmu.instantiate()
            fmu.freeInstance()
            fmu.freeLibrary()
            shutil.rmtree(folder)

    benchmark.pedantic(opened, rounds=20, warmup_rounds=1)


@pytest.mark.parametrize("known", [True, False], ids=["same process", "another process"])
def test_opening_initialising_and_closing_the_fmus_of_static(benchmark, static, known):
    """In another process nothing is known of the files, which are compared with the archives first."""

    def new():
        if not known:
            kept_files._compared.clear()
            file_digest._known.cache_clear()
        return (Simulation(static.system, h=static.h, until=static.until),), {}

    def opened(simulation):
        simulation.open()
        simulation.close()

    benchmark.pedantic(opened, setup=new, rounds=50, warmup_rounds=2)
    benchmark.extra_info["budget"] = "3 ms on a quiet machine" if known else "20 ms on a quiet machine"


def test_resetting_the_fmus_of_static_with_other_parameters(benchmark, static):
    """FMI's reset of the three, and all parameters set anew up to Initialization Mode."""
    with Simulation(static.system, h=static.h, until=static.until) as simulation:
        units = simulation._running.by_name
        values = {name: {**source.parameters} for name, source in static.system.units.items()}

        def reset():
            values["plant"]["m"] += 1.0
            for name, unit in units.items():
                unit.reset()
                unit.enter_initialization(values[name])

        benchmark.pedantic(reset, rounds=200, warmup_rounds=2)
        simulation._running._initialised.clear()
    benchmark.extra_info["budget"] = "0.2 ms on a quiet machine"


def test_resetting_a_simulation(benchmark, static):
    """The whole way back to the first instant, with the initialisation of all units."""
    with Simulation(static.system, h=static.h, until=static.until) as simulation:
        benchmark.pedantic(simulation.reset, args=({"plant.m": 1700.0},), rounds=200, warmup_rounds=2)
