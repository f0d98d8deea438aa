"""How the variants of a sweep are sampled."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import qmc

from components.interfaces.problem import RequestError
from components.interfaces.quantity import Quantity
from orchestrator.sweeping.sampling import SAMPLINGS, read_sampling, sampled
from orchestrator.sweeping.variation import variation

M = Quantity("kg", "")
TWO = (variation("plant.m", "0:1", M), variation("plant.k", "0:10", M))


def shares(samples, variations=TWO, seed=7):
    columns = sampled(read_sampling(samples, None, variations), variations, seed)
    return np.array([[float(x) for x in values] for values in columns.values()]).T


def refused(samples, grid=None, variations=TWO):
    with pytest.raises(RequestError) as error:
        read_sampling(samples, grid, variations)
    return str(error.value)


@pytest.mark.parametrize("kind", SAMPLINGS)
@given(count=st.integers(1, 40), seed=st.integers(0, 5))
def test_the_same_seed_gives_the_same_values(kind, count, seed):
    made = shares(f"{kind}:{count}", seed=seed)
    np.testing.assert_array_equal(made, shares(f"{kind}:{count}", seed=seed))
    assert len(made) == (count * 4 if kind == "saltelli" else count)
    assert (made[:, 0] < 1).all()
    if count > 1:
        assert not np.array_equal(made, shares(f"{kind}:{count}", seed=seed + 100))


def test_a_latin_hypercube_has_one_value_in_each_row_and_sobol_fills_the_square():
    lhs = shares("lhs:50")
    assert sorted(np.floor(lhs[:, 0] * 50)) == list(range(50))
    unit = np.array([1.0, 10.0])
    assert qmc.discrepancy(shares("sobol:256") / unit) < 0.2 * qmc.discrepancy(shares("random:256") / unit)


def test_saltellis_scheme_mixes_one_column_at_a_time():
    a, b, first, second = np.split(shares("saltelli:16"), 4)
    np.testing.assert_array_equal(first, np.stack([b[:, 0], a[:, 1]], axis=1))
    np.testing.assert_array_equal(second, np.stack([a[:, 0], b[:, 1]], axis=1))


def test_a_grid_has_every_combination_the_first_varies_slowest():
    three = (*TWO[:1], variation("plant", "a,b", None))
    columns = sampled(read_sampling(None, "3", three), three, 0)
    assert columns == {"plant.m": ["0.0", "0.0", "0.5", "0.5", "1.0", "1.0"], "plant": ["a", "b"] * 3}
    assert len(sampled(read_sampling(None, "20,5", TWO), TWO, 0)["plant.k"]) == 100
    lists = (variation("a.b", "1,2", M), variation("a.c", "3,4", M))
    assert sampled(read_sampling(None, None, lists), lists, 0) == {"a.b": ["1", "1", "2", "2"], "a.c": ["3", "4"] * 2}


def test_a_table_has_a_column_for_each_path(tmp_path):
    (tmp_path / "cases.csv").write_text("variant,plant.m, plant\n0,1500,bicycle\n1, 1.6e3,a.fmu\n")
    columns = sampled(read_sampling(str(tmp_path / "cases.csv"), None, ()), (), 0)
    assert columns == {"plant.m": ["1500", "1.6e3"], "plant": ["bicycle", "a.fmu"]}
    pd.DataFrame({"plant.m": [1500.0], "c.flag": [True]}).to_parquet(tmp_path / "cases.parquet")
    columns = sampled(read_sampling(str(tmp_path / "cases.parquet"), None, ()), (), 0)
    assert columns == {"plant.m": ["1500.0"], "c.flag": ["true"]}


@pytest.mark.parametrize(
    ("content", "told"),
    [
        (None, "found no such file"),
        (b"", "found a file that cannot be read"),
        (b"\xff\xfe\x00", "found a file that cannot be read"),
        (b"plant.m\n", "found a table without values"),
        (b"plant.m,plant.m \n1,2\n", "found the column plant.m twice"),
        (b"variant\n1\n", "found a table without values"),
    ],
)
def test_a_table_that_is_none_is_refused(tmp_path, content, told):
    file = tmp_path / "cases.csv"
    if content is not None:
        file.write_bytes(content)
    with pytest.raises(RequestError) as error:
        sampled(read_sampling(str(file), None, ()), (), 0)
    assert told in str(error.value)


@pytest.mark.parametrize(
    ("samples", "grid", "told"),
    [
        ("sobol:4", "3", "--samples, --grid: found both; valid: one of them"),
        ("sobol:0", None, "--samples sobol:0: found `0` variants; valid: KIND:NUMBER"),
        ("sobol", None, "--samples sobol: found `` variants"),
        ("lsh:4", None, "--samples lsh:4: found the unknown kind `lsh`"),
        ("lhs:999999999", None, "--samples lhs:999999999: found 999999999 variants; valid: 10000000 of them at most"),
        (None, "a", "--grid a: found text of another form; valid: a whole number, or one for each variation: 20,5"),
        (None, "3,4,5", "--grid 3,4,5: found 3 numbers for 2 variations; valid: one number, or one for each"),
        (None, "9999", "--grid 9999: found 99980001 variants; valid: 10000000 of them at most"),
        (None, None, "--samples: found nothing that says how plant.m=0:1 is sampled"),
    ],
)
def test_a_sampling_that_does_not_fit_is_refused(samples, grid, told):
    assert refused(samples, grid).startswith(told)
