"""What a person sets in an SSP, and in a run that is repeated from its folder."""

from __future__ import annotations

import pytest

from components.interfaces.problem import RequestError
from fmus.toolchain.version import Version
from orchestrator.loading import load
from orchestrator.results.parquet import read_columns
from orchestrator.results.run_folder import write_system
from orchestrator.scenario.options import Options
from orchestrator.scenario.resolution import resolve_unit
from orchestrator.ssp.vocabulary import DESCRIPTION_FILE
from orchestrator.stepping.whole_run import simulate
from orchestrator.system.files import Given
from orchestrator.system.source import Fmu
from tests.fmus.foreign import description2, description3, entries, pack, scalar
from tests.orchestrator.ssps import (
    binding,
    bindings,
    body,
    component,
    connectors,
    echo,
    echo_library,
    values,
    vectors,
    wire,
    write,
)

ITEMS = (("R 2", -2), ("__NONE__", 0), ("mro", 5), ("D", 20))
GEAR = "".join(f'<Item name="{name}" value="{value}"/>' for name, value in ITEMS)
GEAR = f'<SimpleType name="Gear"><Enumeration>{GEAR}</Enumeration></SimpleType>'
PARAMETERS = (
    "k",
    ("file", "String", "none"),
    ("gear", "Enumeration", "0", {"declaredType": "Gear"}),
    ("on", "Boolean", "false"),
    ("n", "Integer", "1"),
    ("z[0]", "Real", "1"),
    ("z[1]", "Real", "2"),
    ("z[2]", "Real", "3"),
)


@pytest.fixture(scope="module")
def fmu(tmp_path_factory):
    return echo(tmp_path_factory.mktemp("echo") / "e.fmu", ["u"], PARAMETERS, types=GEAR)


@pytest.fixture(scope="module", params=["fmu", "ssp", "run"])
def request_of(request, fmu, tmp_path_factory):
    """The same unit `fmu` as a single FMU, in an SSP, and in the folder of a run."""
    folder = tmp_path_factory.mktemp("first")
    if request.param == "fmu":
        return fmu
    if request.param == "run":
        write_system(load(str(fmu), Options(settings=["fmu.k=7"], stop_time=0.2)), folder)
        return folder
    return write(folder / "a.ssp", body(component("fmu", "e.fmu")), {"resources/e.fmu": fmu})


def shown(path, *settings, **options):
    scenario = load(str(path), Options(settings=settings, stop_time=0.2, **options))
    return simulate(scenario.system, h=scenario.h, until=scenario.until).iloc[-1]


def refusal(path, *settings, **options):
    with pytest.raises(RequestError) as error:
        load(str(path), Options(settings=settings, stop_time=0.2, **options))
    return str(error.value).splitlines()


@pytest.mark.parametrize(
    ("setting", "column", "value"),
    [
        ("k=2.5", "y_k", 2.5),
        ("file=123", "y_file", "123"),
        ("file=", "y_file", ""),
        ("file=a=b [1]", "y_file", "a=b [1]"),
        ("gear=D", "y_gear", 20),
        ("gear='R 2'", "y_gear", -2),
        ("gear=mro", "y_gear", 5),
        ("on=1", "y_on", 1),
        ("n=-3", "y_n", -3),
        ("z[1]=9", "y_z[2]", 9.0),
        ("z=[4, 5, 6]", "y_z[3]", 6.0),
        ("u=8", "y_u", 8.0),
    ],
)
def test_one_rule_holds_for_fmus_ssps_and_runs(request_of, setting, column, value):
    assert shown(request_of, f"fmu.{setting}")[f"fmu.{column}"] == value


def test_what_nobody_sets_stays_as_it_was(request_of):
    row = shown(request_of, "fmu.z[0]=9")
    assert [row[f"fmu.y_z[{k}]"] for k in (1, 2, 3)] == [9.0, 2.0, 3.0]
    assert row["fmu.y_k"] == (7.0 if request_of.is_dir() else 0.0)


