"""`macrostep check`: what a file is, which socket it fits, what is missing, and a template for the rest.

Shows `check.py` and `fmu_in_words.py`.
"""

from __future__ import annotations

import re
import tomllib

import pytest

from components.interfaces.problem import RequestError
from components.interfaces.sockets import SOCKETS
from fmus.toolchain.version import Version
from orchestrator.exchange.check import check
from orchestrator.mapping.mapping_reader import read_mapping
from orchestrator.mapping.template import write_template
from orchestrator.scenario.options import Options
from orchestrator.scenario.prepare import prepare
from orchestrator.ssp import writer as ssp
from orchestrator.system.experiment import Scenario
from orchestrator.system.source import Fmu
from orchestrator.system.system import System
from tests.fmus.foreign import copied, description2, entries, library, pack, scalar
from tests.fmus.makers import maker_fmu
from tests.fmus.modelica.conftest import PLANT
from tests.orchestrator import foreign, ssps


@pytest.fixture
def theirs(in_tmp_path):
    """The right-handed car in the working folder."""
    return foreign.right_handed(in_tmp_path)


def test_an_fmu_is_described(theirs, macrostep):
    code, out, err = macrostep("check", "theirs.fmu")
    assert (code, err) == (0, "")
    assert out.startswith("theirs.fmu: `right_handed`, FMI 2.0, Co-Simulation\n")
    assert "  keeps the rules of FMI\n  can be instantiated here, and takes a step of 0.1 s\n" in out
    assert "  car.south     output         Float64  mm            position across the road, to the right [mm]\n" in out
    assert "  plant       does not fit, 0 of 8 signals found\n" in out
    assert not list(theirs.parent.glob("*.toml"))


def test_a_file_that_runs_in_spite_of_its_breaches_is_not_said_to_keep_the_rules(macrostep):
    code, out, _ = macrostep("check", maker_fmu("twentysim"))
    assert code == 0
    assert "  breaks rules of FMI that no run needs\n  note: modelDescription.xml: ModelStructure/Outputs must" in out


def test_a_socket_that_fits_is_code_0_and_needs_no_template(built_fmus, in_tmp_path, macrostep):
    code, out, _ = macrostep("check", built_fmus / "fmi3" / "bicycle.fmu")
    assert code == 0
    assert "  plant       fits as it is\n  traffic     does not fit" in out
    code, out, _ = macrostep("check", built_fmus / "fmi3" / "bicycle.fmu", "--socket", "plant")
    assert code == 0
    assert "socket plant: fits as it is\n" in out
    assert list(in_tmp_path.iterdir()) == []


def test_a_socket_that_does_not_fit_is_code_1_and_a_template_is_written(theirs, macrostep):
    code, out, err = macrostep("check", "theirs.fmu", "--socket", "plant")
    assert code == 1
    assert "socket plant: does not fit, 0 of 8 signals found\n" in out
    assert "  state.v_x          [m/s]    missing\n" in out
    assert "written: theirs.plant.toml, a mapping to fill in\n" in out
    assert err.startswith("macrostep: plant: theirs.fmu: found no variable for actuation.delta_f (Float64 in `rad`),")
    text = (theirs.parent / "theirs.plant.toml").read_text()
    assert 'y = "?"  # [m] position across the road, to the left; candidates: car.south [mm], car.east [m]\n' in text
    assert 'candidates: car.force [N] as "wheel_force" or "force";' in text
    assert read_mapping(theirs.parent / "theirs.plant.toml").fmu == theirs


def test_a_template_that_is_not_filled_in_says_what_to_fill_in(theirs):
    check(theirs, "plant", theirs.parent / "mine.toml")
    with pytest.raises(RequestError) as error:
        prepare("static", Options(mode="blocks", replacements={"plant": "mine.toml"}))
    assert str(error.value).startswith(
        "mine.toml: found nothing filled in yet for actuation.delta_f, actuation.T_r, state.x, state.y, state.psi, "
        "state.v_x, state.v_y, state.r; valid: a variable for each among its inputs car.wheel in deg, car.force in N;"
    )


