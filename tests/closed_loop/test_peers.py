"""Our exported systems in other tools: FMPy's ssp, Ecos and libcosim step them as our `jacobi` does.

So they do with a plant of another maker, which is behind a mapping here.
"""

from __future__ import annotations

import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from components import BLOCKS
from components.interfaces.quantity import DTYPES
from components.interfaces.record import Variable, pack
from fmus import Version
from fmus.lowering import lower
from orchestrator import SILENT, Fmu, Linear, Options, Scenario, Simulation, System, load
from orchestrator.exchange.export import Targets, write
from orchestrator.ssp import writer as ssp
from tests.orchestrator import foreign

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="Ecos and libcosim are installed on Linux only")
RUNNER = Path(__file__).parent / "peers.py"
TOOLS = ("fmpy", "ecos", "libcosim")
FOLLOWING = ("plant.tyre.", "plant.motion.")
"""Outputs that follow the inputs of the same instant"""


def run(tool: str, path: Path, ticks: int) -> pd.DataFrame:
    """All rows of another tool's run."""
    rows = path.with_suffix(f".{tool}.parquet")
    command = [sys.executable, str(RUNNER), tool, str(path), str(ticks), str(rows)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-2000:]
    return pd.read_parquet(rows)


def jacobi(scenario: Scenario, *, zeros_first: bool = False) -> pd.DataFrame:
    """Our run; in FMPy's way every input is zero in the first step, whatever the outputs are at the start."""
    with Simulation(scenario.system, h=scenario.h, until=scenario.until, algorithm="jacobi") as simulation:
        simulation.step()
        if zeros_first:
            inputs = {f"{n}.{v.name}": v for n, s in scenario.system.units.items() for v in s.interface.inputs}
            for path, variable in inputs.items():
                simulation.write(path, np.zeros(variable.shape, DTYPES[variable.quantity.type]))
            simulation.step()
            for path in inputs:
                simulation.release(path)
        simulation.run()
        return simulation.frame()


@pytest.fixture(scope="module")
def static(built_fmus, tmp_path_factory):
    made = load("static", Options(mode=Version.FMI2))
    path = tmp_path_factory.mktemp("peers") / "static.ssp"
    ssp.write(made, path)
    return made, path


@pytest.fixture(scope="module")
def runs(static):
    made, path = static
    with ThreadPoolExecutor() as pool:  # each is a process of its own, and importing takes them longest
        found = pool.map(lambda tool: run(tool, path, round(made.until / made.h)), TOOLS)
        return dict(zip(TOOLS, found, strict=True))


def difference(found: pd.DataFrame, ours: pd.DataFrame, columns: list[str]) -> float:
    gap = (found[columns].astype(float) - ours[columns].astype(float)).abs()
    return float(np.nanmax(gap.to_numpy()))


def test_libcosim_gives_the_numbers_of_our_jacobi(static, runs):
    made, _ = static
    found = runs["libcosim"]
    assert len(found) == 114
    assert found.isna().sum().sum() == 8  # obstacles.valid before the first step
    assert difference(found, jacobi(made), list(found)) <= 1e-9


def test_ecos_gives_the_numbers_of_our_jacobi(static, runs):
    made, _ = static
    found, ours = runs["ecos"], jacobi(made)
    assert len(found) == 114
    columns = [c for c in found if not c.startswith(FOLLOWING)]
    assert len(columns) == len(list(found)) - 9
    assert difference(found, ours, columns) <= 1e-9


def test_ecos_reads_outputs_once_more_after_the_inputs_of_the_same_instant(static, runs):
    """What follows the inputs at once is that of (state, actuation) of the row; in a plain Jacobi it is a step old."""
    made, _ = static
    found = runs["ecos"]
    block = BLOCKS["bicycle"]
    equations = lower(block)
    p = pack(block(**made.system.units["plant"].parameters))
    names = [e for v in made.system.units["plant"].interface.outputs for e in Variable(v.name, v.quantity).elements]
    states = found[[f"plant.state.{n}" for n in ("x", "y", "psi", "v_x", "v_y", "r")]].to_numpy()
    inputs = found[["controller.actuation.delta_f", "controller.actuation.T_r"]].to_numpy()
    expected = [np.asarray(equations.output(x, u, p)).ravel() for x, u in zip(states, inputs, strict=True)]
    np.testing.assert_allclose(found[[f"plant.{n}" for n in names]].to_numpy(), expected, rtol=0, atol=1e-9)


