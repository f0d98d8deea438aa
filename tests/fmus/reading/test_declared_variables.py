"""Ports of every type and shape, through whole systems of FMUs that hand on what they are given.

With it `start_values.py` and `joined_arrays.py`.
"""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from components.interfaces.problem import RequestError
from components.interfaces.quantity import Type
from fmus.reading.joined_arrays import whole_name
from fmus.reading.opening import open_fmu
from fmus.toolchain.version import Version
from orchestrator.results.parquet import read_columns, write_signals
from orchestrator.stepping.master import Simulation
from orchestrator.stepping.whole_run import simulate
from orchestrator.system.experiment import Scenario
from orchestrator.system.source import Fmu
from orchestrator.system.system import System
from tests.fmus.foreign import description2, description3, library, pack, scalar
from tests.left_behind import left_in

VALUES = {
    "Float64": -1.5,
    "Float32": 0.25,
    "Int8": -128,
    "UInt8": 255,
    "Int16": -32768,
    "UInt16": 65535,
    "Int32": -(2**31),
    "UInt32": 2**32 - 1,
    "Int64": -(2**63) + 1,
    "UInt64": 2**63,
    "Boolean": True,
    "Enumeration": 3,
    "String": "Größe & <10>",
    "Binary": b"\x00\xff\x10\x00",
}
STARTS = {"String": "", "Binary": "", "Boolean": "false", "Enumeration": "1"}
ITEMS = '<Item name="one" value="1"/><Item name="three" value="3"/>'
ENUMERATION = f'<TypeDefinitions><EnumerationType name="Gear">{ITEMS}</EnumerationType></TypeDefinitions>'


def start(kind, of=""):
    value = of or STARTS.get(kind, "0")
    return f'<Start value="{value}"/>' if kind in ("String", "Binary") else value


def element3(kind, name, reference, causality, inside="", of=""):
    declared = ' declaredType="Gear"' if kind == "Enumeration" else ""
    own = f'name="{name}" valueReference="{reference}" causality="{causality}"{declared}'
    if causality == "output":
        return f"<{kind} {own}>{inside}</{kind}>"
    if kind in ("String", "Binary"):
        return f"<{kind} {own}>{inside}{start(kind, of)}</{kind}>"
    return f'<{kind} {own} start="{start(kind, of)}">{inside}</{kind}>'


def echo3(tmp_path_factory):
    variables, structure = [], []
    for reference, kind in enumerate(VALUES, 1):
        variables.append(element3(kind, f"u.{kind}", reference, "input"))
        variables.append(element3(kind, f"y.{kind}", reference + 100, "output"))
    dimensions = {
        "rank1": (20, '<Dimension start="3"/>'),
        "rank2": (21, '<Dimension start="2"/><Dimension start="3"/>'),
        "rank3": (22, '<Dimension start="2"/><Dimension start="3"/><Dimension start="4"/>'),
        "chosen": (23, '<Dimension valueReference="90"/>'),
        "chosen2": (24, '<Dimension valueReference="90"/><Dimension start="2"/>'),
    }
    for name, (reference, inside) in dimensions.items():
        variables.append(element3("Float64", f"u.{name}", reference, "input", inside))
        variables.append(element3("Float64", f"y.{name}", reference + 100, "output", inside))
    variables.append(element3("UInt64", "n", 90, "structuralParameter", of="2"))
    outputs = [int(v.partition('valueReference="')[2].partition('"')[0]) for v in variables if '"output"' in v]
    structure = [f'<Output valueReference="{r}" dependencies="{r - 100}"/>' for r in outputs]
    folder = tmp_path_factory.mktemp("echo3")
    text = description3(variables, structure, before=ENUMERATION)
    return pack(folder / "e.fmu", Version.FMI3, text, library(folder, Version.FMI3, '#include "echo3.c"'))


@pytest.fixture(scope="module")
def echo(tmp_path_factory):
    return echo3(tmp_path_factory)