def test_a_template_that_is_filled_in_runs(theirs, macrostep):
    macrostep("check", "theirs.fmu", "--socket", "plant")
    path = theirs.parent / "theirs.plant.toml"
    text = path.read_text()
    content = tomllib.loads(foreign.RIGHT_HANDED)
    for leaf in ("x", "y", "psi", "v_x", "v_y", "r"):
        text = text.replace(f'\n{leaf} = "?"', f'\n{leaf} = "{content["state"][leaf]}"')
    told = '{ variable = "car.wheel", as = "steering_wheel_angle", ratio = { value = 16, unit = "1" } }'
    text = text.replace('delta_f = "?"', f"delta_f = {told}")
    text = text.replace(
        'T_r = "?"', 'T_r = { variable = "car.force", as = "force", R_w = { value = 0.3, unit = "m" } }'
    )
    text = text.replace("# axes", "axes").replace("# reference = ", "reference = ").replace("1.4", "1.05")
    path.write_text(text)
    code, out, err = macrostep("check", "theirs.plant.toml")
    assert (code, err) == (0, "")
    assert "socket plant: fits, with the conversions below\n" in out
    conversions = out.partition("\nconversions\n")[2].partition("\n\n")[0].splitlines()
    assert "  state.psi [rad] = -0.0174533 * car.heading [deg]" in conversions
    assert "  state.y [m] = -0.001 * car.south [mm]" in conversions
    assert "  state.v_x [m/s] = 0.277778 * car.speed [km/h]" in conversions
    assert "  car.wheel [deg] = -916.732 * actuation.delta_f [rad]" in conversions
    assert any(c.startswith("  state: of a point 1.05 m behind the centre of gravity: x + 1.05 m") for c in conversions)
    assert prepare("static", Options(mode="blocks", replacements={"plant": str(path)})).remarks == ()


def test_nothing_is_overwritten(theirs, macrostep):
    (theirs.parent / "theirs.plant.toml").write_text("mine")
    _, out, _ = macrostep("check", "theirs.fmu", "--socket", "plant")
    assert "theirs.plant.toml is kept as it is; another mapping goes to --out FILE.toml\n" in out
    code, _, err = macrostep("check", "theirs.fmu", "--socket", "plant", "--out", "theirs.plant.toml")
    assert code == 2
    assert err == "macrostep: theirs.plant.toml: found a file; valid: a new file. Choose another name, or remove it.\n"
    assert (theirs.parent / "theirs.plant.toml").read_text() == "mine"
    with pytest.raises(RequestError, match="found a place that cannot be written to \\(No such file or directory\\)"):
        write_template("text", theirs.parent / "gone" / "t.toml")


CHECKED = "an .fmu, an .ssp, the .toml that maps an FMU, a Modelica file (FILE.mo or FILE.mo:MODEL), or a block"


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        (["gone.fmu"], f"gone.fmu: found no such file; valid: {CHECKED}"),
        (["notes.txt"], f"notes.txt: found a file ending in `.txt`; valid: {CHECKED}"),
        (
            ["theirs.fmu", "--socket", "plnt"],
            "--socket: found `plnt`; valid: controller, plant, traffic. Did you mean `plant`?",
        ),
        (
            ["theirs.fmu", "--out", "t.toml"],
            "--out: found a template without an FMU or a Modelica file and its socket; "
            "valid: FILE.fmu or FILE.mo with --socket SOCKET --out FILE.toml",
        ),
    ],
)
def test_a_wrong_request_is_code_2(theirs, macrostep, arguments, text):
    (theirs.parent / "notes.txt").write_text("x")
    assert macrostep("check", *arguments)[::2] == (2, f"macrostep: {text}\n")


def test_a_file_that_cannot_be_used_is_code_1(in_tmp_path, macrostep):
    (in_tmp_path / "bad.fmu").write_text("no archive")
    code, out, err = macrostep("check", "bad.fmu")
    assert (code, out) == (1, "bad.fmu: cannot be used\n")
    assert "bad.fmu: found" in err
    (in_tmp_path / "bad.toml").write_text('fmu = "bad.fmu"\nsocket = "plant"\naxes = "up"\n')
    code, _, err = macrostep("check", "bad.toml")
    assert (code, err) == (1, "macrostep: bad.toml: axes: found `up`; valid: iso8855, y_right\n")


def test_an_fmu_that_breaks_rules_is_code_1_and_still_described(theirs, macrostep):
    text = entries(theirs)["modelDescription.xml"].replace(b'unit="km/h"', b'unit="knots"')
    copied(theirs, theirs.with_name("odd.fmu"), {"modelDescription.xml": text})
    code, out, err = macrostep("check", "odd.fmu")
    assert code == 1
    assert "breaks rules of FMI, and runs with --lenient only" in out
    assert "  car.speed     output         Float64  knots" in out
    assert "`knots`" in err


