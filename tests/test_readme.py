"""What the READMEs promise: their commands are taken, their code runs, their files are read, their numbers are true."""

from __future__ import annotations

import importlib
import json
import re
import shlex
import tomllib
from pathlib import Path

import pandas as pd
import pytest
import typer

from components import SOCKETS
from orchestrator import SILENT, Execution, Options, execute, load, metrics, shown, simulate
from orchestrator.command import main
from orchestrator.mapping.mapping_reader import read_mapping

ROOT = Path(__file__).parents[1]
FRONT = (ROOT / "README.md").read_text(encoding="utf-8")
PAGES = {
    path: path.read_text(encoding="utf-8")
    for path in (ROOT / folder / "README.md" for folder in (".", "components", "fmus", "orchestrator"))
}
README = "\n".join(PAGES.values())
MOST_LINES = 250
COMMAND = typer.main.get_command(main.application(SOCKETS.values()))


def blocks(language: str = "") -> list[str]:
    """The contents of all code blocks in a language."""
    fenced = re.findall(r"^```(\w*)\n(.*?)^```$", README, re.DOTALL | re.MULTILINE)
    return [text for found, text in fenced if found == language]


def block(language: str, word: str) -> str:
    """The one code block in which a word stands."""
    (text,) = [t for t in blocks(language) if word in t]
    return text


def commands() -> list[str]:
    """All command lines: of code blocks, and in the text."""
    lines = [line.removeprefix("$ ").removeprefix("uv run ") for text in blocks() for line in text.splitlines()]
    prose = re.sub(r"^```.*?^```$", "", README, flags=re.DOTALL | re.MULTILINE)
    inline = re.findall(r"`(macrostep [a-z]+ [^`]*)`", prose)
    return [line.partition("  #")[0].rstrip() for line in [*lines, *inline] if line.startswith("macrostep ")]


def table(heading: str) -> list[list[str]]:
    """The rows of the first table whose first column has this heading."""
    rows = re.search(rf"^\| {heading} \|.*\n\|[-|]+\n((?:\|.*\n)+)", README, re.MULTILINE)[1]
    return [[cell.strip() for cell in row.strip("|").split("|")] for row in rows.splitlines()]


def anchors(text: str) -> set[str]:
    """What links to the headings of a page end in."""
    titles = re.findall(r"^#+ (.+)$", text, re.MULTILINE)
    return {re.sub(r"[^\w -]", "", title.lower()).replace(" ", "-") for title in titles}


def test_the_front_page_is_a_way_in():
    assert len(FRONT.splitlines()) <= MOST_LINES
    assert len(PAGES) == 4
    for path in PAGES:
        name = path.relative_to(ROOT).as_posix()
        assert name == "README.md" or f"]({name}" in FRONT, name


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_every_link_leads_somewhere(path):
    links = [link for link in re.findall(r"\]\(([^)]+)\)", PAGES[path]) if not link.startswith("https://")]
    for link in links:
        target, _, anchor = link.partition("#")
        there = path.parent / target if target else path
        assert there.exists(), link
        assert not anchor or anchor in anchors(there.read_text(encoding="utf-8")), link


@pytest.mark.parametrize("line", commands())
def test_every_command_line_is_one_that_the_command_takes(line):
    _, name, *arguments = shlex.split(line)
    COMMAND.commands[name].make_context(name, arguments)


def test_every_option_that_is_named_is_one_of_a_command():
    known = {o for c in (COMMAND, *COMMAND.commands.values()) for p in c.params for o in (*p.opts, *p.secondary_opts)}
    prose = re.sub(r"^```.*?^```$", "", README, flags=re.DOTALL | re.MULTILINE)
    named = {option for text in re.findall(r"`([^`]+)`", prose) for option in re.findall(r"(?<!\S)--[a-z-]+", text)}
    assert "--isolate" in named
    assert named - known == {"--benchmark-only"}  # of pytest


def test_every_command_is_shown():
    shown = {shlex.split(line)[1] for line in commands()}
    assert shown == set(COMMAND.commands)


def test_the_help_of_every_option_says_something():
    for name, command in COMMAND.commands.items():
        for parameter in command.params:
            if parameter.param_type_name == "option":
                assert parameter.help, (name, parameter.name)