def test_all_that_cannot_be_set_is_told(request_of):
    assert refusal(request_of, "fmu.gear=3", "fmu.n=1.5", "fmu.z[3]=1", "fmu.y_k=1", "fmu.kk=1") == [
        "fmu.z[3]: found no such element; valid: 0 to 2",
        "fmu.y_k: found a variable whose value nobody may set; valid: file, gear, k, n, on, u, z",
        "fmu.kk: found an unknown parameter; valid: file, gear, k, n, on, u, z. Did you mean `k`?",
        "fmu.gear: found 3; valid: D, R 2, __NONE__, mro",
        "fmu.n: found `1.5` (number); valid: whole number",
    ]


def test_an_input_that_is_driven_is_not_set(fmu, tmp_path):
    ports = connectors("u:input", "y_u:output")
    two = component("a", "e.fmu", ports) + component("b", "e.fmu", ports)
    path = write(tmp_path / "a.ssp", body(two, wire("a.y_u", "b.u")), {"resources/e.fmu": fmu})
    assert shown(path, "a.u=4")["a.y_u"] == 4.0
    assert refusal(path, "b.u=4") == [
        "--set b.u=4: found a value for an input that `a.y_u` drives; valid: an input that nothing drives"
    ]


def test_a_run_repeats_texts_items_and_elements(fmu, macrostep):
    texts = ["fmu.file=two\nlines & <1>", "fmu.gear=__NONE__", "fmu.z[2]=8", "fmu.u=3"]
    options = [part for text in texts for part in ("--set", text)]
    assert macrostep("run", fmu, "--stop-time", "0.2", *options, "--out", "first")[0] == 0
    assert macrostep("run", "first", "--out", "again")[0] == 0
    first, again = (read_columns(f"{name}/signals.parquet") for name in ("first", "again"))
    assert {name: list(column) for name, column in first.items()} == {n: list(c) for n, c in again.items()}
    assert first["fmu.y_file"][-1] == "two\nlines & <1>"
    assert (first["fmu.y_gear"][-1], first["fmu.y_z[3]"][-1], first["fmu.y_u"][-1]) == (0, 8.0, 3.0)


def test_start_values_of_outputs_and_local_variables_are_set_too(tmp_path):
    variables = [
        scalar("x", 1, "output", initial="exact", of_start="1"),
        scalar("v", 2, "local", initial="approx", of_start="0"),
        scalar("name", 3, "local", "String", variability="discrete", initial="exact", of_start="none"),
        scalar("c", 4, "calculatedParameter", variability="fixed", initial="approx", of_start="1"),
        scalar("w[1]", 5, "output", initial="exact", of_start="1"),
        scalar("w[2]", 6, "output"),
        *(scalar(f"y_{n}", n + 100, "output") for n in (1, 2, 4, 5)),
        scalar("y_3", 103, "output", "String", variability="discrete"),
    ]
    unknowns = [f'<Unknown index="{i + 1}" dependencies=""/>' for i, v in enumerate(variables) if '"output"' in v]
    text = description2(variables, unknowns, initial=unknowns[2:])
    fmu = pack(tmp_path / "e.fmu", Version.FMI2, text, echo_library(Version.FMI2))
    path = write(tmp_path / "a.ssp", body(component("fmu", "e.fmu")), {"resources/e.fmu": fmu})
    for request in (fmu, path):
        row = shown(request, "fmu.x=7", "fmu.v=2", "fmu.name=run A", "fmu.c=3", "fmu.w[1]=4")
        assert [row[f"fmu.y_{n}"] for n in (1, 2, 3, 4, 5)] == [7.0, 2.0, "run A", 3.0, 4.0]
        assert refusal(request, "fmu.w[2]=4")[0].startswith("fmu.w[2]: found a variable whose value nobody may set;")


def test_a_name_may_have_any_letters_and_the_longest_that_is_known_counts(tmp_path):
    names = ["a.b", "a b", "a", "a=b", "der(x)", "äö", "'q.u'", "x[1].y"]
    fmu = echo(tmp_path / "e.fmu", [], [(name, "Real", "0") for name in names])
    for name in names:
        assert shown(fmu, f"fmu.{name}=5")[f"fmu.y_{name}"] == 5.0
    assert refusal(fmu, "fmu.a=b=c") == ["fmu.a=b: found `c` (not a number); valid: finite number"]