def test_leniently_broken_rules_are_notes_and_the_commands_say_so_too(theirs, macrostep):
    text = entries(theirs)["modelDescription.xml"].replace(b'unit="km/h"', b'unit="knots"')
    copied(theirs, theirs.with_name("odd.fmu"), {"modelDescription.xml": text})
    code, out, err = macrostep("check", "odd.fmu", "--lenient")
    assert (code, err) == (0, "")
    assert "breaks rules of FMI, and runs with --lenient only\n  note: modelDescription.xml" in out
    assert "`knots`" in out
    assert "  macrostep run odd.fmu --stop-time 10 --lenient\n" in out
    code, _, err = macrostep("check", "odd.fmu", "--lenient", "--passport")
    assert (code, "--passport: found --lenient beside it; valid: --out, --against." in err) == (2, True)


def test_leniently_an_ssp_is_run_leniently(in_tmp_path, macrostep):
    plain = ssps.echo(in_tmp_path / "plain.fmu", [("u", "Real", "0", {})])
    whole = ssps.body(ssps.component("a", "plain.fmu", ssps.connectors("u:input")))
    ssps.write(
        in_tmp_path / "odd.ssp", whole.replace(' kind="', ' colour="red" kind="', 1), {"resources/plain.fmu": plain}
    )
    assert macrostep("check", "odd.ssp")[0] == 1
    code, out, err = macrostep("check", "odd.ssp", "--lenient")
    assert (code, err) == (0, "")
    assert "note: " in out
    assert "  macrostep run odd.ssp --lenient\n" in out


def test_a_library_is_tried_and_may_die_of_it(in_tmp_path, macrostep):
    text = description2([scalar("y", 1, "output")], ['<Unknown index="1"/>'])
    dies = library(in_tmp_path, Version.FMI2, "int fmi2Instantiate() { return *(volatile int *)8; }")
    pack(in_tmp_path / "m.fmu", Version.FMI2, text, dies)
    code, out, err = macrostep("check", "m.fmu")
    assert code == 1
    assert "  cannot be started here\n" in out
    assert err == (
        "macrostep: m.fmu: found an FMU that cannot be started (its process died in `fmi2Instantiate` (SIGSEGV));"
        " valid: one that can be run. Ask its maker for another.\n"
    )


def test_a_wrong_guid_is_told(theirs, macrostep):
    text = entries(theirs)["modelDescription.xml"]
    copied(theirs, theirs.with_name("odd.fmu"), {"modelDescription.xml": text.replace(b'guid="', b'guid="other-')})
    code, out, err = macrostep("check", "odd.fmu")
    assert code == 1
    assert "  car.speed     output         Float64  km/h" in out
    assert err.startswith("macrostep: odd.fmu: found a library that refuses to make an instance (")


def test_an_ssp_is_listed(in_tmp_path, macrostep):
    ssp.write(prepare("static", Options(mode="blocks")), in_tmp_path / "system.ssp")
    code, out, _ = macrostep("check", "system.ssp")
    assert code == 0
    assert "  plant       bicycle       socket plant\n" in out
    assert "  controller.actuation.delta_f -> plant.actuation.delta_f\n" in out


def test_an_ssp_that_would_be_refused_for_a_loop_is_code_1(in_tmp_path, macrostep):
    variables = [scalar("u", 1, "input", of_start="0"), scalar("y", 2, "output")]
    told = description2(variables, ['<Unknown index="2" dependencies="1"/>'])
    pack(in_tmp_path / "m.fmu", Version.FMI2, told, ssps.echo_library(Version.FMI2))
    ends = ssps.connectors("u:input", "y:output")
    elements = ssps.component("a", "m.fmu", ends) + ssps.component("b", "m.fmu", ends)
    whole = ssps.body(elements, ssps.wire("a.y", "b.u") + ssps.wire("b.y", "a.u"))
    ssps.write(in_tmp_path / "loop.ssp", whole, {"resources/m.fmu": in_tmp_path / "m.fmu"})
    code, out, err = macrostep("check", "loop.ssp")
    assert code == 1
    assert "  a.y -> b.u\n" in out
    assert err.startswith("macrostep: algebraic loop: found a.y -> b.u, b.y -> a.u; valid: ")
    assert err.endswith("or exchange values one step late with --algorithm jacobi.\n")


