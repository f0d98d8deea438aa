"""Results in columns are those that were put in, and those of a journal, whatever a variant has."""

from __future__ import annotations

import tracemalloc

import pytest
from hypothesis import given
from hypothesis import strategies as st

from orchestrator.sweeping.journal import VariantResult, VariantResults, read_journal, write_journal

NAMES = st.sampled_from("abc")
RESULTS = st.builds(
    VariantResult,
    st.integers(0, 20),
    st.floats(0, 10),
    st.dictionaries(NAMES, st.floats(allow_nan=False, allow_infinity=False)),
    st.dictionaries(NAMES, st.booleans()),
    st.sampled_from(["", "it died"]),
    st.sampled_from(["", "death"]),
    st.dictionaries(NAMES, st.binary(min_size=1, max_size=16)),
)


@given(st.lists(RESULTS, unique_by=lambda result: result.variant))
def test_results_come_back_as_they_were(tmp_path_factory, results):
    known = {result.variant: result for result in results}
    assert VariantResults(known) == known
    assert list(VariantResults(known)) == list(known)
    folder = tmp_path_factory.mktemp("done")
    write_journal(folder, results)
    assert read_journal(folder) == known


def test_a_later_result_takes_the_place_of_an_earlier_one():
    results = VariantResults({1: VariantResult(1, 0.1, {"a": 1.0, "b": 2.0}, {"v": True})})
    results[1] = VariantResult(1, 0.2, {"a": 3.0}, {}, "it died", "death")
    assert dict(results) == {1: VariantResult(1, 0.2, {"a": 3.0}, {}, "it died", "death")}


def test_what_is_done_stays_done():
    with pytest.raises(NotImplementedError):
        del VariantResults()[0]


def test_ten_thousand_take_a_few_megabytes():
    names = [f"metric_{i}" for i in range(26)]
    tracemalloc.start()
    try:
        results = VariantResults()
        for n in range(10_000):
            results[n] = VariantResult(n, 0.1, {f"{name}": n + 0.5 for name in names}, {"no_contact": True})
        taken, _ = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert taken < 6e6
