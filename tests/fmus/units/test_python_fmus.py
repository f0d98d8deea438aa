"""FMUs that pythonfmu and pythonfmu3 export are read by the strict reader and run."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from fmus.reading.opening import open_fmu
from orchestrator.stepping.whole_run import simulate
from orchestrator.system.source import Fmu
from orchestrator.system.system import System

TWO = """
from pythonfmu import Boolean, Fmi2Causality, Fmi2Slave, Fmi2Variability, Integer, Real, String


class Model(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.u, self.y, self.n, self.s, self.p = 0.0, 0.0, 3, "a", 2.0
        self.register_variable(Real("u", causality=Fmi2Causality.input))
        self.register_variable(Real("y", causality=Fmi2Causality.output))
        self.register_variable(Integer("n", causality=Fmi2Causality.output))
        self.register_variable(String("s", causality=Fmi2Causality.output))
        tunable = Fmi2Variability.tunable
        self.register_variable(Real("p", causality=Fmi2Causality.parameter, variability=tunable))

    def do_step(self, t, h):
        self.y, self.n, self.s = self.p * self.u, self.n + 1, self.s + "b"
        return True
"""
THREE = """
from pythonfmu3 import Fmi3Causality, Fmi3Slave, Fmi3Variability, Float64, Int32, String


class Model(Fmi3Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.time, self.u, self.y, self.n, self.p = 0.0, 0.0, 0.0, 3, 2.0
        continuous, tunable = Fmi3Variability.continuous, Fmi3Variability.tunable
        self.register_variable(Float64("time", causality=Fmi3Causality.independent, variability=continuous))
        self.register_variable(Float64("u", causality=Fmi3Causality.input))
        self.register_variable(Float64("y", causality=Fmi3Causality.output))
        self.register_variable(Int32("n", causality=Fmi3Causality.output))
        self.register_variable(Float64("p", causality=Fmi3Causality.parameter, variability=tunable))

    def do_step(self, t, h):
        self.y, self.n = self.p * self.u, self.n + 1
        return True
"""


@pytest.mark.parametrize(("tool", "source"), [("pythonfmu", TWO), ("pythonfmu3", THREE)])
def test_python_fmus_run(tmp_path, tool, source):
    # in one process with a name of its own: both tools import the script into our interpreter
    (tmp_path / f"{tool}_model.py").write_text(source)
    command = [sys.executable, "-m", tool, "build", "-f", f"{tool}_model.py"]
    subprocess.run(command, cwd=tmp_path, check=True, capture_output=True)
    path = Path(tmp_path, "Model.fmu")
    assert "needs the tool that made it to be installed" in open_fmu(path).remarks
    rows = simulate(System({"m": Fmu(path, {"p": 3.0})}, {}, held={"m.u": 2.0}), h=0.1, until=0.3)
    assert rows["m.y"].tolist() == [0.0, 6.0, 6.0, 6.0]
    assert rows["m.n"].tolist() == [3, 4, 5, 6]
    if tool == "pythonfmu":
        assert rows["m.s"].tolist() == ["a", "ab", "abb", "abbb"]


OWN_PROCESS = """
import json, sys
import fmpy
values = {"x_start": 2.0, "name": "slow"}
rows = fmpy.simulate_fmu(sys.argv[1], stop_time=1.0, output_interval=0.1, start_values=values)
print(json.dumps({name: rows[name].tolist() for name in rows.dtype.names}))
"""
DECAY = """
from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real, String


class Decay(Fmi2Slave):
    author = "J\u00f6rg"
    description = "x' = -3 x, by explicit Euler"

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.x, self.x_start, self.name, self.rate = 0.0, 1.0, "fast", 3.0
        self.register_variable(Real("x", causality=Fmi2Causality.output))
        given = {"causality": Fmi2Causality.parameter, "variability": Fmi2Variability.tunable}
        self.register_variable(Real("x_start", **given))
        self.register_variable(String("name", **given))

    def exit_initialization_mode(self):
        self.x, self.rate = self.x_start, {"fast": 3.0, "slow": 0.3}[self.name]

    def do_step(self, t, h):
        self.x += h * -self.rate * self.x
        return True
"""


def test_a_python_fmu_runs_as_fmpy_runs_it(tmp_path):
    (tmp_path / "decay_model.py").write_text(DECAY, "utf-8")
    build = [sys.executable, "-m", "pythonfmu", "build", "-f", "decay_model.py"]
    subprocess.run(build, cwd=tmp_path, check=True, capture_output=True)
    path = tmp_path / "Decay.fmu"
    done = subprocess.run([sys.executable, "-c", OWN_PROCESS, str(path)], check=True, capture_output=True, text=True)
    rows = simulate(System({"m": Fmu(path, {"x_start": 2.0, "name": "slow"})}, {}), h=0.1, until=1.0)
    assert rows["m.x"].tolist() == pytest.approx(json.loads(done.stdout.splitlines()[-1])["x"], abs=1e-9)
    assert rows["m.x"].tolist()[:2] == [2.0, 2.0 + 0.1 * -0.3 * 2.0]