@pytest.mark.parametrize("solve_loops", [True, False])
def test_a_loop_that_the_run_of_an_ssp_solves_is_none(built_fmus, tmp_path, solve_loops):
    plant = Fmu(built_fmus / "fmi3" / "bicycle.fmu")
    wiring = {"a.actuation.delta_f": "b.tyre.alpha_f", "b.actuation.delta_f": "a.tyre.alpha_f"}
    ring = System({"a": plant, "b": plant}, wiring, {"a.actuation.T_r": 0.0, "b.actuation.T_r": 0.0})
    ssp.write(Scenario("ring", "", ring, None, 0.1, 1.0, {}, solve_loops=solve_loops), tmp_path / "ring.ssp")
    found = check(tmp_path / "ring.ssp")
    assert (found.good, [p.where for p in found.problems]) == (solve_loops, [] if solve_loops else ["algebraic loop"])


@pytest.mark.parametrize("socket", list(SOCKETS))
def test_every_template_reads_back_as_far_as_it_goes(theirs, socket):
    check(theirs, socket, theirs.parent / f"{socket}.toml")
    mapping = read_mapping(theirs.parent / f"{socket}.toml")
    assert mapping.socket == socket
    assert all(entry.missing for entries in mapping.signals.values() for entry in entries)


def test_what_to_type_next_is_said(built_fmus, theirs, macrostep):
    plant = built_fmus / "fmi3" / "bicycle.fmu"
    _, out, _ = macrostep("check", plant)
    assert out.endswith(f"To run it:\n  macrostep run {plant} --stop-time 10\n  macrostep run static --plant {plant}\n")
    _, out, _ = macrostep("check", "theirs.fmu", "--static")
    assert "instantiated" not in out
    assert out.endswith("To run it:\n  macrostep run theirs.fmu --stop-time 10\n")


def test_check_lists_what_may_be_set_before_the_run(in_tmp_path, macrostep):
    variables = [
        scalar("x", 1, "output", initial="exact", of_start="1"),
        scalar("y", 2, "output"),
        scalar("v0", 3, "local", initial="approx", of_start="0"),
        scalar("hidden", 4, "local"),
        scalar("k", 5, "parameter", variability="tunable", of_start="2"),
        scalar("n", 6, "parameter", "Integer", variability="fixed", of_start="3"),
    ]
    unknowns = [f'<Unknown index="{i}" dependencies=""/>' for i in (1, 2)]
    text = description2(variables, unknowns, initial=unknowns[1:])
    pack(in_tmp_path / "m.fmu", Version.FMI2, text, ssps.echo_library(Version.FMI2))
    _, out, _ = macrostep("check", "m.fmu")
    rows = {line.split()[0]: line for line in out.splitlines() if line.startswith("  ")}
    assert rows["x"] == "  x       output     start value, continuous  Float64        1.0"
    assert rows["y"] == "  y       output                              Float64"
    assert rows["v0"] == "  v0      local      start value, continuous  Float64        0.0"
    assert rows["k"] == "  k       parameter  tunable                  Float64        2.0"
    assert rows["n"] == "  n       parameter  fixed                    Int32          3"


def test_local_variables_are_listed_up_to_a_bound(in_tmp_path, macrostep):
    variables = [
        scalar("y", 0, "output"),
        scalar("k", 1, "calculatedParameter", variability="fixed"),
        *(scalar(f"x{i}", 2, "local", of_unit="m") for i in range(105)),
    ]
    before = '<UnitDefinitions><Unit name="m"/></UnitDefinitions>'
    unknown = ['<Unknown index="1"/>', '<Unknown index="2"/>']
    text = description2(variables, unknown[:1], before=before, initial=unknown)
    pack(in_tmp_path / "a.fmu", Version.FMI2, text, ssps.echo_library(Version.FMI2))
    code, out, _ = macrostep("check", "a.fmu")
    assert code == 0
    rows = [line.split() for line in out.splitlines()]
    assert rows.index(["k", "calculated", "Float64"]) == rows.index(["y", "output", "Float64"]) + 1
    assert ["x98", "local", "Float64", "m"] in rows
    assert ["x99", "local", "Float64", "m"] not in rows
    assert "\n  and 6 more, which --record takes as well\n" in out


def test_a_file_that_fits_its_socket_is_run_there_and_a_system_that_cannot_run_is_not(
    built_fmus, in_tmp_path, macrostep
):
    plant = built_fmus / "fmi3" / "bicycle.fmu"
    _, out, _ = macrostep("check", plant, "--socket", "plant")
    assert out.endswith(f"To run it:\n  macrostep run static --plant {plant}\n")
    _, out, _ = macrostep("check", plant, "--socket", "traffic")
    assert "To run it" not in out
    ssp.write(prepare("static", Options(mode="blocks")), in_tmp_path / "system.ssp")
    _, out, _ = macrostep("check", "system.ssp")
    assert out.endswith("To run it:\n  macrostep run system.ssp\n")


