"""Elements of FMI 2.0 become arrays where they fill their shape, whatever their names would take."""

from __future__ import annotations

import pytest

from fmus.reading.joined_arrays import array_name
from fmus.reading.opening import open_fmu
from fmus.toolchain.version import Version
from tests.fmus.foreign import description2, pack, scalar
from tests.orchestrator.ssps import echo_library


@pytest.mark.parametrize(
    ("name", "array"),
    [
        ("p[1]", "p"),
        ("p[1,2]", "p"),
        ("p[1][2, 3]", "p"),
        ("a[1].b[2]", "a[1].b"),
        ("p[1]x", None),
        ("[1]", None),
        ("p[]", None),
        ("p[x]", None),
        ("p[-1]", None),
        ("p[²]", None),
        ("p[٣]", None),
        (f"p[{'9' * 5000}]", None),
        (f"p{'[1]' * 31}", "p"),
        (f"p[{','.join(['1'] * 40)}]", None),
    ],
)
def test_indices_are_numbers_in_brackets(name, array):
    assert array_name(name) == array


def test_a_name_of_very_many_brackets_takes_no_time():
    assert array_name("p" + "[1" * 100_000 + "]") is not None
    assert array_name("p" + "[1]" * 100_000 + "x]") is None


@pytest.mark.parametrize("last", ["p[2000000000]", "p[3]", "p[1,2]"])
def test_elements_that_fill_no_shape_stay_scalar(tmp_path, last):
    scalars = [scalar(n, k, "parameter", of_start="0", variability="fixed") for k, n in enumerate(("p[1]", last))]
    path = pack(tmp_path / "m.fmu", Version.FMI2, description2(scalars), echo_library(Version.FMI2))
    assert [v.name for v in open_fmu(path).interface.parameters] == ["p[1]", last]


@pytest.mark.parametrize("other", ["p", "p[1][1]"])
def test_elements_whose_array_would_have_the_name_of_another_stay_scalar(tmp_path, other):
    scalars = [scalar("p[1]", 1, "input", of_start="0"), scalar(other, 2, "output")]
    interface = open_fmu(
        pack(
            tmp_path / "m.fmu",
            Version.FMI2,
            description2(scalars, ['<Unknown index="2"/>']),
            echo_library(Version.FMI2),
        )
    ).interface
    assert [(v.name, v.shape) for v in interface.inputs] == [("p[1]", ())]
    assert [(v.name, v.shape) for v in interface.outputs] == [(other, ())]
