"""Declared against measured feedthrough."""

from __future__ import annotations

from enum import IntEnum

import numpy as np

from components.interfaces.quantity import Quantity, Type
from components.interfaces.record import Variable
from orchestrator.exchange.passport import feedthrough_measured
from orchestrator.exchange.passport.feedthrough_measured import another_value
from tests.fmus.model_exchange_models import built_models
from tests.orchestrator.exchange.passport.measured_fmus import lag, on_the_bench

AT_ONCE = "#define SHOWN i->x + i->u"


def line(path):
    with on_the_bench(path) as bench:
        return feedthrough_measured.lines(bench)[0]


def test_an_fmu_that_declares_none_and_has_none_passes(tmp_path):
    found = line(lag(tmp_path))
    assert found.mark == "passes"
    assert found.evidence == "0 pairs of output and input are seen, all of 0 that are declared"


def test_an_fmu_that_lies_about_it_fails(tmp_path):
    found = line(lag(tmp_path, AT_ONCE))
    assert found.mark == "fails"
    assert found.evidence == "`y` follows `u`, which it does not declare"
    assert (found.figures["declared"].value, found.figures["measured"].value) == (0, 1)


def test_what_is_declared_may_be_seen_or_not(tmp_path):
    assert line(lag(tmp_path, AT_ONCE, dependencies="1")).evidence == (
        "1 pairs of output and input are seen, all of 1 that are declared"
    )
    found = line(lag(tmp_path, dependencies="1"))
    assert found.mark == "passes"
    assert found.evidence == "0 pairs of output and input are seen, 1 more are declared"


def test_feedthrough_that_begins_later_is_seen(tmp_path):
    assert line(lag(tmp_path, "#define SHOWN i->x + (i->n > 5 ? i->u : 0)")).mark == "fails"


def test_a_crash_is_a_failing_line(tmp_path):
    found = line(lag(tmp_path, "#define ON_SET if (i->n > 5) abort();"))
    assert (found.mark, found.evidence) == ("fails", "its process died (SIGABRT) (moving inputs after 7 steps)")


def test_model_exchange_follows_at_once():
    found = line(built_models()["stiff", 3])
    assert found.mark == "passes"
    assert found.figures["measured"].value == 1


def moved(value, reach=0.1, **quantity):
    variable = Variable("u", Quantity("1", "", **quantity))
    return another_value(variable, np.array(value), np.full(len(value), reach)).tolist()


def test_every_type_is_moved_within_its_range():
    assert moved([1.0]) == [1.1]
    assert moved([1.0], max=1.05, min=0.0) == [0.9]
    assert moved([False, True], type=Type.BOOLEAN) == [True, False]
    assert moved([3], type=Type.INT32) == [4]
    assert moved([127], type=Type.INT8) == [126]
    gears = IntEnum("gears", {"one": 1, "two": 5})
    assert moved([1, 5], type=Type.ENUMERATION, enumeration=gears) == [5, 1]
    assert moved(["text"], type=Type.STRING) == ["text"]
