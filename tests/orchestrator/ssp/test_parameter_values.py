"""Parameter sets of SSPs reach what the standard says they reach, in the standard's order, in the unit's units."""

from __future__ import annotations

import pytest

from orchestrator.ssp import reader as ssp_reader
from orchestrator.ssp import writer as ssp
from orchestrator.stepping.whole_run import simulate
from tests.fmus.foreign import copied, entries
from tests.orchestrator.ssps import (
    SPACES,
    binding,
    bindings,
    body,
    component,
    connectors,
    echo,
    linear,
    system,
    values,
    vectors,
    wire,
    write,
)

ITEMS = (
    '<SimpleType name="Gear"><Enumeration><Item name="one" value="1"/><Item name="two" value="5"/></Enumeration>'
    "</SimpleType>"
)


@pytest.fixture(scope="module")
def many(tmp_path_factory):
    """An FMU with parameters of every type, and arrays."""
    parameters = [
        ("k", "Real", "0"),
        ("T", "Real", "0", {"unit": "K"}),
        ("v", "Real", "0", {"unit": "m/s"}),
        ("n", "Integer", "0"),
        ("on", "Boolean", "false"),
        ("text", "String", ""),
        ("gear", "Enumeration", "1", {"declaredType": "Gear"}),
        *((f"w[{i}]", "Real", "0") for i in (1, 2, 3)),
    ]
    path = tmp_path_factory.mktemp("fmus") / "many.fmu"
    return echo(path, [("u", "Real", "0", {"unit": "m/s"})], parameters, types=ITEMS)


def read(tmp_path, many, whole, files=None, **changed):
    return ssp_reader.read(write(tmp_path / "a.ssp", whole, {"resources/many.fmu": many, **(files or {})}, **changed))


def assert_close(found, expected):
    assert found.keys() == expected.keys()
    for name, value in expected.items():
        assert found[name] == pytest.approx(value), name


def mapping(*entries, source=""):
    """A mapping of (source, target, attributes, transformation); beside its element where it has a source."""
    made = []
    for a, b, *more in entries:
        attributes, inside = (*more, "", "")[:2]
        made.append(f'<ssm:MappingEntry source="{a}" target="{b}" {attributes}>{inside}</ssm:MappingEntry>')
    text = f'<ssm:ParameterMapping {SPACES} version="1.0">{"".join(made)}</ssm:ParameterMapping>'
    if source:
        return f'<ssd:ParameterMapping source="{source}"/>', text
    return f"<ssd:ParameterMapping>{text}</ssd:ParameterMapping>"


def test_values_of_every_type_reach_a_component_inline_and_from_a_file(many, tmp_path):
    given = values(
        k=("Real", 2.5, None),
        T=("Real", 20, "degC"),
        v=("Real", 36, "km/h"),
        n=("Integer", -7, None),
        on=("Boolean", "true", None),
        text=("String", "a b", None),
        gear=("Enumeration", "two", None),
        **{"w[1]": 1, "w[3]": 3},
    )
    expected = {"k": 2.5, "T": 293.15, "v": 10.0, "n": -7, "on": True, "text": "a b", "gear": 5, "w": [1, 0, 3]}
    for attributes, inline, files in (
        ("", given, {}),
        ('source="resources/a%20set.ssv"', "", {"resources/a set.ssv": given}),
    ):
        inside = bindings(binding(inline, attributes))
        found = read(tmp_path, many, body(component("a", "many.fmu", inside)), files)
        assert_close(found.system.units["a"].parameters, expected)
        row = simulate(found.system, h=0.1, until=0.1).iloc[-1]
        shown = {n: row[f"a.y_{n}"] for n in ("k", "T", "v", "n", "on", "text", "gear", "w[1]", "w[2]", "w[3]")}
        assert shown == pytest.approx(
            {
                "k": 2.5,
                "T": 293.15,
                "v": 10,
                "n": -7,
                "on": 1,
                "text": "a b",
                "gear": 5,
                "w[1]": 1,
                "w[2]": 0,
                "w[3]": 3,
            }
        )
    assert found.sources["a.v"] == {"value": 10.0, "unit": "m/s", "source": "a set.ssv"}
    ssp.write(found, tmp_path / "b.ssp")
    assert ssp_reader.read(tmp_path / "b.ssp").system.units["a"].parameters == found.system.units["a"].parameters


