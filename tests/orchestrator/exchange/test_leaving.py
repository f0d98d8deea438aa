"""Systems with FMUs of other makers leave for other tools, and run there as they do here behind their mappings."""

from __future__ import annotations

import json
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from fmpy.validation import validate_fmu

from components.interfaces.conversion import Linear
from components.interfaces.problem import RequestError
from components.interfaces.progress import SILENT
from components.interfaces.quantity import Type
from fmus.toolchain.version import Version
from orchestrator.exchange.export import Targets, write
from orchestrator.exchange.leaving import for_other_tools
from orchestrator.loading import load
from orchestrator.mapping.mapped import Mapped
from orchestrator.scenario.options import Options
from orchestrator.stepping.whole_run import simulate
from orchestrator.system.input_table import InputColumn, InputTable
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


def test_what_other_tools_read_of_a_mapping_that_is_linear(built_fmus, tmp_path):
    """Degrees to the right at the steering wheel, by a ratio of 16; a constant becomes a value of who reads it."""
    made = load("static", right_handed(CONSTANT)(tmp_path))
    left = for_other_tools(made, tmp_path, SILENT, conversions=True).system
    assert isinstance(left.units["plant"], Fmu)
    assert left.wiring["plant.car.wheel"] == "controller.actuation.delta_f"
    assert left.transformations["plant.car.wheel"] == Linear(-16 * foreign.DEG)
    assert left.wiring["controller.ego.psi"] == "plant.car.heading"
    assert left.transformations["controller.ego.psi"].factor == pytest.approx(-1 / foreign.DEG)
    assert "controller.ego.v_x" not in left.transformations, "km/h to m/s is what the units of measurement say"
    held = {path: value for path, value in left.held.items() if path.endswith("v_y")}
    assert held == {"controller.ego.v_y": 100.0, "traffic.ego.v_y": 100.0}
    assert left.sockets.keys() == {"traffic", "controller"}


def test_an_input_that_nothing_drives_holds_what_the_mapping_or_the_file_says(built_fmus, tmp_path):
    text = LINEAR.replace('T_r = { variable = "car.force", as = "force", R_w', "T_r = { unused = true }\n#")
    held = text + '\n[constants]\n"car.force" = { value = 0.2, unit = "kN" }\n'
    for mapping, value in ((text, 0.0), (held, 200.0)):
        made = load("static", right_handed(mapping)(tmp_path))
        assert for_other_tools(made, tmp_path, SILENT, conversions=True).system.held["plant.car.force"] == value


def test_patterns_of_infinite_signals_go_along(built_fmus, tmp_path):
    made = load("static", replace(right_handed(LINEAR)(tmp_path), allow_nonfinite=["plant.state.v_*", "traffic.*"]))
    left = for_other_tools(made, tmp_path, SILENT, conversions=True).system
    assert [*left.allow_nonfinite] == ["plant.car.speed", "plant.car.drift", "traffic.*"]
    beside = for_other_tools(made, tmp_path, SILENT, conversions=False).system
    assert beside.allow_nonfinite[2:4] == ["plant_out.state.v_x", "plant_out.state.v_y"]


def test_a_unit_of_the_name_of_ours_keeps_it(built_fmus, tmp_path):
    made = load("static", right_handed(foreign.RIGHT_HANDED)(tmp_path))
    units = {**made.system.units, "plant_out": made.system.units["traffic"]}
    wiring = {**made.system.wiring, "plant_out.ego": "plant.state"}
    made = replace(made, system=replace(made.system, units=units, wiring=wiring))
    left = for_other_tools(made, tmp_path, SILENT, conversions=True).system
    assert left.wiring["plant_out.ego.x"] == "plant_out_.state.x"


@pytest.mark.parametrize("table", [True, False])
def test_what_neither_connections_nor_fmus_of_ours_can_do_is_refused(built_fmus, tmp_path, table):
    made = load("static", rate("")(tmp_path))
    system = replace(made.system, steps={"plant": Fraction(1, 2)})
    if table:
        wiring = {end: start for end, start in made.system.wiring.items() if not end.startswith("plant.")}
        held = {"plant.actuation.delta_f": 0.0, "plant.actuation.T_r": 0.0}
        column = InputColumn("plant", "actuation.T_r", 0, "plant.actuation.T_r", Type.FLOAT64, np.zeros(1), hold=True)
        file = InputTable(np.zeros(1), (column,), hold=True, file_suffix=".csv", content=b"")
        system = replace(system, wiring=wiring, held=held, steps={}, table=file)
    with pytest.raises(RequestError) as error:
        for_other_tools(replace(made, system=system), tmp_path, SILENT, conversions=True)
    assert str(error.value) == (
        "plant.actuation.T_r: found an input behind a mapping that follows a table; valid: inputs of FMUs without a"
        " mapping. Leave --input out."
        if table
        else "step of `plant`: found 1/2 macro steps, over which its mapping forms rates or integrates them; valid: the"
        " macro step. Leave out the step of its own."
    )