def test_lengths_of_arrays_follow_a_structural_parameter(tmp_path, macrostep):
    fmu = vectors(tmp_path / "v.fmu")
    assert macrostep("run", fmu, "--set", "fmu.n=4", "--stop-time", "0.2", "--out", "first")[0] == 0
    for again in ("first", "second"):
        columns = read_columns(f"{again}/signals.parquet")
        assert "fmu.y_w[4]" in columns
        assert "fmu.y_w[5]" not in columns
        if again == "first":
            assert macrostep("run", "first", "--out", "second")[0] == 0


def test_start_values_for_other_lengths_are_not_used(tmp_path):
    fmu = vectors(tmp_path / "v.fmu")
    scenario = load(str(fmu), Options(settings=["fmu.n=4"], stop_time=0.2))
    assert "fmu.w" not in scenario.system.held
    assert scenario.system.unset == {"fmu.w"}
    given = load(str(fmu), Options(settings=["fmu.n=1", "fmu.w=[6]"], stop_time=0.2))
    assert given.system.held["fmu.w"] == [6]


def test_values_of_an_ssp_for_other_lengths_are_not_used_and_told(tmp_path):
    fmu = vectors(tmp_path / "v.fmu")
    set_ = bindings(binding(values(n=("UInt64", "3", None)).replace('version="1.0"', 'version="2.0"')))
    whole = body(component("a", "v.fmu", set_))
    path = write(tmp_path / "a.ssp", whole, {"resources/v.fmu": fmu}, version="2.0")
    assert load(str(path)).system.units["a"].parameters == {"n": 3}
    chosen = load(str(path), Options(settings=["a.n=5"]))
    assert chosen.system.units["a"].parameters == {"n": 5}
    assert load(str(path), Options(settings=["a.n=5", "a.w=[1, 2, 3, 4, 5]"])).system.held["a.w"] == [1, 2, 3, 4, 5]


def test_a_run_from_its_folder_takes_other_lengths(tmp_path, macrostep):
    fmu = vectors(tmp_path / "v.fmu")
    request = ["--set", "fmu.n=3", "--set", "fmu.w=[1, 2, 3]", "--stop-time", "0.2", "--out", "first"]
    assert macrostep("run", fmu, *request)[0] == 0
    assert b'size="3"' in entries("first/system.ssp")[DESCRIPTION_FILE]
    code, _, err = macrostep("run", "first", "--set", "fmu.n=2", "--out", "second")
    assert code == 0
    assert "note: fmu: the values in the file are for arrays of other lengths, and are not used: w\n" in err
    assert "fmu.y_w[2]" in read_columns("second/signals.parquet")
    assert "fmu.y_w[3]" not in read_columns("second/signals.parquet")


def test_a_parameter_without_start_value_keeps_the_value_inside_the_fmu(tmp_path):
    variables = [scalar("p", 1, "parameter", variability="fixed"), scalar("y_p", 101, "output")]
    unknowns = ['<Unknown index="2" dependencies=""/>']
    text = description2(variables, unknowns, initial=unknowns)
    fmu = pack(tmp_path / "e.fmu", Version.FMI2, text, echo_library(Version.FMI2))
    scenario = load(str(fmu), Options(stop_time=0.2, lenient=True))
    assert "fmu: no start value in the file, the FMU keeps its own: p" in scenario.remarks
    assert scenario.system.units["fmu"].parameters == {}
    assert shown(fmu, "fmu.p=4", lenient=True)["fmu.y_p"] == 4.0
    path = write(tmp_path / "a.ssp", body(component("a", "e.fmu")), {"resources/e.fmu": fmu})
    assert "a: no start value in the file, the FMU keeps its own: p" in load(str(path), Options(lenient=True)).remarks


def test_integers_of_64_bits_are_exact(tmp_path):
    parameter = '<UInt64 name="n" valueReference="1" causality="parameter" variability="fixed" start="0"/>'
    output = '<UInt64 name="y" valueReference="101" causality="output" variability="discrete"/>'
    text = description3([parameter, output], ['<Output valueReference="101" dependencies=""/>'])
    fmu = pack(tmp_path / "e.fmu", Version.FMI3, text, echo_library(Version.FMI3))
    assert shown(fmu, f"fmu.n={2**64 - 1}")["fmu.y"] == 2**64 - 1
    assert refusal(fmu, f"fmu.n={2**64}") == [
        f"fmu.n: found {2**64}; valid: 0 <= whole number <= {2**64 - 1}, as UInt64 holds"
    ]


