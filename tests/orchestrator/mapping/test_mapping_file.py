"""A mapping that is written reads back as the same mapping."""

from __future__ import annotations

import datetime as dt
import math
import tomllib
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from components.interfaces.sockets import PLANT
from orchestrator.mapping.mapping_file import Amount, Entry, MappingFile, toml_value, written
from orchestrator.mapping.mapping_reader import parse_mapping

names = st.text(st.characters(exclude_categories=["Cs"]), min_size=1, max_size=12)
finite = st.floats(allow_nan=False, allow_infinity=False)
amounts = st.builds(Amount, finite | st.integers(-99, 99) | st.booleans(), names)
numbers = st.dictionaries(st.sampled_from(["factor", "offset", "min", "max"]), st.builds(Amount, finite, names))
entries = (
    st.builds(Entry, st.tuples(names), unit=st.none() | names, numbers=numbers)
    | st.builds(Entry, constant=amounts)
    | st.just(Entry(unused=True))
)
distances = st.builds(Amount, finite, names)
signals = [v.name for v in PLANT.signals()]
mappings = st.builds(
    MappingFile,
    where=st.just("map.toml"),
    socket=st.just("plant"),
    axes=st.sampled_from(["iso8855", "y_right"]),
    feedthrough=st.booleans(),
    signals=st.dictionaries(st.sampled_from(signals), st.lists(entries, min_size=1, max_size=3).map(tuple)),
    references=st.dictionaries(
        st.just("state"),
        st.tuples(st.sampled_from(["rear_axle", "ahead"]), distances) | st.just(("centre_of_gravity", None)),
    ),
    velocities=st.dictionaries(st.just("state"), st.sampled_from(["road", "speed_and_slip"])),
    constants=st.dictionaries(names, amounts),
    parameters=st.dictionaries(names, amounts),
)


@given(mapping=mappings)
def test_what_is_written_reads_back(mapping):
    text = written(mapping, "sub/theirs.fmu")
    again = parse_mapping(tomllib.loads(text), "map.toml", "plant", Path())
    assert again == replace(mapping, fmu=Path("sub/theirs.fmu"))


@pytest.mark.parametrize(
    ("value", "text"),
    [
        ({"point": "rear_axle", "distance": {"value": 1.4}}, '{ point = "rear_axle", distance = { value = 1.4 } }'),
        ([True, 2, "a\x7f\n"], '[true, 2, "a\\u007f\\n"]'),
        ([math.inf, -math.inf, 1e22], "[inf, -inf, 1e+22]"),
        (dt.date(2020, 1, 2), "2020-01-02"),
    ],
)
def test_values_stand_in_one_line(value, text):
    assert toml_value(value) == text
    assert tomllib.loads(f"x = {text}") == {"x": value}
