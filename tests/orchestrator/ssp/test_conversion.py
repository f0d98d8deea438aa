"""Values change their units and are transformed on their way, hop by hop, as the standard says.

This shows `conversion.py` and `transformations.py`.
"""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from components.interfaces.conversion import Linear
from components.interfaces.problem import RequestError
from orchestrator.scenario.options import Options
from orchestrator.ssp import reader as ssp_reader
from orchestrator.ssp import writer as ssp
from orchestrator.ssp.archive import Findings
from orchestrator.ssp.conversion import composed
from orchestrator.ssp.transformations import ConversionStep
from orchestrator.ssp.types import DeclaredType
from orchestrator.stepping.whole_run import simulate
from orchestrator.system.source import Fmu
from orchestrator.system.system import System
from tests.orchestrator.ssps import (
    binding,
    bindings,
    body,
    component,
    connectors,
    echo,
    linear,
    system,
    values,
    wire,
    write,
)


def enumeration(name, *items):
    listed = "".join(f'<Item name="{item}" value="{value}"/>' for item, value in items)
    return f'<SimpleType name="{name}"><Enumeration>{listed}</Enumeration></SimpleType>'


GEAR = enumeration("Gear", ("one", 1), ("two", 5))
OLD = enumeration("Old", ("low", 1), ("high", 2))
ENUMERATIONS = (
    '<ssd:Enumerations><ssc:Enumeration name="Gear"><ssc:Item name="one" value="1"/><ssc:Item name="two" value="5"/>'
    '</ssc:Enumeration><ssc:Enumeration name="Old"><ssc:Item name="low" value="1"/><ssc:Item name="high" value="2"/>'
    "</ssc:Enumeration></ssd:Enumerations>"
)


@pytest.fixture(scope="module")
def fmus(tmp_path_factory):
    """FMUs whose parameters come out: speeds in m/s, in km/h, without units; whole numbers; enumerations."""
    folder = tmp_path_factory.mktemp("fmus")

    def speeds(name, unit):
        of = {"unit": unit} if unit else {}
        return echo(folder / f"{name}.fmu", [("u", "Real", "0", of)], [("k", "Real", "0", of)])

    others = [("n", "Integer", "0"), ("on", "Boolean", "false")]
    return {
        "resources/ms.fmu": speeds("ms", "m/s"),
        "resources/kmh.fmu": speeds("kmh", "km/h"),
        "resources/bare.fmu": speeds("bare", ""),
        "resources/length.fmu": speeds("length", "m"),
        "resources/others.fmu": echo(folder / "others.fmu", others, [(f"p{n}", *rest) for n, *rest in others]),
        "resources/gear.fmu": echo(
            folder / "gear.fmu", [("g", "Enumeration", "1", {"declaredType": "Gear"})], types=GEAR
        ),
        "resources/old.fmu": echo(
            folder / "old.fmu", [], [("g", "Enumeration", "1", {"declaredType": "Old"})], types=OLD
        ),
    }


def giver(fmu, value, unit=""):
    unit = f":{unit}" if unit else ""
    return component("a", f"{fmu}.fmu", connectors(f"y_k:output{unit}") + bindings(binding(values(k=value))))


def taker(fmu, unit=""):
    unit = f":{unit}" if unit else ""
    return component("b", f"{fmu}.fmu", connectors(f"u:input{unit}", f"y_u:output{unit}"))


def settled(path, name="b.y_u"):
    """The last value of a signal; the same after writing and reading the system again."""
    read = ssp_reader.read(path, options=Options(stop_time=0.6))
    ssp.write(read, path.with_suffix(".again.ssp"))
    again = ssp_reader.read(path.with_suffix(".again.ssp"))
    frames = [simulate(s.system, h=0.1, until=0.6) for s in (read, again)]
    assert frames[0].equals(frames[1])
    return frames[0][name].iloc[-1]


SUPPRESS = 'suppressUnitConversion="true"'


@pytest.mark.parametrize(
    ("start", "end", "inside", "attributes", "expected"),
    [
        (("ms", 10), ("kmh", ""), "", "", 36.0),
        (("ms", 10), ("kmh", ""), linear(2, 1), "", 73.0),
        (("ms", 10), ("kmh", ""), linear(2, 1), SUPPRESS, 21.0),
        (("ms", 10), ("kmh", ""), "", SUPPRESS, 10.0),
        (("ms", 10), ("length", ""), linear(3), SUPPRESS, 30.0),
        (("bare", 10, "m/s"), ("bare", "km/h"), "", "", 36.0),
        (("bare", 10, "m/s"), ("bare", "km/h"), linear(2, 1), "", 73.0),
        (("bare", 10), ("kmh", ""), linear(-1), "", -10.0),
    ],
)
def test_units_change_first_and_the_transformation_applies_then(
    fmus, tmp_path, start, end, inside, attributes, expected
):
    whole = body(giver(*start) + taker(*end), wire("a.y_k", "b.u", inside, attributes))
    assert settled(write(tmp_path / "a.ssp", whole, fmus)) == pytest.approx(expected, rel=1e-14)


def test_a_transformed_system_is_the_same_system_built_by_hand(fmus, tmp_path):
    path = write(tmp_path / "a.ssp", body(giver("ms", 10) + taker("kmh"), wire("a.y_k", "b.u", linear(2, 1))), fmus)
    units = {"a": Fmu(fmus["resources/ms.fmu"], {"k": 10.0}), "b": Fmu(fmus["resources/kmh.fmu"])}
    held = {"a.u": 0.0}
    by_hand = System(units, {"b.u": "a.y_k"}, held, transformations={"b.u": Linear(2.0, 1.0)})
    found, expected = (simulate(s, h=0.1, until=0.5) for s in (ssp_reader.read(path).system, by_hand))
    assert found.to_numpy() == pytest.approx(expected.to_numpy(), rel=1e-15)


