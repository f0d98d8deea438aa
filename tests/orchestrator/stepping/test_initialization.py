"""Values at the start, before anything has stepped."""

from __future__ import annotations

import itertools

import pytest

from orchestrator.stepping.master import SimulationError
from orchestrator.stepping.whole_run import simulate
from tests.orchestrator.blocks import Affine, Gain, Held, Sum, system


@pytest.mark.parametrize("names", list(itertools.permutations(["s", "g", "h", "f"]))[::5])
@pytest.mark.parametrize("algorithm", ["sequential", "jacobi"])
def test_a_chain_is_settled_at_the_start_in_whatever_order_its_units_come(names, algorithm):
    units = {"s": Sum(), "g": Gain(k=2.0), "h": Held(), "f": Affine(k=1.0, d=5.0)}
    wiring = {"g.a": "s.b", "h.a": "g.b", "f.a": "h.b", "s.a": "f.b"}
    frame = simulate(system({n: units[n] for n in names}, wiring), h=1.0, until=0.0, algorithm=algorithm)
    assert frame.iloc[0].to_dict() == {
        "time": 0.0,
        "s.b.value": 1.0,
        "g.b.value": 2.0,
        "h.b.value": 1002.0,
        "f.b.value": 1007.0,
    }


def test_a_loop_that_contracts_settles_under_jacobi():
    made = system({"p": Affine(k=0.5, d=1.0), "q": Gain(k=0.5)}, {"p.a": "q.b", "q.a": "p.b"})
    frame = simulate(made, h=1.0, until=0.0, algorithm="jacobi")
    assert frame["p.b.value"][0] == pytest.approx(1 / 0.75, rel=1e-11)


def test_a_loop_that_grows_is_told():
    made = system({"p": Affine(k=2.0, d=1.0)}, {"p.a": "p.b"})
    with pytest.raises(SimulationError) as error:
        simulate(made, h=1.0, until=0.0, algorithm="jacobi")
    text = "tick 0 (t = 0 s), unit `p`: the initialisation does not settle: `p.b.value` is still 1.2"
    assert str(error.value).startswith(text)
    assert " after 100 passes: it was 6.3" in str(error.value)