def test_fmpy_gives_the_numbers_of_our_jacobi_when_all_inputs_are_zero_in_the_first_step(static, runs):
    made, _ = static
    found = runs["fmpy"]
    assert len(found) == 114
    assert found.iloc[0].isna().all()
    assert not found.iloc[1:].isna().any().any()
    assert difference(found, jacobi(made, zeros_first=True), list(found)) <= 1e-9


@pytest.mark.parametrize("tool", TOOLS)
def test_the_controller_acts_one_step_late_there(runs, tool):
    """The plan of row k starts at the position of row k - 1; with `sequential` it is that of row k."""
    frame = runs[tool]
    ahead = frame["controller.plan.x[1]"].iloc[2:].to_numpy() - frame["plant.state.x"].iloc[1:-1].to_numpy()
    assert ((ahead > 2.3) & (ahead < 2.6)).all()


def test_the_delay_is_no_rounding(static, runs):
    made, _ = static
    with Simulation(made.system, h=made.h, until=made.until) as simulation:
        simulation.run()
        assert difference(runs["libcosim"], simulation.frame(), ["plant.state.y"]) > 1e-3


@pytest.mark.parametrize("tool", ["ecos", "libcosim"])
def test_linear_transformations_and_held_inputs_are_applied_there_too(built_fmus, tmp_path, tool):
    plant = built_fmus / "fmi2" / "bicycle.fmu"
    system = System(
        units={"leader": Fmu(plant), "follower": Fmu(plant, {"m": 1500.0})},
        wiring={"follower.actuation.delta_f": "leader.state.psi"},
        held={"leader.actuation.delta_f": 0.01, "leader.actuation.T_r": 10.0, "follower.actuation.T_r": 0.0},
        transformations={"follower.actuation.delta_f": Linear(0.5, 0.02)},
    )
    made = Scenario("convoy", "two vehicles", system, None, 0.1, 2.0, {})
    ssp.write(made, tmp_path / "convoy.ssp")
    found, ours = run(tool, tmp_path / "convoy.ssp", 20), jacobi(made)
    columns = [c for c in found if ".state." in c]
    assert difference(found, ours, columns) <= 1e-9
    assert abs(ours["follower.state.psi"].iloc[-1]) > 1e-3


@pytest.mark.parametrize("tool", ["ecos", "libcosim"])
@pytest.mark.parametrize("beside", [False, True], ids=["transformations", "FMUs of ours"])
def test_a_mapped_plant_drives_there_as_here(built_fmus, tmp_path, tool, beside):
    """FMUs of ours delay what they make by a step there, and here too with `jacobi`."""
    mapping = foreign.right_handed_mapping(tmp_path)
    if not beside:
        mapping.write_text(foreign.RIGHT_HANDED.replace("reference =", "# reference ="))
    asked = Options(mode=Version.FMI2, stop_time=6.0, replacements={"plant": str(mapping), "controller": "lqr"})
    write("static", asked, Targets(ssp=tmp_path / "a.ssp"), SILENT)
    found, made = run(tool, tmp_path / "a.ssp", 60), load("static", asked)
    ours = jacobi(load(tmp_path / "a.ssp") if beside else made)
    assert np.ptp(ours["controller.actuation.delta_f"]) > 1e-3
    assert difference(found, ours, ["controller.actuation.delta_f", "controller.actuation.T_r"]) <= 1e-9
    if not beside:
        theirs = found.rename(columns={"plant.car.speed": "plant.state.v_x", "plant.car.heading": "plant.state.psi"})
        theirs = theirs.assign(**{"plant.state.v_x": theirs["plant.state.v_x"] / 3.6})
        theirs = theirs.assign(**{"plant.state.psi": theirs["plant.state.psi"] / -foreign.DEG})
        assert difference(theirs, ours, ["plant.state.v_x", "plant.state.psi"]) <= 1e-9
