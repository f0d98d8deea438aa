"""Inputs that follow a table, with `table_file.py`, `system/input_table.py` and `stepping/table_inputs.py`."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from components.interfaces.problem import RequestError
from components.interfaces.progress import SILENT
from fmus.toolchain.version import Version
from orchestrator.execution import Execution, execute
from orchestrator.loading import load
from orchestrator.scenario.options import Options
from orchestrator.stepping.master import Simulation
from tests.fmus.foreign import description3, pack
from tests.orchestrator.ssps import component, connectors, echo, echo_library, wire, write

ITEMS = '<Item name="park" value="1"/><Item name="drive" value="2"/>'
GEARS = f'<SimpleType name="Gear"><Enumeration>{ITEMS}</Enumeration></SimpleType>'
VALID = "valid: a table: a .csv or .parquet file with the column `time` first, and one for each input"
INPUTS = (
    ("v", "Real", "7", {"unit": "m/s", "min": "-100"}),
    ("n", "Integer", "0", {"max": "9"}),
    ("on", "Boolean", "false"),
    ("name", "String", "-"),
    ("gear", "Enumeration", "1", {"declaredType": "Gear"}),
    ("x[1]", "Real", "0"),
    ("x[2]", "Real", "0"),
)


@pytest.fixture
def fmu(tmp_path):
    """An FMU that shows all its inputs one step later."""
    return echo(tmp_path / "a.fmu", INPUTS, types=GEARS)


def table(folder, text):
    path = folder / "inputs.csv"
    path.write_text(text)
    return str(path)


def ran(request, **options):
    loaded = load(str(request), Options(stop_time=0.4, **options))
    with Simulation(loaded.system, h=loaded.h, until=loaded.until) as simulation:
        simulation.run()
        return simulation.frame(), loaded.remarks


def refusal(request, **options):
    with pytest.raises(RequestError) as error:
        load(str(request), Options(stop_time=0.4, **options))
    return str(error.value)


def test_numbers_are_interpolated_and_all_else_holds(fmu, tmp_path):
    text = (
        "time, fmu.v [km/h], n, on, name, gear, x[2]\n"
        "0, 0, 1, false, slow, park, -1\n"
        "0.2, 72, 2.0, 1, fast, drive, -1\n"
        "0.4, 0, 3, true, fast, 2, -3\n"
    )
    frame, remarks = ran(fmu, input=table(tmp_path, text))
    assert frame["fmu.v"].tolist() == pytest.approx([0, 10, 20, 10, 0])
    assert frame["fmu.n"].tolist() == [1, 1, 2, 2, 3]
    assert frame["fmu.on"].tolist() == [False, False, True, True, True]
    assert frame["fmu.name"].tolist() == ["slow", "slow", "fast", "fast", "fast"]
    assert frame["fmu.gear"].tolist() == [1, 1, 2, 2, 2]
    assert frame["fmu.x[2]"].tolist() == pytest.approx([-1, -1, -1, -2, -3])
    for name in ("v", "n", "on", "name", "gear", "x[2]"):
        shown = frame[f"fmu.y_{name}"].tolist()
        assert shown[1:] == frame[f"fmu.{name}"].tolist()[:-1], name
    assert frame["fmu.y_x[1]"].eq(0).all()
    assert "nothing drives the inputs" not in " ".join(remarks)
    assert not [remark for remark in remarks if "table" in remark]


def test_values_hold_where_a_person_wants_it_or_the_input_is_discrete(fmu, tmp_path):
    path = table(tmp_path, "time,v\n0,1\n0.3,4\n")
    assert ran(fmu, input=path)[0]["fmu.v"].tolist() == pytest.approx([1, 2, 3, 4, 4])
    assert ran(fmu, input=path, input_hold=True)[0]["fmu.v"].tolist() == [1, 1, 1, 4, 4]
    variables = [
        '<Float64 name="v" valueReference="1" causality="input" variability="discrete" start="0"/>',
        '<Float64 name="y" valueReference="101" causality="output"/>',
    ]
    structure = ['<Output valueReference="101" dependencies=""/>', '<InitialUnknown valueReference="101"/>']
    discrete = pack(tmp_path / "b.fmu", Version.FMI3, description3(variables, structure), echo_library(Version.FMI3))
    assert ran(discrete, input=path)[0]["fmu.y"].tolist()[1:] == [1, 1, 1, 4]


def test_outside_of_the_table_its_ends_are_held_and_that_is_said(fmu, tmp_path):
    frame, remarks = ran(fmu, input=table(tmp_path, "time [ms];v\n100;1\n200;2\n"))
    assert frame["fmu.v"].tolist() == [1, 1, 2, 2, 2]
    told = "the input table goes from 0.1 s to 0.2 s: before, its first and after, its last values are held"
    assert remarks.count(told) == 1


def test_the_run_ends_with_the_table_where_nobody_says_more(fmu, tmp_path):
    loaded = load(str(fmu), Options(input=table(tmp_path, "time\tv\n0\t1\n0.75\t2\n")))
    assert loaded.until == pytest.approx(0.7)
    assert "the run ends with the input table, at 0.7 s; --stop-time changes it" in loaded.remarks


def test_it_is_as_fmpys_simulation_with_the_same_table(built_fmus, tmp_path):
    import fmpy  # noqa: PLC0415

    path = built_fmus / "fmi3" / "bicycle.fmu"
    time = np.linspace(0, 2, 9)
    delta = 0.05 * np.sin(3 * time)
    pd.DataFrame({"time": time, "actuation.delta_f": delta}).to_csv(tmp_path / "u.csv", index=False)
    loaded = load(str(path), Options(stop_time=2.0, input=str(tmp_path / "u.csv")))
    with Simulation(loaded.system, h=loaded.h, until=loaded.until) as simulation:
        simulation.run()
        frame = simulation.frame()
    given = np.array([*zip(time, delta, strict=True)], dtype=[("time", float), ("actuation.delta_f", float)])
    names = ["state.x", "state.y", "state.r"]
    theirs = fmpy.simulate_fmu(str(path), stop_time=2.0, output_interval=0.1, input=given, output=names)
    for name in names:
        np.testing.assert_allclose(frame[f"fmu.{name}"], theirs[name], rtol=0, atol=1e-9)


@pytest.mark.parametrize("hold", [False, True])
def test_a_run_is_repeated_from_its_folder_alone(fmu, tmp_path, hold):
    path = tmp_path / "inputs.csv"
    path.write_text("time,v [km/h],name\n0,1,a\n0.35,70,b\n")
    loaded = load(str(fmu), Options(stop_time=0.4, input=str(path), input_hold=hold, isolate=["fmu"]))
    execute(loaded, tmp_path / "r1", SILENT, Execution())
    path.unlink()
    again = load(str(tmp_path / "r1"))
    execute(again, tmp_path / "r2", SILENT, Execution())
    one, other = ((tmp_path / name / "signals.parquet").read_bytes() for name in ("r1", "r2"))
    assert one == other
    frame = pd.read_parquet(tmp_path / "r2" / "signals.parquet")
    assert frame["fmu.v"][3] == pytest.approx((1 if hold else 60.142857142857) / 3.6)
    path.write_text("time,v\n0,5\n")
    other = load(str(tmp_path / "r1"), Options(input=str(path)))
    assert [c.path for c in other.system.table.columns] == ["fmu.v"]


def test_the_rows_of_a_run_are_a_table(fmu, tmp_path):
    first = echo(tmp_path / "b.fmu", [("v", "Real", "3", {"unit": "m/s"}), ("w", "Real", "3")])
    path = table(tmp_path, "time,v\n0,1\n0.4,5\n")
    execute(load(str(first), Options(stop_time=0.4, input=path)), tmp_path / "r", SILENT, Execution())
    rows = tmp_path / "r" / "signals.parquet"
    frame, remarks = ran(fmu, input=str(rows))
    assert frame["fmu.v"].tolist() == pytest.approx([1, 2, 3, 4, 5])
    assert f"{rows}: 2 of its 3 columns are no inputs here" in remarks
    parts = component("car", "a.fmu", connectors("v:input:m/s"))
    theirs = write(tmp_path / "s.ssp", f"<ssd:Elements>{parts}</ssd:Elements>", {"resources/a.fmu": fmu})
    frame, remarks = ran(theirs, input=str(rows))
    assert frame["car.v"].tolist() == pytest.approx([1, 2, 3, 4, 5])
    assert f"{rows}: car.v follows `fmu.v`; 2 of its 3 columns are no inputs here" in remarks
    undriven = next(remark for remark in remarks if remark.startswith("inputs that nothing drives"))
    assert "car.n = 0" in undriven
    assert "car.v" not in undriven


def test_a_table_of_pandas_is_read_too(fmu, tmp_path):
    made = pd.DataFrame({"time": [0, 0.4], "v [km/h]": [0, 36], "gear": ["park", "drive"], "on": [False, True]})
    made.to_parquet(tmp_path / "u.parquet")
    frame, _ = ran(fmu, input=str(tmp_path / "u.parquet"))
    assert frame["fmu.v"].tolist() == pytest.approx([0, 2.5, 5, 7.5, 10])
    assert frame["fmu.gear"].tolist() == [1, 1, 1, 1, 2]
    assert frame["fmu.on"].tolist() == [False] * 4 + [True]


def test_a_written_input_leaves_the_table_until_it_is_released(fmu, tmp_path):
    loaded = load(str(fmu), Options(stop_time=0.6, input=table(tmp_path, "time,v,x[1]\n0,0,1\n1,10,1\n")))
    with Simulation(loaded.system, h=loaded.h, until=loaded.until) as simulation:
        for tick in simulation:
            if tick.tick == 1:
                simulation.write("fmu.v", -5.0)
            if tick.tick == 3:
                simulation.release("fmu.v")
        frame = simulation.frame()
    assert frame["fmu.v"].tolist() == pytest.approx([0, 1, -5, -5, 4, 5, 6])
    assert frame["fmu.y_v"].tolist() == pytest.approx([0, 0, -5, -5, 3, 4, 5])
    assert frame["fmu.x[1]"].eq(1).all()


def test_an_input_that_nobody_has_a_value_for_follows_the_table(tmp_path):
    variables = [
        '<Float64 name="v" valueReference="1" causality="input"><Dimension start="1"/></Float64>',
        '<Float64 name="w" valueReference="2" causality="input"><Dimension start="2"/></Float64>',
        '<Float64 name="y" valueReference="101" causality="output"/>',
    ]
    structure = ['<Output valueReference="101" dependencies=""/>', '<InitialUnknown valueReference="101"/>']
    path = pack(tmp_path / "a.fmu", Version.FMI3, description3(variables, structure), echo_library(Version.FMI3))
    frame, _ = ran(path, input=table(tmp_path, "time,v[1]\n0,1\n0.4,5\n"), lenient=True)
    assert frame["fmu.y"].tolist()[1:] == pytest.approx([1, 2, 3, 4])
    found = refusal(path, input=table(tmp_path, "time,w[1]\n0,1\n0.4,5\n"), lenient=True)
    assert found == "fmu.w: found no value of w[2]; valid: a column for each element of the array"


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (
            "time,vv\n0,1\n",
            ": vv: found a column that is no input; valid: fmu.gear, fmu.n, fmu.name, fmu.on, fmu.v,"
            " fmu.x[1], fmu.x[2]. Did you mean `v`?",
        ),
        ("time,x\n0,1\n", ": x: found an array; valid: a column for each element: x[1], x[2]"),
        ("time,v [kg]\n0,1\n", ": v: found the unit `kg`; valid: `m/s`, or another that measures the same"),
        ("time,n [m]\n0,1\n", ": n: found the unit `m`; valid: none: values of type Int32 have no unit of measurement"),
        ("time,v,fmu.v\n0,1,2\n", ": fmu.v: found fmu.v, which `v` drives; valid: one column for each input"),
        ("time,v\n0,1\n\n0.2,fast\n", ", line 4, `v`: found `fast`; valid: a number"),
        ("time,v\n0,1\n0.2,\n", ", line 3, `v`: found nothing; valid: a number"),
        ("time,v\n0,nan\n", ", line 2, `v`: found `nan`; valid: a number"),
        ("time,v\n0,inf\n", ", line 2, `v`: found inf; valid: -100 <= finite number [m/s]"),
        ("time,v [km/h]\n0,1\n1,-720\n", ", line 3, `v`: found -200.0; valid: -100 <= finite number [m/s]"),
        ("time,n\n0,1.5\n", ", line 2, `n`: found `1.5`; valid: whole number <= 9"),
        ("time,n\n0,12\n", ", line 2, `n`: found 12; valid: whole number <= 9"),
        ("time,on\n0,perhaps\n", ", line 2, `on`: found `perhaps`; valid: true or false"),
        (f"time,gear\n0,park\n1,{2**63}\n", f", line 3, `gear`: found {2**63}; valid: drive, park"),
        ("time,gear\n0,reverse\n", ", line 2, `gear`: found `reverse`; valid: drive, park"),
        (
            "time,v\n0,1\n0.2,2\n0.2,3\n",
            ", line 4, `time`: found 0.2 s after 0.2 s; valid: times that increase. Sort the rows.",
        ),
        ("time [km],v\n0,1\n", ": time: found the unit `km`; valid: a unit of time, such as `s`"),
        ("time,v\n0,1,2\n", ", line 2: found 3 values; valid: 2, one for each column"),
        (
            "v,time\n0,1\n",
            f": found the first column `v`; {VALID}",
        ),
        (
            "time,v\n",
            f": found no rows; {VALID}",
        ),
        ("time,v,v\n0,1,2\n", ": found two columns `v`; valid: a name of its own for each column"),
    ],
)
def test_what_is_wrong_with_a_table_is_told_with_its_place(fmu, tmp_path, text, expected):
    path = table(tmp_path, text)
    assert refusal(fmu, input=path) == path + expected


def test_all_that_is_wrong_with_a_table_is_told_at_once(fmu, tmp_path):
    path = table(tmp_path, "time,v [kg],w\n0,1,1\n0.2,2,3\n")
    found = refusal(fmu, input=path).splitlines()
    assert [line.partition(": found")[0] for line in found] == [f"{path}: w", f"{path}: v"]
    path = table(tmp_path, "time,v\n0,fast\n0.2,\n")
    assert refusal(fmu, input=path).splitlines() == [
        f"{path}, line 2, `v`: found `fast`; valid: a number",
        f"{path}, line 3, `v`: found nothing; valid: a number",
    ]
    path = table(tmp_path, "time,v\n0.2,1\n0.2,1\n0.1,1\n")
    told = "valid: times that increase. Sort the rows."
    assert refusal(fmu, input=path).splitlines() == [
        f"{path}, line 3, `time`: found 0.2 s after 0.2 s; {told}",
        f"{path}, line 4, `time`: found 0.1 s after 0.2 s; {told}",
    ]


def test_a_file_that_is_no_table_is_refused(fmu, tmp_path):
    missing = str(tmp_path / "none.csv")
    found = "found no such file"
    assert refusal(fmu, input=missing) == f"{missing}: {found}; {VALID}"
    (tmp_path / "a.txt").write_text("time")
    assert refusal(fmu, input=str(tmp_path / "a.txt")).endswith(f"found a file ending in `.txt`; {VALID}")
    (tmp_path / "a.parquet").write_text("time")
    told = refusal(fmu, input=str(tmp_path / "a.parquet"))
    assert told.startswith(f"{tmp_path / 'a.parquet'}: found a file that cannot be read (ArrowInvalid: ")
    assert told.endswith(f"; {VALID}")
    (tmp_path / "a.csv").write_bytes(b"time,v\n0,\xff\n")
    assert refusal(fmu, input=str(tmp_path / "a.csv")).endswith(f"found bytes that are no UTF-8 (at byte 9); {VALID}")


def test_what_a_unit_drives_does_not_follow_a_table(fmu, tmp_path):
    parts = component("a", "a.fmu", connectors("v:input", "y_v:output"))
    parts += component("b", "a.fmu", connectors("v:input", "y_v:output"))
    connections = f"<ssd:Connections>{wire('a.y_v', 'b.v')}</ssd:Connections>"
    theirs = write(tmp_path / "s.ssp", f"<ssd:Elements>{parts}</ssd:Elements>{connections}", {"resources/a.fmu": fmu})
    path = table(tmp_path, "time,b.v,v\n0,1,1\n")
    assert refusal(theirs, input=path).splitlines() == [
        f"{path}: b.v: found two sources of b.v, a.y_v and the table; valid: one source",
        f"{path}: v: found inputs of several units: a.v, b.v; valid: the name of one with its unit",
    ]
    frame, _ = ran(theirs, input=table(tmp_path, "time,a.v\n0,1\n0.4,5\n"))
    assert frame["b.y_v"].tolist()[2:] == pytest.approx([1, 2, 3])