def test_the_mapping_file_is_read(tmp_path):
    path = tmp_path / "theirs.plant.toml"
    path.write_text(block("toml", "speed_and_slip"), encoding="utf-8")
    found = read_mapping(path)
    assert (found.socket, found.axes, found.fmu) == ("plant", "y_right", tmp_path / "theirs.fmu")
    assert found.velocities == {"state": "speed_and_slip"}
    assert {"state.x", "state.v_x", "state.v_y", "actuation.delta_f", "actuation.T_r"} <= found.signals.keys()


def test_the_small_mapping_file_of_the_front_page_is_read(tmp_path):
    (text,) = re.findall(r"^```toml\n(.*?)^```$", FRONT, re.DOTALL | re.MULTILINE)
    (tmp_path / "theirs.plant.toml").write_text(text, encoding="utf-8")
    found = read_mapping(tmp_path / "theirs.plant.toml")
    assert (found.socket, found.axes) == ("plant", "y_right")
    assert found.signals.keys() == {"state.x", "state.v_x", "actuation.delta_f"}


def test_what_a_scenario_records_is_said_so(tmp_path):
    path = tmp_path / "mine.toml"
    text = block("toml", "[record]")
    path.write_text((ROOT / "orchestrator/scenarios/static.toml").read_text() + text, encoding="utf-8")
    assert load(str(path), Options(mode="blocks")).record == tomllib.loads(text)["record"]


@pytest.fixture(scope="module")
def static_1(tmp_path_factory):
    """A run folder, runs/static-1."""
    folder = tmp_path_factory.mktemp("readme") / "runs" / "static-1"
    execute(load("static", Options(mode="blocks")), folder, SILENT, Execution())
    return folder


def test_a_run_is_queried_with_pandas_and_with_reruns_own_reader(static_1, monkeypatch, capsys):
    monkeypatch.chdir(static_1.parents[1])
    exec(block("python", "RrdReader"), {})  # noqa: S102 - the README's own code
    said = capsys.readouterr().out
    frame = pd.read_parquet("runs/static-1/signals.parquet")
    rows = frame.index[frame["plant.tyre.mu_r"] > 0.8]
    assert [int(line.split()[0]) for line in said.splitlines()[1 : len(rows) + 1]] == rows.tolist()
    numbers = [float(n) for n in re.findall(r"^ *(-?\d[\d.]*),?$", said, re.MULTILINE)]
    assert {0.0, 113.0, frame["plant.state.v_x"].iloc[-1]} <= set(numbers)  # ticks and values


def test_a_system_is_stepped_from_python():
    found = {}
    exec(block("python", "simulation.release"), found)  # noqa: S102 - the README's own code
    frame = found["frame"]
    assert (frame["plant.actuation.delta_f"][31:36] == 0.05).all()
    assert frame["plant.actuation.delta_f"][36] == frame["controller.actuation.delta_f"][36]
    assert frame["plant.state.x"].iloc[-1] > 80 >= frame["plant.state.x"].iloc[-2]


def test_a_simulation_goes_back_and_forth_from_python(in_tmp_path, capsys):
    found: dict[str, object] = {}
    exec(block("python", "simulation.release"), found)  # noqa: S102 - the README's own code
    exec(block("python", "simulation.restore"), found)  # noqa: S102 - the README's own code
    futures = [float(line.split()[1]) for line in capsys.readouterr().out.splitlines()]
    assert len(futures) == 3
    assert futures == sorted(futures)
    other = found["other"].columns()
    assert (other["time"][0], other["time"][-1]) == (4.2, 113 * 0.1)


def test_rows_of_a_run_are_read_with_pandas(static_1, monkeypatch, capsys):
    monkeypatch.chdir(static_1.parents[1])
    (text,) = [t for t in blocks("python") if "read_parquet" in t and "RrdReader" not in t]
    exec(text, {})  # noqa: S102 - the README's own code
    assert "plant.tyre.mu_r" in capsys.readouterr().out


