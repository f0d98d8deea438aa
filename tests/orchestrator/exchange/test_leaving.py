"""Systems with FMUs of other makers leave for other tools, and run there as they do here behind their mappings."""

from __future__ import annotations

import json

import numpy as np
import pytest
from fmpy.validation import validate_fmu

from components.interfaces.progress import SILENT
from fmus.toolchain.version import Version
from orchestrator.exchange.export import Targets, write
from orchestrator.loading import load
from orchestrator.mapping.mapped import Mapped
from orchestrator.scenario.options import Options
from orchestrator.stepping.whole_run import simulate
from orchestrator.system.source import Fmu
from tests.orchestrator import foreign
from tests.orchestrator.exchange.test_container import FOLLOWING
from tests.orchestrator.exchange.test_container import run as run_in_fmpy

LINEAR = foreign.RIGHT_HANDED.replace("reference =", "# reference =")
LIMITED = LINEAR.replace("ratio =", 'max = { value = 10, unit = "deg" }, ratio =')
CONSTANT = LINEAR.replace('"car.drift"', '{ constant = { value = 360, unit = "km/h" } }')
RATE = """
fmu = "rate_car.fmu"
[state]
velocity = "speed_and_slip"
v = "y.v"
beta = "y.beta"
[actuation]
delta_f = { variable = "u.steer_rate", as = "steering_rate" }
T_r = { variable = "u.accel", as = "acceleration", R_w = { value = 30, unit = "cm" }, m = { value = 2, unit = "t" } }
"""


def options(plant="bicycle", **replacements):
    units = {"plant": str(plant), "controller": "lqr", **replacements}
    return Options(mode=Version.FMI2, stop_time=6.0, replacements=units)


def right_handed(text):
    def made(folder):
        path = foreign.right_handed_mapping(folder)
        path.write_text(text)
        return options(path)

    return made


def rate(more):
    def made(folder):
        foreign.made(foreign.RateCar, folder)
        path = folder / "rate.toml"
        path.write_text(RATE.replace('"steering_rate"', f'"steering_rate"{more}'))
        return options(path)

    return made


def traffic_of_structures(folder):
    """Traffic whose arrays are single variables, three vehicles of which are taken."""

    def flat(name):
        bus, _, rest = name.partition(".")
        leaf, _, index = rest.partition("[")
        return f"{bus}[{index[:-1]}].{leaf}"

    source = load("static", options()).system.units["traffic"].describe().file
    names = {e: flat(e) for v in Fmu(source).interface.outputs for e in v.elements}
    theirs = foreign.relabelled(source, folder / "cars.fmu", names)
    leaves = ("valid", "id", "x", "y", "psi", "v", "length", "width")
    lines = [f"{n} = {{ variable = {json.dumps([f'obstacles[{i}].{n}' for i in (1, 2, 3)])} }}" for n in leaves]
    path = folder / "cars.toml"
    path.write_text("\n".join([f'fmu = "{theirs.name}"', "[obstacles]", *lines, ""]))
    return options(traffic=str(path))


def without_dependencies(folder):
    """Our plant and our traffic, whose files do not say what their outputs depend on."""
    units = load("static", options()).system.units
    files = {n: units[n].describe().file for n in ("plant", "traffic")}
    silent = {n: foreign.relabelled(file, folder / f"{n}.fmu", silent=True) for n, file in files.items()}
    return options(silent["plant"], traffic=str(silent["traffic"]))


CASES = {
    "linear": (right_handed(LINEAR), ["plant"]),
    "a constant": (right_handed(CONSTANT), ["plant"]),
    "arrays of structures": (traffic_of_structures, ["traffic"]),
    "no dependencies": (without_dependencies, []),
    "rear axle": (right_handed(foreign.RIGHT_HANDED), ["plant", "plant_out"]),
    "a limit": (right_handed(LIMITED), ["plant", "plant_in"]),
    "a rate": (rate(""), ["plant", "plant_out", "plant_in"]),
    "a rate with its angle": (rate(', angle = "y.delta"'), ["plant", "plant_out", "plant_in"]),
    "a limited rate": (rate(', limit = { value = 1, unit = "deg/s" }'), ["plant", "plant_out", "plant_in"]),
}
"""The request of each case, and the units of the SSP that have other signals than those of the scenario."""


