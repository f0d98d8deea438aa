"""Obstacles go by their id."""

from __future__ import annotations

import numpy as np

from orchestrator.results.sightings import identities, sightings

VALID = np.array([[True, True, False], [True, True, False]])


def test_an_obstacle_is_the_same_in_any_slot():
    found = identities(VALID, np.array([[7.0, 3.0, 3.0], [3.0, 7.0, np.nan]]))
    assert found[VALID].tolist() == [7, 3, 3, 7]


def test_where_two_have_the_same_id_the_slots_count():
    found = identities(VALID, np.array([[7.0, 3.0, 3.0], [4.0, 4.0, 0.0]]))
    assert found.tolist() == [[1, 2, 3], [1, 2, 3]]


def test_the_first_and_the_last_sighting_of_each():
    first, last = sightings(np.array([5, 2, 2, 9, 5]))
    assert (first.tolist(), last.tolist()) == ([1, 0, 3], [2, 4, 3])
    assert [len(i) for i in sightings(np.array([], dtype=np.int64))] == [0, 0]