def test_a_system_of_one_s_own_is_run(monkeypatch, built_fmus):
    monkeypatch.chdir(ROOT)
    assert built_fmus == ROOT / "fmus" / "built"
    found = {}
    exec(block("python", "fmus/built/fmi3/bicycle.fmu"), found)  # noqa: S102 - the README's own code
    assert found["frame"]["plant.state.x"].iloc[-1] == pytest.approx(20.0, rel=0.01)


def test_a_block_of_one_s_own_is_run_with_numbers(tmp_path, monkeypatch):
    declaration, use = (block("python", word) for word in ("class MyVehicle(Continuous", "MyVehicle(m=2000.0"))
    (tmp_path / "block_of_the_readme.py").write_text(f"{declaration}\n\n{use}", encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    frame = importlib.import_module("block_of_the_readme").frame
    assert frame["plant.state.x"].iloc[-1] == pytest.approx(10.0)


def test_a_wrong_request_is_answered_as_it_says(macrostep):
    line, *said = block("", "$ macrostep").splitlines()
    code, out, err = macrostep(*shlex.split(line)[2:])
    assert (code, out) == (2, "")
    for text in said:
        beginning, _, end = text.partition("...")
        assert any(e.startswith(beginning) and e.endswith(end) for e in err.splitlines()), text
    assert len(err.splitlines()) == len(said)


def test_a_run_folder_holds_what_the_table_says(static_1):
    found = {f"{path.name}/" if path.is_dir() else path.name for path in static_1.iterdir()}
    while_it_runs = {"rows/"}
    assert found - {".lock"} == {row[0].strip("`") for row in table("file")} - while_it_runs
    told = json.loads((static_1 / "summary.json").read_text())
    assert {"metrics", "verdicts", "schedule", "parameters", "versions"} <= told.keys()


def measured(scenario: str, controller: str, plant: str = "bicycle", **options) -> dict[str, float]:
    made = load(scenario, Options(mode="blocks", replacements={"controller": controller, "plant": plant}))
    frame = simulate(made.system, h=made.h, until=made.until, **options)
    return metrics.compute(frame, shown(made.system), made.scene)


def assert_shown(text: str, value: float) -> None:
    """A number of the README is this one, to its last digit."""
    assert float(text) == pytest.approx(value, abs=0.51 * 10 ** -len(text.partition(".")[2]))


RUNS = {
    "`mpc`, tuned (`static`)": ("static", "mpc"),
    "`mpc`, literal (`static-literal`)": ("static-literal", "mpc"),
    **{f"`{name}`": ("static", name) for name in ("mpc_plus", "lqr", "stanley", "pure_pursuit")},
}
METRICS = (
    "path_error_rms", "path_error_max", "r_total_variation", "r_dot_rms", "mu_f_max", "mu_r_max", "gap_edge"
)  # fmt: skip


@pytest.mark.parametrize("row", table("controller"), ids=lambda r: r[0])
def test_the_metrics_of_the_table_are_those_of_the_runs(row):
    found = measured(*RUNS[row[0]])
    shown = [number for cell in row[1:] for number in cell.split(" / ")]
    for metric, number in zip(METRICS, shown, strict=True):
        assert_shown(number, found[metric])


def test_the_numbers_around_the_table_are_those_of_the_runs():
    (gap,) = re.findall(r"`static` passes at ([\d.]+) m", README)
    assert_shown(gap, measured("static", "mpc")["gap_obstacle"])
    (outside,) = re.findall(r"leaves the road by ([\d.]+) m", README)
    assert_shown(outside, -measured("static", "mpc", "bicycle_saturated")["gap_edge"])
    late, direct = measured("static", "mpc", algorithm="jacobi"), measured("static", "mpc")
    ((r_late, r_direct),) = re.findall(r"yaw rate up to ([\d.]+) instead of ([\d.]+) rad/s", README)
    ((mu_late, mu_direct),) = re.findall(r"rear tyres asked for ([\d.]+) instead of ([\d.]+) of the friction", README)
    assert_shown(r_late, late["r_peak"])
    assert_shown(r_direct, direct["r_peak"])
    assert_shown(mu_late, late["mu_r_max"])
    assert_shown(mu_direct, direct["mu_r_max"])