def held(unit="a", n=2):
    values = {f"{unit}.u.{kind}": value for kind, value in VALUES.items()}
    shapes = {"rank1": (3,), "rank2": (2, 3), "rank3": (2, 3, 4), "chosen": (n,), "chosen2": (n, 2)}
    return values | {
        f"{unit}.u.{name}": np.arange(np.prod(shape)).reshape(shape) + 0.5 for name, shape in shapes.items()
    }


def test_values_of_every_type_and_shape_reach_the_other_end_of_a_chain(echo):
    system = System({"a": Fmu(echo), "b": Fmu(echo)}, {"b.u": "a.y"}, held=held())
    with Simulation(system, h=0.1, until=0.3) as simulation:
        simulation.run()
        for path, value in held("b").items():
            found = simulation.read(path.replace(".u.", ".y."))
            assert np.array_equal(found, value), path
        frame = simulation.frame()
    assert frame["b.y.String"].tolist()[-1] == VALUES["String"]
    assert frame["b.y.Binary"].tolist()[-1] == VALUES["Binary"]
    assert [c for c in frame if c.startswith("b.y.rank3")][5] == "b.y.rank3[1,2,2]"


def test_types_units_shapes_and_start_values_are_read(echo):
    interface = open_fmu(echo).interface
    assert {v.name[2:]: v.quantity.type.value for v in interface.inputs[:14]} == {k: k for k in VALUES}
    quantity = {v.name: v.quantity for v in interface.inputs}
    assert quantity["u.Float64"].unit == ""
    assert [item.name for item in quantity["u.Enumeration"].enumeration] == ["one", "three"]
    assert interface.starts["u.Binary"] == b""
    assert interface.starts["u.rank2"].tolist() == [[0, 0, 0], [0, 0, 0]]
    assert [v.name for v in interface.parameters] == ["n"]


@pytest.mark.parametrize("n", [1, 5])
def test_lengths_follow_structural_parameters_set_in_configuration_mode(echo, n):
    system = System({"a": Fmu(echo, {"n": n})}, {}, held=held(n=n))
    with Simulation(system, h=0.1, until=0.1) as simulation:
        simulation.run()
        assert simulation.read("a.y.chosen").tolist() == [i + 0.5 for i in range(n)]
        assert simulation.read("a.y.chosen2").shape == (n, 2)


def test_a_structural_parameter_of_a_wrong_type_is_told_with_the_others(echo):
    with pytest.raises(RequestError) as error:
        System({"a": Fmu(echo, {"n": "many"})}, {}, held=held())
    assert str(error.value).startswith("a.n: found `many` (not a number); valid: whole number")


def test_values_out_of_the_range_of_their_type_are_refused(echo):
    wrong = held() | {"a.u.Int8": 128, "a.u.UInt16": -1, "a.u.Enumeration": 2, "a.u.String": 1, "a.u.Binary": "text"}
    with pytest.raises(RequestError) as error:
        System({"a": Fmu(echo)}, {}, held=wrong)
    assert str(error.value).splitlines() == [
        "a.u.Int8: found 128; valid: -128 <= whole number <= 127, as Int8 holds",
        "a.u.UInt16: found -1; valid: 0 <= whole number <= 65535, as UInt16 holds",
        "a.u.Enumeration: found 2; valid: one, three",
        "a.u.String: found `1`; valid: text",
        "a.u.Binary: found `text`; valid: bytes, each as two hexadecimal digits",
    ]


def test_texts_and_bytes_come_back_from_parquet(echo, tmp_path):
    system = System({"a": Fmu(echo)}, {}, held=held())
    frame = simulate(system, h=0.1, until=0.3)
    scenario = Scenario(name="s", title="s", system=system, scene=None, h=0.1, until=0.3, sources={})
    write_signals(frame, scenario, tmp_path / "s.parquet")
    columns = read_columns(tmp_path / "s.parquet")
    assert list(columns) == list(frame)
    for name, values in columns.items():
        assert values.tolist() == frame[name].tolist(), name
    assert pd.read_parquet(tmp_path / "s.parquet")["a.y.Binary"].iloc[-1] == VALUES["Binary"]