def test_a_plain_change_of_unit_is_left_to_the_system(fmus, tmp_path):
    path = write(tmp_path / "a.ssp", body(giver("ms", 10) + taker("kmh"), wire("a.y_k", "b.u")), fmus)
    found = ssp_reader.read(path).system
    assert (found.transformations, found.unconverted) == ({}, frozenset())


@pytest.mark.parametrize(
    ("first", "second", "unit", "expected"),
    [
        (("", ""), ("", ""), "", 36.0),
        (("", ""), ("", ""), ":km/h", 36.0),
        ((linear(2), ""), (linear(1, 5), ""), "", 77.0),  # (10 m/s * 2 -> km/h) + 5
        ((linear(2, 1), ""), (linear(10), ""), ":km/h", 730.0),  # ((10 m/s -> km/h) * 2 + 1) * 10
        (("", SUPPRESS), ("", ""), ":km/h", 10.0),
        (("", SUPPRESS), ("", ""), ":m/s", 36.0),
    ],
)
def test_every_connector_on_the_way_has_its_unit(fmus, tmp_path, first, second, unit, expected):
    inner = system("inner", taker("kmh"), wire("i", "b.u", *second), connectors(f"i:input{unit}"))
    whole = body(giver("ms", 10) + inner, wire("a.y_k", "inner.i", *first))
    path = write(tmp_path / "a.ssp", whole, fmus)
    assert settled(path, "inner_b.y_u") == pytest.approx(expected, rel=1e-14)


def test_whole_numbers_and_booleans_are_mapped_and_the_rest_stays(fmus, tmp_path):
    ports = connectors("y_pn:output", "n:input", kind="Integer") + connectors(
        "y_pon:output", "on:input", kind="Boolean"
    )
    ports = ports.replace("</ssd:Connectors><ssd:Connectors>", "")

    def one(n, on):
        made = bindings(binding(values(pn=("Integer", n, None), pon=("Boolean", on, None))))
        numbers = '<ssc:MapEntry source="3" target="30"/><ssc:MapEntry source="4" target="-4"/>'
        switched = '<ssc:MapEntry source="true" target="false"/><ssc:MapEntry source="false" target="true"/>'
        wires = wire("a.y_pn", "b.n", f"<ssc:IntegerMappingTransformation>{numbers}</ssc:IntegerMappingTransformation>")
        wires += wire(
            "a.y_pon", "b.on", f"<ssc:BooleanMappingTransformation>{switched}</ssc:BooleanMappingTransformation>"
        )
        whole = body(component("a", "others.fmu", ports + made) + component("b", "others.fmu", ports), wires)
        path = write(tmp_path / "a.ssp", whole, fmus)
        return settled(path, "b.y_n"), settled(path, "b.y_on")

    assert one(3, "true") == (30, 0)
    assert one(7, "false") == (7, 1)


def test_items_of_one_enumeration_become_those_of_another(fmus, tmp_path):
    def port(name, kind, items):
        inside = f'<ssd:Connector name="{name}" kind="{kind}"><ssc:Enumeration name="{items}"/></ssd:Connector>'
        return f"<ssd:Connectors>{inside}</ssd:Connectors>"

    made = bindings(binding(values(g=("Enumeration", "high", None))))
    named = '<ssc:MapEntry source="low" target="one"/><ssc:MapEntry source="high" target="two"/>'
    wires = wire(
        "a.y_g", "b.g", f"<ssc:EnumerationMappingTransformation>{named}</ssc:EnumerationMappingTransformation>"
    )
    whole = body(
        component("a", "old.fmu", port("y_g", "output", "Old") + made)
        + component("b", "gear.fmu", port("g", "input", "Gear")),
        wires,
    )
    end = ENUMERATIONS + '<ssd:DefaultExperiment stopTime="0.3"/>'
    assert settled(write(tmp_path / "a.ssp", whole, fmus, end=end, units=False), "b.y_g") == 5
    whole = whole.replace("high", "highest")
    with pytest.raises(RequestError) as error:
        ssp_reader.read(write(tmp_path / "a.ssp", whole, fmus, end=end, units=False))
    assert [str(p).partition("a.ssp, ")[2] for p in error.value.problems] == [
        "SystemStructure.ssd, line 6: parameter `g`: found `highest`; valid: high, low",
        "SystemStructure.ssd, line 12: a.y_g -> b.g: found the enumeration item `highest`; valid: low, high",
    ]


SPEEDS = {"m/s": 1.0, "km/h": 1 / 3.6, "m/h": 1 / 3600, "km/s": 1000.0}
hops = st.tuples(
    st.sampled_from(["", *SPEEDS]), st.booleans(), st.none() | st.tuples(st.floats(-9, 9), st.floats(-9, 9))
)


@given(first=st.sampled_from(["", *SPEEDS]), way=st.lists(hops, max_size=5), x=st.floats(-100, 100))
def test_all_steps_joined_are_the_steps_one_by_one(first, way, x):
    findings, here, expected, steps = Findings(), first, x, []
    for unit, as_it_is, change in way:
        if here and unit and not as_it_is:
            expected *= SPEEDS[here] / SPEEDS[unit]
        expected = expected if change is None else change[0] * expected + change[1]
        here = unit or ("" if as_it_is else here)
        declared = DeclaredType("Real", unit or None)
        steps.append(ConversionStep("here", Linear(*change) if change else None, as_it_is, declared))
    total = composed(DeclaredType("Real", first or None), steps, findings)
    assert findings.problems == []
    assert total(x) == pytest.approx(expected, rel=1e-9, abs=1e-6)
