"""SSPs of other makers: structure, connections and experiment become a system that runs like one built by hand."""

from __future__ import annotations

import pytest

from orchestrator import ssp_reader
from orchestrator.master import simulate
from orchestrator.parameters import Setting
from orchestrator.system import Fmu, System
from tests.orchestrator.ssps import (
    body,
    component,
    connectors,
    echo,
    system,
    wire,
    write,
)


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    """An FMU with an input u and a parameter k, both shown after a step."""
    return echo(tmp_path_factory.mktemp("fmus") / "plain.fmu", ["u"], [("k", "Real", "3")])


def run(scenario):
    return simulate(scenario.system, h=scenario.h, until=scenario.until)


def test_a_chain_of_nested_systems_runs_like_the_same_system_built_by_hand(plain, tmp_path):
    ports = connectors("u:input", "y_u:output")
    inner = system(
        "inner",
        component("c", "plain.fmu", ports),
        wire("x", "c.u") + wire("c.y_u", "z"),
        connectors("x:input", "z:output"),
    )
    outer = system(
        "outer",
        inner + component("d", "plain.fmu", ports),
        wire("i", "inner.x") + wire("d.u", "inner.z") + wire("d.y_u", "o") + wire("i", "through"),
        connectors("i:input", "o:output", "through:output"),
    )
    whole = (
        outer
        + component("a", "plain.fmu", connectors("k:parameter", "y_k:output", "u:input"))
        + component("b", "plain.fmu", ports)
    )
    wires = wire("a.y_k", "outer.i") + wire("outer.o", "a.u") + wire("outer.through", "b.u")
    path = write(tmp_path / "theirs.ssp", body(whole, wires), {"resources/plain.fmu": plain})
    read = ssp_reader.read(path, {"a": [Setting("a", "k", None, 3.0)]})
    assert {str(c) for c in read.system.connections} == {
        "a.y_k -> outer_inner_c.u", "outer_inner_c.y_u -> outer_d.u", "outer_d.y_u -> a.u", "a.y_k -> b.u"
    }  # fmt: skip
    units = {name: Fmu(plain, {"k": 3.0} if name == "a" else {}) for name in ("outer_inner_c", "outer_d", "a", "b")}
    by_hand = System(
        units, {"outer_inner_c.u": "a.y_k", "outer_d.u": "outer_inner_c.y_u", "a.u": "outer_d.y_u", "b.u": "a.y_k"}
    )
    found, expected = run(read), simulate(by_hand, h=0.1, until=0.3)
    assert found.equals(expected[found.columns])
    assert found["b.y_u"].tolist()[-1] == 3.0
    assert (read.name, read.h, read.until) == ("theirs", 0.1, 0.3)
    assert "units: `outer_inner_c` is `outer.inner.c`, `outer_d` is `outer.d`" in read.remarks