def test_aliases_are_other_names_of_one_variable(tmp_path):
    alias = '<Alias name="{}" description="the same"/>'
    variables = [
        element3("Float64", "u", 1, "input", alias.format("pedal")),
        element3("Float64", "y", 101, "output", alias.format("force")),
    ]
    text = description3(variables, ['<Output valueReference="101" dependencies="1"/>'])
    path = pack(tmp_path / "e.fmu", Version.FMI3, text, library(tmp_path, Version.FMI3, '#include "echo3.c"'))
    interface = open_fmu(path).interface
    assert [v.name for v in interface.inputs] == ["u"]
    assert [v.name for v in interface.outputs] == ["y", "force"]
    system = System({"a": Fmu(path), "b": Fmu(path)}, {"b.pedal": "a.force"}, held={"a.u": 2.0})
    rows = simulate(system, h=0.1, until=0.1)
    assert rows["b.y"].iloc[-1] == 2.0
    with pytest.raises(RequestError, match="two sources"):
        System({"a": Fmu(path), "b": Fmu(path)}, {"b.pedal": "a.force", "b.u": "a.y"}, held={"a.u": 2.0})


def echo2(folder, spelling, kind="Real", value="0"):
    names = [spelling.format(i, j, i0=i - 1, j0=j - 1) for i in (1, 2) for j in (1, 2, 3)]
    variability = {} if kind == "Real" else {"variability": "discrete"}
    declared = {"of_declaredType": "Gear"} if kind == "Enumeration" else {}
    inputs = [
        scalar(f"u.{n}", 20 + k, "input", kind, of_start=value, **variability, **declared) for k, n in enumerate(names)
    ]
    outputs = [scalar(f"y.{n}", 120 + k, "output", kind, **variability, **declared) for k, n in enumerate(names)]
    unknowns = [f'<Unknown index="{7 + k}" dependencies="{1 + k}"/>' for k in range(6)]
    initial = [f'<Unknown index="{7 + k}"/>' for k in range(6)]
    gear = '<TypeDefinitions><SimpleType name="Gear"><Enumeration><Item name="a" value="1"/><Item name="b" value="2"/>'
    before = f"{gear}</Enumeration></SimpleType></TypeDefinitions>" if declared else ""
    text = description2([*inputs, *outputs], unknowns, before=before, initial=initial)
    return pack(folder / f"{kind}.fmu", Version.FMI2, text, folder / "library.so")


@pytest.fixture(scope="module")
def folder2(tmp_path_factory):
    folder = tmp_path_factory.mktemp("echo2")
    library(folder, Version.FMI2, '#include "echo2.c"')
    return folder


@pytest.mark.parametrize("spelling", ["a[{},{}]", "a[{}][{}]", "a[{i0},{j0}]", "b.a[{}, {}]"])
def test_elements_of_fmi2_are_arrays_however_they_are_spelt(folder2, spelling):
    path = echo2(folder2, spelling)
    interface = open_fmu(path).interface
    name = spelling.partition("[")[0]
    assert [(v.name, v.shape) for v in interface.inputs] == [(f"u.{name}", (2, 3))]
    given = np.arange(6.0).reshape(2, 3)
    with Simulation(System({"m": Fmu(path)}, {}, held={f"m.u.{name}": given}), h=0.1, until=0.1) as simulation:
        simulation.run()
        assert simulation.read(f"m.y.{name}").tolist() == given.tolist()


@pytest.mark.parametrize("spelling", ["a[{},{}].x", "a[{}{}]", "a_{}_{}", "a[{}5,{}]"])
def test_names_that_fill_no_shape_stay_scalars(folder2, spelling):
    names = [spelling.format(i, j) for i in (1, 2) for j in (1, 2, 3)]
    interface = open_fmu(echo2(folder2, spelling)).interface
    assert [(v.name, v.shape) for v in interface.inputs] == [(f"u.{name}", ()) for name in names]