def sloped(folder):
    """A plant that shows nothing but its own input `slope`, which no socket has."""
    units = '<Unit name="rad"><BaseUnit rad="1"/></Unit><Unit name="N.m"><BaseUnit kg="1" m="2" s="-2"/></Unit>'
    units += '<Unit name="m"><BaseUnit m="1"/></Unit><Unit name="m/s"><BaseUnit m="1" s="-1"/></Unit>'
    units += '<Unit name="rad/s"><BaseUnit rad="1" s="-1"/></Unit>'
    inputs = {"actuation.delta_f": "rad", "actuation.T_r": "N.m"}
    outputs = {"x": "m", "y": "m", "psi": "rad", "v_x": "m/s", "v_y": "m/s", "r": "rad/s"}
    variables = [scalar(n, k, "input", of_start="0", of_unit=unit) for k, (n, unit) in enumerate(inputs.items())]
    variables += [scalar("slope", 9, "input", of_start="0.5"), scalar("v0", 8, "local", initial="exact", of_start="1")]
    variables += [scalar(f"state.{n}", k + 110, "output", of_unit=u) for k, (n, u) in enumerate(outputs.items())]
    variables += [scalar("y_slope", 109, "output"), scalar("y_v0", 108, "output")]
    unknowns = [f'<Unknown index="{i + 1}" dependencies=""/>' for i, v in enumerate(variables) if '"output"' in v]
    before = f"<UnitDefinitions>{units}</UnitDefinitions>"
    text = description2(variables, unknowns, initial=unknowns, before=before)
    return pack(folder / "sloped.fmu", Version.FMI2, text, echo_library(Version.FMI2))


def test_a_scenario_and_its_run_have_the_same_rule_for_an_fmu_behind_a_mapping(tmp_path):
    plant = {"plant": str(sloped(tmp_path))}

    def prepared(*settings):
        return load("idle", Options(mode="blocks", replacements=plant, settings=settings, stop_time=0.2))

    def row(scenario):
        frame = simulate(scenario.system, h=scenario.h, until=scenario.until)
        return [float(frame[f"plant.{name}"].iloc[-1]) for name in ("y_slope", "y_v0")]

    assert row(prepared()) == [0.5, 0.0]  # what nobody sets is not set
    first = prepared("plant.slope=3", "plant.v0=2")
    assert row(first) == [3.0, 2.0]
    write_system(first, tmp_path)
    assert row(load(str(tmp_path))) == [3.0, 2.0]
    assert row(load(str(tmp_path), Options(settings=["plant.slope=4"]))) == [4.0, 2.0]
    with pytest.raises(RequestError, match="found a constant for an input that a signal drives"):
        prepared("plant.actuation.T_r=1")
    assert refusal(tmp_path, "plant.actuation.T_r=1") == [
        "--set plant.actuation.T_r=1: found a value for an input that `controller.actuation.T_r` drives; "
        "valid: an input that nothing drives"
    ]


def test_a_scenario_file_gives_items_by_name_and_start_values(tmp_path):
    variables = [
        scalar("gear", 1, "parameter", "Enumeration", variability="fixed", of_start="0", of_declaredType="Gear"),
        scalar("v0", 2, "local", initial="exact", of_start="1"),
    ]
    text = description2(variables, before=f"<TypeDefinitions>{GEAR}</TypeDefinitions>")
    fmu = Fmu(pack(tmp_path / "e.fmu", Version.FMI2, text, echo_library(Version.FMI2)))
    given = {"gear": Given(value="R 2", source="here"), "v0": Given(value=3, unit="", source="here")}
    assert resolve_unit("plant", fmu, given).values == {"gear": -2, "v0": 3}
    wrong = {"gear": Given(value="R2", source="here")}
    assert [str(problem) for problem in resolve_unit("plant", fmu, wrong).problems] == [
        "plant.gear: found `R2`; valid: D, R 2, __NONE__, mro. Did you mean `R 2`?"
    ]
