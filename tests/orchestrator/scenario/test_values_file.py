"""Values from files, a line for each."""

from __future__ import annotations

import numpy as np
import pytest

from components.interfaces.problem import RequestError
from components.interfaces.quantity import Quantity
from orchestrator.loading import load
from orchestrator.scenario.options import Options
from orchestrator.scenario.values_file import expanded
from orchestrator.system.value_texts import from_text
from tests.orchestrator.ssps import echo

TEXT = """
# what the test bench measured
fmu.v = 9 [km/h] # by radar
fmu.k=3
fmu.name = two words

"""


def test_the_lines_of_a_file_stand_where_its_name_did(tmp_path):
    (tmp_path / "values").write_text(TEXT)
    texts = ["fmu.v=1", f"@{tmp_path / 'values'}", "fmu.k=4"]
    assert expanded(texts) == ["fmu.v=1", "fmu.v=9 [km/h]", "fmu.k=3", "fmu.name=two words", "fmu.k=4"]
    fmu = echo(tmp_path / "a.fmu", [("v", "Real", "0", {"unit": "m/s"}), ("name", "String", "-")], ["k"])
    system = load(str(fmu), Options(stop_time=1.0, settings=texts)).system
    assert system.held == {"fmu.v": 2.5, "fmu.name": "two words"}
    assert system.units["fmu"].parameters == {"k": 4}


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("36 [km/h]", 10.0),
        ("36  [m/s]", 36.0),
        ("9 [kg]", "9 [kg]"),
        ("fast [km/h]", "fast [km/h]"),
        ("[36, 72] [km/h]", [10.0, 20.0]),
        ("[1, 2]", [1, 2]),
        ("[[1], [2]]", [[1], [2]]),
    ],
)
def test_a_number_may_have_a_unit_of_measurement(text, expected):
    shape = np.shape(expected) if isinstance(expected, list) else ()
    assert from_text(text, Quantity("m/s", "speed", shape=shape)) == expected


def test_what_is_no_value_is_told_with_its_line(tmp_path):
    path = tmp_path / "values"
    path.write_text("fmu.v 3\nfmu.k = 1\n= 4\n")
    with pytest.raises(RequestError) as error:
        expanded([f"@{path}"])
    assert str(error.value).splitlines() == [
        f"--set @{path}, line 1: found `fmu.v 3`; valid: UNIT.PARAMETER = VALUE",
        f"--set @{path}, line 3: found `= 4`; valid: UNIT.PARAMETER = VALUE",
    ]
    with pytest.raises(RequestError, match=r"found no such file"):
        expanded(["@nothing"])
    path.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(
        RequestError,
        match="line 1: found a file that is no text: bytes that are no UTF-8; valid: ",
    ):
        expanded([f"@{path}"])