@pytest.mark.parametrize(
    ("kind", "start_value", "value", "expected"),
    [
        ("Integer", "0", 7, Type.INT32),
        ("Boolean", "false", True, Type.BOOLEAN),
        ("String", "", "ä", Type.STRING),
        ("Enumeration", "1", 2, Type.ENUMERATION),
    ],
)
def test_every_type_of_fmi2_is_handed_on(folder2, kind, start_value, value, expected):
    path = echo2(folder2, "a[{},{}]", kind, start_value)
    given = np.full((2, 3), value, dtype=object if kind == "String" else None)
    units = {"a": Fmu(path), "b": Fmu(path)}
    with Simulation(System(units, {"b.u": "a.y"}, held={"a.u.a": given}), h=0.1, until=0.1) as simulation:
        simulation.run()
        assert simulation.read("b.y.a").tolist() == given.tolist()
    assert open_fmu(path).interface.inputs[0].quantity.type is expected


def test_fmi2_variables_of_one_value_reference_show_one_value(folder2):
    variables = [scalar("u", 1, "input", of_start="0"), scalar("y", 101, "output"), scalar("z", 101, "output")]
    unknowns = [f'<Unknown index="{i}" dependencies="1"/>' for i in (2, 3)]
    text = description2(variables, unknowns, initial=['<Unknown index="2"/>', '<Unknown index="3"/>'])
    path = pack(folder2 / "same.fmu", Version.FMI2, text, folder2 / "library.so")
    rows = simulate(System({"m": Fmu(path)}, {}, held={"m.u": 4.0}), h=0.1, until=0.1)
    assert rows.iloc[-1].tolist() == [0.1, 4.0, 4.0]


RESOURCE = """
#define EXTRA read_resource(i, resources);
#include <stdio.h>
#include <string.h>
#include <stdlib.h>
static void read_resource(void *i, const char *place);
#include "echo{version}.c"
static void read_resource(void *i, const char *place) {{
    char path[4096], *to = path;
    if (!strncmp(place, "file://", 7)) place += 7;
    for (; *place; place++) {{
        if (!strncmp(place, "%20", 3)) {{ *to++ = ' '; place += 2; }} else *to++ = *place;
    }}
    strcpy(to, {version} == 2 ? "/number.txt" : "number.txt");
    FILE *file = fopen(path, "r");
    double number = -1;
    if (file) {{ fscanf(file, "%lf", &number); fclose(file); }}
    {keep}
}}
"""
KEEP = {2: "((I *)i)->r[1] = number;", 3: "*(double *)room(((I *)i)->slots + 1, 1, 8) = number;"}


@pytest.mark.parametrize("version", [2, 3])
def test_resources_are_found_also_where_paths_have_spaces(tmp_path, monkeypatch, version):
    place = tmp_path / "a place with spaces"
    place.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(place))
    if version == 2:
        text = description2([scalar("y", 101, "output")], ['<Unknown index="1"/>'], initial=['<Unknown index="1"/>'])
    else:
        text = description3([element3("Float64", "y", 101, "output")], ['<Output valueReference="101"/>'])
    source = RESOURCE.format(version=version, keep=KEEP[version])
    binary = library(tmp_path, Version(version), source)
    path = pack(place / "with resources.fmu", Version(version), text, binary, resources__number_txt="12.5")
    rows = simulate(System({"m": Fmu(path)}, {}), h=0.1, until=0.1)
    assert rows["m.y"].iloc[-1] == 12.5
    assert left_in(place) == [path]