def test_outer_values_replace_inner_ones_and_later_ones_earlier_ones(many, tmp_path):
    own = bindings(binding(values(k=1, n=("Integer", 1, None), T=1)), binding(values(k=2, T=2)))
    inner = system("inner", component("a", "many.fmu", own), before=bindings(binding(values(**{"a.k": 3}))))
    root = bindings(
        binding(values(**{"inner.a.n": ("Integer", 4, None)})),
        binding(values(k=9, n=("Integer", 5, None)), 'prefix="inner.a."'),
    )
    parameters = read(tmp_path, many, root + body(inner)).system.units["inner_a"].parameters
    assert parameters == {"k": 9.0, "n": 5, "T": 2.0}


def test_elements_replace_wholes_and_wholes_elements_in_their_order(many, tmp_path):
    inside = bindings(binding(values(**{"w[2]": 5})))
    found = read(tmp_path, many, body(component("a", "many.fmu", inside)), version="2.0")
    assert found.system.units["a"].parameters == {"w": [0.0, 5.0, 0.0]}
    array = '<ssv:Parameter name="w"><ssv:Float64 value="1 2 3"/><ssc:Dimension size="3"/></ssv:Parameter>'
    whole = (
        f'<ssv:ParameterSet {SPACES} version="2.0" name="s"><ssv:Parameters>{array}</ssv:Parameters></ssv:ParameterSet>'
    )
    for pair, expected in (((whole, values(**{"w[2]": 5})), [1, 5, 3]), ((values(**{"w[2]": 5}), whole), [1, 2, 3])):
        inside = bindings(*map(binding, pair))
        found = read(tmp_path, many, body(component("a", "many.fmu", inside)), version="2.0")
        assert found.system.units["a"].parameters == {"w": expected}


def test_values_whose_names_nothing_has_are_passed_over_and_told(many, tmp_path):
    inside = bindings(binding(values(k=1, q=2, r=3)))
    found = read(tmp_path, many, body(component("a", "many.fmu", inside)))
    assert found.system.units["a"].parameters == {"k": 1.0}
    (remark,) = (r for r in found.remarks if "no variable" in r)
    assert remark.endswith("SystemStructure.ssd, line 6: no variable has the names of these values: q, r")


def test_a_mapping_renames_transforms_and_leaves_out(many, tmp_path):
    given = values(a=2, speed=("Real", 36, "km/h"), raw=("Real", 36, "km/h"), state=("Boolean", "true", None), k=8)
    entry = '<ssc:MapEntry source="true" target="false"/>'
    swapped = f"<ssc:BooleanMappingTransformation>{entry}</ssc:BooleanMappingTransformation>"
    entries = [
        ("a", "w[1]"),
        ("a", "w[2]", "", linear(10, 1)),
        ("speed", "v", "", linear(2, 0.5)),
        ("raw", "w[3]", 'suppressUnitConversion="true"', linear(2)),
        ("state", "on", "", swapped),
    ]
    expected = {"w": [2.0, 21.0, 72.0], "v": 20.5, "on": False}
    element, text = mapping(*entries, source="resources/a.ssm")
    for made, files in ((mapping(*entries), {}), (element, {"resources/a.ssm": text})):
        inside = bindings(binding(given, mapping=made))
        found = read(tmp_path, many, body(component("a", "many.fmu", inside)), files)
        assert_close(found.system.units["a"].parameters, expected)
    inside = bindings(
        binding(values(speed=("Real", 36, "km/h")), mapping=mapping(("speed", "v", 'suppressUnitConversion="true"')))
    )
    assert read(tmp_path, many, body(component("a", "many.fmu", inside))).system.units["a"].parameters == {"v": 36.0}


def test_items_and_numbers_of_enumerations_are_mapped(many, tmp_path):
    items = '<ssc:Item name="low" value="7"/><ssc:Item name="high" value="8"/>'
    items = f'<ssc:Enumeration name="Old">{items}</ssc:Enumeration>'

    def found(kind, entry, value):
        given = (
            f'<ssv:ParameterSet {SPACES} version="1.0" name="s"><ssv:Parameters><ssv:Parameter name="g">'
            f'<ssv:Enumeration name="Old" value="{value}"/></ssv:Parameter></ssv:Parameters>'
            f"<ssv:Enumerations>{items}</ssv:Enumerations></ssv:ParameterSet>"
        )
        change = f"<ssc:{kind}MappingTransformation>{entry}</ssc:{kind}MappingTransformation>"
        inside = bindings(binding(given, mapping=mapping(("g", "gear", "", change))))
        return read(tmp_path, many, body(component("a", "many.fmu", inside))).system.units["a"].parameters["gear"]

    named = '<ssc:MapEntry source="low" target="one"/><ssc:MapEntry source="high" target="two"/>'
    assert found("Enumeration", named, "high") == 5
    assert found("Integer", '<ssc:MapEntry source="7" target="5"/>', "low") == 5


