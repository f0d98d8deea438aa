"""The vocabulary of pictures: entity paths, and what is news."""

from __future__ import annotations

import numpy as np
import pytest
import rerun as rr

from orchestrator.pictures.shapes import Memory, entity


@pytest.mark.parametrize(
    "part", ["state", "x[1]", "a b", "der(x)", "a/b", "a\\b", "!", "x-1_2.3", "ü", "a,b", "über x"]
)
def test_an_entity_is_escaped_as_the_viewer_does(part):
    assert entity("signals", part) == str(rr.new_entity_path(["signals", part]))


def test_an_empty_part_is_left_out():
    assert entity("world", "", "ego") == "/world/ego"


def test_a_row_is_news_when_it_differs_from_the_one_before_also_in_the_batch_before():
    memory, values = Memory(), np.array([[1.0, 2.0], [1.0, 2.0], [1.0, 3.0]])
    assert memory.news("a", values).tolist() == [True, False, True]
    assert memory.news("a", values).tolist() == [True, False, True]
    assert memory.news("a", values[2:]).tolist() == [False]
    assert memory.news("b", values[2:]).tolist() == [True]


def test_a_condition_begins_once_also_over_batches():
    memory = Memory()
    assert memory.begins("a", np.array([True, True, False, True])).tolist() == [0, 3]
    assert memory.begins("a", np.array([True, False, True])).tolist() == [2]


def test_the_first_row_is_its_own_predecessor():
    memory = Memory()
    assert memory.before("a", np.array([[1], [2]])).tolist() == [[1], [1]]
    assert memory.before("a", np.array([[3], [4]])).tolist() == [[2], [3]]


def test_no_rows_are_no_news():
    memory = Memory()
    assert memory.news("x", np.zeros((0, 2))).tolist() == []
    assert memory.news("x", np.ones((1, 2))).tolist() == [True]
    assert memory.news("x", np.zeros((0, 2))).tolist() == []
    assert memory.news("x", np.ones((1, 2))).tolist() == [False]