@pytest.mark.parametrize("version", ["3.0", "3.0.1", "3.0-beta.1"])
def test_patch_versions_of_fmi3_are_fmi3(tmp_path, version):
    text = description3([element3("Float64", "y", 101, "output")], ['<Output valueReference="101"/>'], version=version)
    path = pack(tmp_path / "e.fmu", Version.FMI3, text, library(tmp_path, Version.FMI3, '#include "echo3.c"'))
    assert open_fmu(path).version == Version.FMI3
    assert simulate(System({"m": Fmu(path)}, {}), h=0.1, until=0.1)["m.y"].tolist() == [0.0, 0.0]


def test_whole_names():
    assert whole_name("a.b[1,2]", {"a.b": 0}) == "a.b"
    assert whole_name("a", {"b": 0}) is None


@pytest.mark.parametrize(
    ("kind", "attributes", "told"),
    [
        ("Real", {"of_start": "abc"}, "start value `abc`"),
        ("Integer", {"of_start": "1.5"}, "start value `1.5`"),
        ("Integer", {"of_start": "99999999999"}, "start value `99999999999`"),
        ("Boolean", {"of_start": "maybe"}, "start value `maybe`"),
        ("Real", {"of_start": "1", "of_min": "low"}, "limit `low`"),
    ],
)
def test_a_lenient_reader_names_the_value_that_nobody_can_read(tmp_path, kind, attributes, told):
    text = description2(
        [scalar("y", 1, "output"), scalar("p", 2, "parameter", kind, variability="fixed", **attributes)]
    )
    with pytest.raises(RequestError) as error:
        open_fmu(pack(tmp_path / "m.fmu", Version.FMI2, text, None), lenient=True)
    assert str(error.value).replace(f"{tmp_path}/", "") == (
        f"m.fmu, modelDescription.xml, line 7: found a variable that cannot be understood (`p` with the {told});"
        " valid: what FMI allows"
    )


KELVIN = '<Unit name="K"><BaseUnit K="1"/></Unit><Unit name="degC"><BaseUnit K="1" offset="273.15"/></Unit>'


@pytest.mark.parametrize(
    ("by_type", "own", "arrives"),
    [("true", None, 10.0), ("false", None, -263.15), (None, "true", 10.0), ("true", "false", -263.15)],
)
@pytest.mark.parametrize("definitions", [True, False])
def test_a_difference_of_temperatures_has_no_offset(tmp_path, by_type, own, arrives, definitions):
    """FMI 2.0.5, 2.2.2: with relativeQuantity the offset of the unit counts as 0, by the type or by the variable."""
    types = [
        f'<SimpleType name="in_{unit}"><Real unit="{unit}" {relative(by_type)}/></SimpleType>' for unit in ("K", "degC")
    ]
    before = f"<UnitDefinitions>{KELVIN}</UnitDefinitions>" if definitions else ""
    before += f"<TypeDefinitions>{''.join(types)}</TypeDefinitions>"
    own = {} if own is None else {"of_relativeQuantity": own}
    variables = [
        scalar("u", 1, "input", of_declaredType="in_K", of_start="10", **own),
        scalar("v", 2, "input", of_declaredType="in_degC", of_start="0", **own),
        scalar("y", 101, "output", of_declaredType="in_K", **own),
        scalar("z", 102, "output", of_declaredType="in_degC", **own),
    ]
    outputs = ['<Unknown index="3" dependencies=""/>', '<Unknown index="4" dependencies=""/>']
    text = description2(variables, outputs, before=before)
    path = pack(tmp_path / "d.fmu", Version.FMI2, text, library(tmp_path, Version.FMI2, '#include "echo2.c"'))
    units = {"a": Fmu(path, lenient=not definitions), "b": Fmu(path, lenient=not definitions)}
    system = System(units, {"b.v": "a.y"}, held={"a.u": 10.0, "a.v": 0.0, "b.u": 0.0})
    assert simulate(system, h=0.1, until=0.2)["b.z"].iloc[-1] == pytest.approx(arrives)


def relative(value):
    return "" if value is None else f'relativeQuantity="{value}"'
