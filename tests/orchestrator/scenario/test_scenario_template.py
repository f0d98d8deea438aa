"""Beginning a scenario (`scenario_template.py`, `scenario_command.py`), and its form (`scenario_schema.py`)."""

from __future__ import annotations

import re
import tomllib

import jsonschema
import pytest

from components import BLOCKS
from components.interfaces.problem import RequestError
from orchestrator import Options, load, simulate
from orchestrator.scenario.parameters import PARAMETERS, parameter_set
from orchestrator.scenario.scenario_file import SCENARIOS, names, read
from orchestrator.scenario.scenario_schema import scenario_schema
from orchestrator.scenario.scenario_template import scenario_template

BLOCKS_HERE = Options(mode="blocks")


@pytest.mark.parametrize("name", names())
def test_every_scenario_of_ours_fits_the_schema_and_its_template_says_the_same(name, tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(scenario_template(name, path), "utf-8")
    for file in (SCENARIOS / f"{name}.toml", path):
        jsonschema.Draft202012Validator(scenario_schema()).validate(tomllib.loads(file.read_text("utf-8")))
    (_, ours), (_, mine) = read(name), read(str(path))
    assert mine.title == ours.title
    assert {s: (f.block, f.use) for s, f in mine.units.items()} == {s: (f.block, f.use) for s, f in ours.units.items()}
    for socket, filling in ours.units.items():
        assert {n: g.value for n, g in mine.units[socket].parameters.items()} == {
            n: g.value for n, g in filling.parameters.items()
        }


def test_a_template_runs_as_the_scenario_does_and_what_is_commented_out_is_what_it_has(tmp_path):
    path = tmp_path / "mine.toml"
    text = scenario_template("static", path)
    path.write_text(text, "utf-8")
    static = simulate(load("static", BLOCKS_HERE).system, h=0.1, until=2.0)
    assert simulate(load(str(path), BLOCKS_HERE).system, h=0.1, until=2.0).equals(static)
    opened = re.sub(r"(?m)^# (?!step|fmu|Run|A value|has|macrostep)", "", text)  # every value uncommented
    path.write_text(opened, "utf-8")
    whole = load(str(path), BLOCKS_HERE)
    assert simulate(whole.system, h=0.1, until=2.0).equals(static)
    assert whole.sources["plant.m"]["source"] == str(path)
    assert len(tomllib.loads(opened)["plant"]["parameters"]) == len(BLOCKS["bicycle"].parameters())


def test_source_and_description_may_be_left_out(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(
        'title = "Mine"\n[experiment]\nstep = { value = 0.1, unit = "s" }\nstop_time = { value = 1, unit = "s" }\n'
        '[plant]\nblock = "bicycle"\nparameters = { m = { value = 1800.0, unit = "kg" } }\n'
        '[traffic]\nblock = "empty_road"\n[controller]\nblock = "coast"\n'
    )
    made = load(str(path), BLOCKS_HERE)
    assert made.sources["plant.m"] == {"value": 1800.0, "unit": "kg", "source": str(path)}
    assert made.sources["experiment.step"]["source"] == str(path)


def test_every_value_of_ours_has_a_source():
    for name in PARAMETERS:
        assert all(given.source for given in parameter_set(name).values()), name
    for name in names():
        for table in (tables := tomllib.loads((SCENARIOS / f"{name}.toml").read_text("utf-8"))).values():
            values = table.get("parameters", {}) if isinstance(table, dict) else {}
            assert all(given["source"] for given in values.values()), name
        assert all(given["source"] for given in tables["experiment"].values() if isinstance(given, dict))


@pytest.mark.parametrize(
    ("change", "wrong"),
    [
        (lambda c: c["plant"].update(block="bycicle"), "'bycicle' is not one of"),
        (lambda c: c["experiment"].update(stop=3), "Additional properties are not allowed ('stop' was unexpected)"),
        (lambda c: c["controller"].update(parameters={"b_3": 1}), "1 is not of type 'object'"),
        (lambda c: c.pop("experiment"), "'experiment' is a required property"),
    ],
)
def test_the_schema_finds_what_is_wrong(change, wrong):
    content = tomllib.loads((SCENARIOS / "static.toml").read_text("utf-8"))
    change(content)
    found = [error.message for error in jsonschema.Draft202012Validator(scenario_schema()).iter_errors(content)]
    assert any(wrong in message for message in found), found


def test_the_schema_tells_what_a_parameter_is():
    filling = scenario_schema()["$defs"]["plant.filling"]["properties"]
    assert filling["block"]["enum"] == [block.name for block in BLOCKS.values() if block.socket.name == "plant"]
    assert "mass; 1 <= finite number [kg] (bicycle, " in filling["parameters"]["properties"]["m"]["description"]


def test_the_commands(macrostep, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    code, out, err = macrostep("scenario", "new", "mine.toml", "--from", "idle")
    assert (code, out, err) == (0, "", "written: mine.toml\n")
    assert macrostep("run", "mine.toml", "--blocks", "--stop-time", "0.2", "--out", "r")[0] == 0
    code, _, err = macrostep("scenario", "new", "mine.toml")
    assert code == 2
    assert err.startswith("macrostep: mine.toml: found a file; valid: a new file")
    code, _, err = macrostep("scenario", "new", "mine.txt")
    assert err.startswith("macrostep: mine.txt: found a name of another form; valid: FILE.toml")
    code, _, err = macrostep("scenario", "new", "x.toml", "--from", "statc")
    assert code == 2
    assert "Did you mean `static`?" in err
    code, out, _ = macrostep("scenario", "--schema")
    assert code == 0
    assert '"$schema": "https://json-schema.org/draft/2020-12/schema"' in out
    assert "new" in macrostep("scenario")[1]


def test_files_of_the_base_are_named_from_the_new_place(tmp_path):
    (tmp_path / "a").mkdir()
    base = tmp_path / "a" / "base.toml"
    text = (SCENARIOS / "idle.toml").read_text("utf-8").replace('block = "stationary"', 'fmu = "car.fmu"')
    base.write_text(text, "utf-8")
    assert 'fmu = "a/car.fmu"' in scenario_template(str(base), tmp_path / "mine.toml")


def test_an_unknown_base_is_refused(tmp_path):
    with pytest.raises(RequestError, match="no such scenario"):
        scenario_template("nothing", tmp_path / "x.toml")
