"""Clocks as a model description declares them; what a running FMU makes of them shows `units/test_clocked_unit.py`."""

from __future__ import annotations

import pytest
from lxml import etree

from fmus.clock import Clock, clock_of


def declared(**attributes):
    root = etree.Element("fmiModelDescription")
    variables = etree.SubElement(root, "ModelVariables")
    etree.SubElement(variables, "Float64", name="x", valueReference="1")
    etree.SubElement(variables, "Clock", name="c", valueReference="7", **attributes)
    (clock,) = _clocks(root)
    return clock


def test_a_clock_without_attributes_is_local_and_triggered():
    clock = declared()
    assert clock == Clock("c", "local", "triggered", reference=7)
    assert not clock.is_time_based
    assert not clock.is_triggered_input


def test_intervals_are_decimal_or_counted():
    decimal = declared(causality="input", intervalVariability="constant", intervalDecimal="0.25", shiftDecimal="0.05")
    assert (decimal.interval, decimal.shift) == (0.25, 0.05)
    counted = declared(
        causality="input", intervalVariability="constant", resolution="1000", intervalCounter="250", shiftCounter="50"
    )
    assert (counted.interval, counted.shift) == (0.25, 0.05)
    assert declared(causality="input", intervalVariability="fixed").interval is None


@pytest.mark.parametrize("variability", ["constant", "fixed", "tunable", "changing", "countdown", "triggered"])
def test_only_input_clocks_are_made_to_tick(variability):
    clock = declared(causality="input", intervalVariability=variability)
    assert clock.is_time_based is (variability != "triggered")
    assert clock.is_triggered_input is (variability == "triggered")
    other = declared(causality="output", intervalVariability=variability)
    assert not other.is_time_based
    assert not other.is_triggered_input


@pytest.mark.parametrize("interval", ["0,1", "low", "-1", "INF", "NaN", "1e999", ""])
def test_times_that_are_none_are_no_clock(interval):
    with pytest.raises(ValueError, match=r"could not convert|an interval of"):
        declared(causality="input", intervalVariability="constant", intervalDecimal=interval)


def _clocks(root):
    return tuple(clock_of(element) for element in root.iterfind("ModelVariables/Clock"))