def test_parameters_of_systems_lead_to_those_of_components(many, tmp_path):
    inner = system(
        "inner",
        component(
            "a", "many.fmu", connectors("k:parameter", "v:parameter:m/s", "u:input") + bindings(binding(values(k=1)))
        ),
        wire("p", "a.k", linear(2)) + wire("speed", "a.v") + wire("speed", "a.u"),
        connectors("p:parameter", "speed:parameter:km/h") + bindings(binding(values(p=5, speed=18))),
    )
    found = read(tmp_path, many, body(inner)).system
    assert found.units["inner_a"].parameters == {"k": 10.0, "v": 5.0}
    assert found.held == {"inner_a.u": 5.0}
    outer = connectors("p:parameter") + bindings(binding(values(p=7)))
    found = read(tmp_path, many, outer + body(inner, wire("p", "inner.p"))).system
    assert found.units["inner_a"].parameters["k"] == 14.0  # further out counts more


def test_start_values_of_inputs_and_of_connectors_of_the_system_are_held(many, tmp_path):
    own = bindings(binding(values(u=("Real", 36, "km/h"))))
    found = read(tmp_path, many, body(component("a", "many.fmu", own)))
    assert found.system.held == {"a.u": 10.0}
    outer = connectors("i:input") + bindings(binding(values(i=("Real", 72, "km/h"))))
    whole = outer + body(component("a", "many.fmu", connectors("u:input")), wire("i", "a.u"))
    assert read(tmp_path, many, whole).system.held == {"a.u": 20.0}


def test_start_values_of_states_are_set(tmp_path):
    """A local variable with `initial="exact"` is no parameter, but may be set before the initialisation."""
    plain = echo(tmp_path / "plain.fmu", ["u"])
    state = '<ScalarVariable name="x" valueReference="7" causality="local" initial="exact"><Real start="1"/>'
    state += "</ScalarVariable>"
    shown = '<ScalarVariable name="y_x" valueReference="107" causality="output"><Real/></ScalarVariable>'
    text = (
        entries(plain)["modelDescription.xml"].decode().replace("</ModelVariables>", f"{state}{shown}</ModelVariables>")
    )
    text = text.replace("</Outputs>", '<Unknown index="4" dependencies=""/></Outputs>')
    text = text.replace("</InitialUnknowns>", '<Unknown index="4" dependencies=""/></InitialUnknowns>')
    copied(plain, tmp_path / "many.fmu", {"modelDescription.xml": text.encode()})
    found = read(tmp_path, tmp_path / "many.fmu", body(component("a", "many.fmu", bindings(binding(values(x=4))))))
    assert found.system.units["a"].parameters == {"x": 4.0}
    assert simulate(found.system, h=0.1, until=0.1)["a.y_x"].tolist() == [0.0, 4.0]
    ssp.write(found, tmp_path / "b.ssp")
    assert ssp_reader.read(tmp_path / "b.ssp").system.units["a"].parameters == {"x": 4.0}


def test_structural_parameters_decide_the_lengths_of_arrays(tmp_path):
    fmu = vectors(tmp_path / "many.fmu")
    array = '<ssv:Parameter name="w"><ssv:Float64 value="1 2 3 4"/><ssc:Dimension size="4"/></ssv:Parameter>'
    length = '<ssv:Parameter name="n"><ssv:UInt64 value="4"/></ssv:Parameter>'
    given = f"<ssv:Parameters>{length}{array}</ssv:Parameters>"
    given = f'<ssv:ParameterSet {SPACES} version="2.0" name="s">{given}</ssv:ParameterSet>'
    whole = body(component("a", "many.fmu", bindings(binding(given))))
    found = read(tmp_path, fmu, whole, version="2.0")
    assert found.system.units["a"].parameters == {"n": 4}
    assert found.system.held["a.w"] == [1.0, 2.0, 3.0, 4.0]
    frame = simulate(found.system, h=0.1, until=0.1)
    assert [frame[f"a.y_w[{i}]"].iloc[-1] for i in (1, 2, 3, 4)] == [1.0, 2.0, 3.0, 4.0]


def test_a_set_may_lie_inside_the_component(many, tmp_path):
    copied(many, tmp_path / "many.fmu", {"resources/own.ssv": values(k=6).encode()})
    inside = bindings(binding("", 'source="resources/own.ssv" sourceBase="component"'))
    found = read(tmp_path, tmp_path / "many.fmu", body(component("a", "many.fmu", inside)))
    assert found.system.units["a"].parameters == {"k": 6.0}