def by_its_variables(made, frame, name):
    """The columns of a mapped unit's signals, from those of the FMU's own variables; conventions are left out."""
    source = made.system.units[name]
    signals = {v.name: v for v in source.interface.outputs}
    variables = {v.name: v for v in source.fmu.interface.outputs}
    for link in source.fitting.adaptation.outputs:
        if link.signal.partition(".")[0] in source.fitting.adaptation.conventions:
            continue
        for element, (theirs, i) in zip(signals[link.signal].elements, link.theirs, strict=False):
            yield f"{name}.{element}", link.relation(frame[f"{name}.{variables[theirs].elements[i]}"].astype(float))


def assert_same(made, found, expected, *, late=(), tolerance=0.0):
    """All columns of a run here, as what left shows them; the units in `late` show a row later what they computed."""
    shown = {name: found[name].astype(float) for name in found if name in expected}
    for name, source in made.system.units.items():
        if isinstance(source, Mapped) and f"{name}.{source.interface.outputs[0].name}" not in shown:
            shown |= by_its_variables(made, found, name)
        out = {f"{name}.{c.partition('.')[2]}": found[c].astype(float) for c in found if c.startswith(f"{name}_out.")}
        late = (*late, *(out if late else ()))
        shown |= out
    assert {"plant.state.x", "controller.actuation.delta_f", "traffic.obstacles.x[1]"} <= shown.keys()
    for name, column in shown.items():
        rows = slice(1, None) if name.startswith(tuple(late)) else slice(None)
        wanted = expected[name].astype(float).to_numpy()[: len(column.to_numpy()[rows])]
        np.testing.assert_allclose(column.to_numpy()[rows], wanted, rtol=0, atol=tolerance, err_msg=name)


def run(made):
    return simulate(made.system, h=made.h, until=made.until)


@pytest.mark.parametrize("case", CASES)
def test_an_ssp_comes_back_with_the_numbers_of_the_run(built_fmus, tmp_path, case):
    """Where connections say it all, to the bit; FMUs of ours round as the C library does."""
    request, changed = CASES[case]
    asked = request(tmp_path)
    made = load("static", asked)
    write("static", asked, Targets(ssp=tmp_path / "a.ssp"), SILENT)
    back = load(tmp_path / "a.ssp")
    assert not any(isinstance(source, Mapped) for source in back.system.units.values())
    assert [n for n in back.system.units if n not in back.system.sockets] == changed
    expected = run(made)
    assert np.ptp(expected["controller.actuation.delta_f"]) > 1e-3
    beside = any(n.endswith(("_in", "_out")) for n in changed)
    assert_same(made, run(back), expected, tolerance=1e-12 if beside else 0.0)


@pytest.mark.parametrize("case", CASES)
def test_a_container_has_the_numbers_of_the_run_here_and_in_fmpy(built_fmus, tmp_path, case):
    asked = CASES[case][0](tmp_path)
    made = load("static", asked)
    path = tmp_path / "a.fmu"
    write("static", asked, Targets(container=path), SILENT)
    assert validate_fmu(str(path)) == []
    # what follows the inputs of the same instant, sequential shows at the end of the step
    expected = run(made)
    expected = expected[[c for c in expected if not c.startswith(FOLLOWING)]]
    here = run(load(path, Options(stop_time=made.until)))
    assert_same(
        made, here.rename(columns=lambda c: c.removeprefix("fmu.")), expected, late=("controller.",), tolerance=1e-9
    )
    assert_same(made, run_in_fmpy(path, made), expected, late=("controller.",), tolerance=1e-9)