def test_a_block_and_a_modelica_file_are_described(in_tmp_path, macrostep):
    code, out, _ = macrostep("check", "bicycle")
    assert code == 0
    assert out.startswith("bicycle: a block of the socket plant\n")
    declared = '  parameter Real k(unit = "m/s2", min = 0) = 2 "how strongly it goes";\n'
    text = PLANT.format(declarations=declared, equations="  der(state.v_x) = k * actuation.T_r;")
    (in_tmp_path / "a b.mo").write_text(text)
    code, out, err = macrostep("check", "a b.mo")
    assert (code, err) == (0, "")
    assert re.search(r"\n  k +2(\.0)? +0 <= finite number \[m/s2\] +how strongly it goes\n", out)
    assert out.endswith("To run it:\n  macrostep run static --plant 'a b.mo'\n")


def test_a_modelica_file_with_names_of_its_own_is_described_as_its_fmu_is(in_tmp_path, macrostep):
    (in_tmp_path / "Cart.mo").write_text(foreign.CART)
    code, out, err = macrostep("check", "Cart.mo")
    assert (code, err) == (0, "")
    assert out.startswith("Cart.mo: `Cart`, FMI 3.0, Co-Simulation\n")
    assert "\n  keeps the rules of FMI\n  can be instantiated here, and takes a step of 0.1 s\n" in out
    assert re.search(r"\n  speed +output +Float64 +km/h\n", out)
    assert re.search(r"\n  delta_f +input +Float64 +0.0\n", out)
    assert "\n  plant       does not fit, 5 of 8 signals found\n" in out
    assert out.endswith("\nFor a mapping file: macrostep check Cart.mo --socket plant\n")
    code, out, err = macrostep("check", "Cart.mo", "--socket", "plant")
    assert code == 1
    assert "\n  actuation.delta_f  [rad]    delta_f  without a unit, taken as rad\n" in out
    assert out.endswith("\nwritten: Cart.plant.toml, a mapping to fill in\n")
    assert err.startswith(
        "macrostep: plant: Cart.mo: found no variable for actuation.T_r (Float64 in `N.m`), state.v_x"
    )
    text = (in_tmp_path / "Cart.plant.toml").read_text()
    assert text.startswith("# How Cart.mo fills the socket `plant`.\n")
    assert 'v_x = "?"  # [m/s] longitudinal speed in the body frame; candidates: speed [km/h]\n' in text
    assert read_mapping(in_tmp_path / "Cart.plant.toml").fmu == in_tmp_path / "Cart.mo"


def test_a_mapping_of_a_modelica_model_is_checked_and_nothing_names_the_fmu_that_is_built(in_tmp_path, macrostep):
    (in_tmp_path / "Cart.mo").write_text(foreign.CART)
    (in_tmp_path / "mine.toml").write_text(foreign.CART_MAPPING.replace("Cart.mo", "Cart.mo:Cart", 1))
    code, out, err = macrostep("check", "mine.toml")
    assert (code, err) == (0, "")
    assert out.startswith("Cart.mo:Cart: `Cart`, FMI 3.0, Co-Simulation\n")
    assert "\n  state.v_x [m/s] = 0.277778 * speed [km/h]\n" in out
    assert out.endswith("\nTo run it:\n  macrostep run static --plant mine.toml\n")
    assert "Cart.fmu" not in out


def test_a_template_is_written_for_a_modelica_file_that_fits_too(in_tmp_path, macrostep):
    (in_tmp_path / "Car.mo").write_text(PLANT.format(declarations="", equations="  der(state.v_x) = actuation.T_r;"))
    code, out, _ = macrostep("check", "Car.mo:Car", "--socket", "plant", "--out", "mine.toml")
    assert code == 0
    assert "\nsocket plant: fits as it is\n" in out
    assert "\nwritten: mine.toml, a mapping to change as you like\n" in out
    assert 'fmu = "Car.mo:Car"' in (in_tmp_path / "mine.toml").read_text().splitlines()


def test_a_mapping_that_cannot_be_written_leaves_the_report(theirs, macrostep, monkeypatch):
    (theirs.parent / "theirs.plant.toml").symlink_to(theirs.parent / "nowhere" / "x.toml")  # as in a folder of another
    code, out, _ = macrostep("check", "theirs.fmu", "--socket", "plant")
    assert code == 1
    assert "socket plant: does not fit, 0 of 8 signals found\n" in out
    assert "not written, the mapping: theirs.plant.toml: found " in out
