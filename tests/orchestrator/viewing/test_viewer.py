"""Runs in the real viewer: what its pictures hold, view by view, and what is said when it cannot open.

The pictures are taken by `photograph.py` and `recording/viewer_client.py`; `rerun_program.py` starts the viewer.
"""

from __future__ import annotations

import io
import re
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from PIL import Image

from components.interfaces.problem import RequestError
from orchestrator.pictures import palette
from orchestrator.pictures.drawing import error_colours
from orchestrator.recording import viewer_client
from orchestrator.recording.series_reader import read_series
from orchestrator.recording.stream import RerunStream
from orchestrator.results import run_folder as kept
from orchestrator.viewing import photograph as photograph_module
from orchestrator.viewing import viewer
from orchestrator.viewing.photograph import headless_viewer, photograph
from orchestrator.viewing.rerun_program import answers, executable
from tests.left_behind import left_in
from tests.orchestrator.chromium import PROGRAM, Chromium
from tests.waiting import wait_until

SCREEN = {
    "bird's eye": (0.0, 0.414, 0.09, 0.36),
    "following": (0.42, 0.58, 0.09, 0.36),
    "friction": (0.585, 0.748, 0.09, 0.36),
    "did": (0.0, 0.186, 0.42, 0.96),
    "felt": (0.189, 0.373, 0.42, 0.96),
    "the first seconds of felt": (0.2, 0.235, 0.84, 0.95),
    "hard": (0.377, 0.56, 0.42, 0.96),
    "the first seconds of hard": (0.39, 0.42, 0.42, 0.77),
    "fast": (0.564, 0.748, 0.42, 0.96),
    "modes": (0.752, 1.0, 0.13, 0.34),
    "events": (0.752, 1.0, 0.66, 0.96),
    "the last seconds of did": (0.15, 0.186, 0.86, 0.96),  # of a run that records its plant alone: y has all the room
}
"""Left, right, top and bottom of each view, in shares of the window"""


def _count(picture, view, colour, tolerance=12):
    """Pixels of a colour in a view."""
    left, right, top, bottom = SCREEN[view]
    height, width, _ = picture.shape
    part = picture[int(top * height) : int(bottom * height), int(left * width) : int(right * width)]
    return int((np.abs(part - colour).max(axis=-1) < tolerance).sum())


def _missing(picture, wanted, least=20):
    """Which of the colours that each view must contain are not there."""
    return [
        (view, colour)
        for view, colours in wanted.items()
        for colour in colours
        if _count(picture, view, colour) < least
    ]


@pytest.fixture(scope="module")
def static(kept_run, tmp_path_factory):
    return kept_run(tmp_path_factory.mktemp("runs") / "static-1")


def _pictures(requests, times, scratch):
    scratch.mkdir(exist_ok=True)
    recording = viewer.recording(viewer._found(requests, []), [], scratch, lambda _: None)
    found = photograph(recording, times)
    return [np.asarray(Image.open(io.BytesIO(content)).convert("RGB")).astype(int) for content in found]


ANSWERS = {
    "did": palette.SERIES[:2],
    "felt": (palette.SERIES[5], *palette.SERIES[:2]),
    "hard": (palette.SERIES[4], palette.SERIES[5], palette.SERIES[0], palette.LIMIT),
    "fast": (palette.SERIES[3],),
    "modes": [
        tuple(round(0.784 * channel) for channel in palette.STATES[name])  # the viewer lets the ground show through
        for name in ("converged", "own lane", "changing out", "adjacent lane", "changing back")
    ],
}


@pytest.mark.viewer
@pytest.mark.slow
def test_every_view_of_static_shows_what_it_must(static, graphics, tmp_path):
    early, late = _pictures([static], [2.6, 7.0], tmp_path)
    world = (palette.EGO, palette.PATH, palette.OBSTACLE, palette.BOUNDARY, palette.CORRIDOR, palette.EDGE)
    wanted = {"bird's eye": world, "following": (palette.EGO, palette.PATH, palette.ROAD), **ANSWERS}
    wanted["friction"] = (palette.LIMIT, palette.SERIES[0])
    wanted["the first seconds of felt"] = palette.SERIES[1:2]  # no legend hides them
    wanted["the first seconds of hard"] = palette.SERIES[4:]
    assert _missing(early, wanted) == []
    assert _missing(late, {**wanted, "bird's eye": world[:3]}) == []
    assert _count(early, "events", (255, 255, 255), 120) > 500
    assert _count(early, "bird's eye", palette.GROUND, 3) > 5000
    moved = np.abs(early - late).max(axis=-1) > 30
    assert moved[: moved.shape[0] // 3].sum() > 5000, "the world moves on"


@pytest.mark.viewer
@pytest.mark.slow
def test_views_of_what_is_not_recorded_leave_their_room_to_the_others(static, graphics, tmp_path):
    run = kept.find(static)
    frame = pd.read_parquet(static / "signals.parquet")
    rows = {name: frame[name].to_numpy() for name in frame if name == "time" or name.startswith("plant.")}
    scenario, path = run.scenario, tmp_path / "plant.rrd"
    stream = RerunStream(
        path, scenario.system, scenario.scene, name="plant", grid=scenario.grid, about={}, recorded=[list(rows)]
    )
    stream.log(rows, None)
    stream.close()
    (content,) = photograph(path, [4.0])
    picture = np.asarray(Image.open(io.BytesIO(content)).convert("RGB")).astype(int)
    wanted = {"bird's eye": (palette.EGO, palette.EDGE), "following": (palette.EGO,), "friction": (palette.LIMIT,)}
    answers = {name: ANSWERS[name] for name in ("felt", "fast")}
    answers["hard"] = (palette.LIMIT, *palette.SERIES[4:])
    answers["the last seconds of did"] = palette.SERIES[1:2]
    assert _missing(picture, wanted | answers) == []
    assert _count(picture, "bird's eye", palette.PATH) == _count(picture, "following", palette.CORRIDOR) == 0


@pytest.mark.viewer
@pytest.mark.slow
def test_a_run_without_rows_has_a_picture_at_any_time(static, graphics, tmp_path):
    scenario, path = kept.find(static).scenario, tmp_path / "empty.rrd"
    RerunStream(
        path, scenario.system, None, name="empty", grid=scenario.grid, about={"status": "running"}, recorded=[]
    ).close()
    (content,) = photograph(path, [1.0])
    picture = np.asarray(Image.open(io.BytesIO(content)).convert("RGB"))
    assert (picture.min(axis=-1) > 150).sum() > 1000, "the page about the run"


@pytest.mark.viewer
@pytest.mark.slow
def test_moving_obstacles_and_the_trails_colours_show(kept_run, graphics, tmp_path):
    run = kept_run(tmp_path / "dynamic-1", "dynamic")
    (picture,) = _pictures([run], [4.0], tmp_path / "scratch")
    wanted = {"bird's eye": (palette.EGO, palette.OBSTACLE, palette.BOUNDARY), "following": (palette.OBSTACLE,)}
    assert _missing(picture, {**wanted, **ANSWERS}) == []
    reddish = picture[..., 0] - picture[..., 2] > 100
    left, right, top, bottom = SCREEN["bird's eye"]
    height, width = reddish.shape
    assert reddish[int(top * height) : int(bottom * height), int(left * width) : int(right * width)].any()
    (_, errors) = read_series(run / "recording.rrd")["/derived/path_error"]
    trail = np.unique(error_colours(errors[10:38, 0]), axis=0)  # of the seconds before, which are in the window
    assert sum(_count(picture, "bird's eye", colour, 6) for colour in trail) > 15


@pytest.mark.viewer
@pytest.mark.slow
def test_a_comparison_shows_each_run_in_its_colour(static, kept_run, graphics, tmp_path):
    other = kept_run(tmp_path / "slower", settings=("controller.v_ref=8",))
    (picture,) = _pictures([static, other], [3.2], tmp_path / "scratch")
    both = palette.RUNS[:2]
    wanted = dict.fromkeys(("bird's eye", "following", "friction", "did", "felt", "hard", "fast"), both)
    assert _missing(picture, wanted) == []
    assert _missing(picture, {"modes": ANSWERS["modes"]}) == []


@pytest.mark.viewer
@pytest.mark.slow
@pytest.mark.skipif(PROGRAM is None, reason="no Chromium: apt-get install chromium")
def test_the_web_viewer_shows_the_same_in_the_light_theme(static, tmp_path):
    command = [executable(), *viewer.arguments(static / "recording.rrd", web=True)]
    with subprocess.Popen(command, stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        try:
            said = iter(process.stderr.readline, "")
            url = next(
                found[0] for line in said if (found := re.search(r"http://127\.0\.0\.1:\d+\?url=[\w%.-]+", line))
            )
            with Chromium(tmp_path / "profile") as browser:
                browser.open(f"{url}&theme=light&renderer=webgl")
                wanted = {view: colours for view, colours in ANSWERS.items() if view != "modes"}
                wanted |= {"bird's eye": (palette.EGO, palette.PATH, palette.EDGE), "friction": (palette.LIMIT,)}
                picture = browser.picture(until=lambda found: not _missing(found, wanted), seconds=600)
        finally:
            process.terminate()
    assert _missing(picture, wanted) == []
    assert _missing(picture, {"did": ((255, 255, 255),)}) == [], "the ground is not light"
    assert _count(picture, "bird's eye", palette.GROUND, 3) > 5000, "the world looks as it does in the dark"


def _listening(pid):
    """Local addresses (hexadecimal) that a process listens at."""
    sockets = {str(link.readlink()) for link in Path(f"/proc/{pid}/fd").iterdir() if link.is_symlink()}
    lines = [
        line.split() for name in ("tcp", "tcp6") for line in Path(f"/proc/{pid}/net/{name}").read_text().split("\n")
    ]
    return [words[1] for words in lines if len(words) > 9 and words[3] == "0A" and f"socket:[{words[9]}]" in sockets]


@pytest.mark.viewer
@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
@pytest.mark.parametrize("web", [False, True])
def test_the_viewer_listens_on_this_machine_only(static, graphics, web):
    options = viewer.arguments(static / "recording.rrd", web=web)
    command = [executable(), *([] if web else ["--headless"]), *options]
    with subprocess.Popen(command, stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL) as process:
        try:
            found = wait_until(lambda: _listening(process.pid))
        finally:
            process.terminate()
    assert all(address.startswith("0100007F:") for address in found)


def test_a_headless_viewer_ends_with_its_block_and_leaves_no_files(monkeypatch, tmp_path):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    with headless_viewer() as (url, _):
        assert url.startswith("rerun+http://127.0.0.1:")
        wait_until(lambda: answers(url))
        assert left_in(tmp_path)
    assert left_in(tmp_path) == []


@pytest.mark.viewer
@pytest.mark.slow
def test_a_recording_without_anything_to_show_is_refused(graphics, monkeypatch, tmp_path):
    monkeypatch.setattr(viewer_client, "_ANSWERS_WITHIN", 5.0)
    monkeypatch.setattr(viewer_client, "_EMPTY_AFTER", 30)
    path = tmp_path / "a.rrd"
    path.write_bytes(b"RRF2")
    with pytest.raises(RequestError) as raised:
        photograph(path, [None])
    assert str(raised.value) == (
        "a.rrd: found nothing that the viewer can show; valid: a recording of a run. Run it again."
    )


@pytest.mark.viewer
def test_show_in_the_browser_says_one_thing_the_page(static):
    command = [sys.executable, "-m", "orchestrator.command.main", "show", "--web", str(static)]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
        first = process.stderr.readline()
        process.send_signal(signal.SIGINT)
        rest = process.stderr.read()
    assert re.fullmatch(r"in the browser at http://127\.0\.0\.1:\d+\?url=\S+, until Ctrl-C\n", first)
    assert (rest, process.returncode) == ("", 0)


@pytest.mark.viewer
@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere there is no way")
def test_a_page_in_the_browser_ends_with_a_command_that_is_killed(static, monkeypatch, tmp_path):
    monkeypatch.setenv("TMPDIR", str(tmp_path))  # who is killed leaves files behind
    command = [sys.executable, "-m", "orchestrator.command.main", "show", "--web", str(static)]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
        page = re.search(r"http://127\.0\.0\.1:\d+", process.stderr.readline())[0]
        assert answers(page)
        process.kill()
    wait_until(lambda: not answers(page))


@pytest.fixture
def refused(monkeypatch):
    """The text of the refusal of a request."""
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)

    def told(*requests, differences=(), **options):
        with pytest.raises(RequestError) as raised:
            viewer.show(list(requests), list(differences), lambda _: None, **options)
        return [str(problem) for problem in raised.value.problems]

    return told


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere there is always a display")
def test_without_a_display_there_is_a_way_out(static, refused):
    assert refused(static) == [
        "Rerun viewer: found no display; valid: a machine with a display. "
        "In a browser: macrostep show --web RUN. As a file: macrostep show --picture FILE.png RUN"
    ]


def test_all_that_is_wrong_with_several_runs_is_told_at_once(static, refused, tmp_path):
    alone = tmp_path / "alone.rrd"
    alone.write_bytes((static / "recording.rrd").read_bytes())
    nowhere = tmp_path / "nowhere"
    assert refused(static, static, alone, nowhere) == [
        f"{nowhere}: found no such file or folder; valid: a run folder, or an .rrd file. "
        "Make a run: macrostep run static",
        "show: found the same run twice; valid: different runs",
        f"{alone}: found a recording on its own; valid: run folders to compare. "
        "Their system.ssp says what was recorded.",
    ]


def test_options_that_do_not_fit_are_refused(static, refused, tmp_path):
    assert refused(static, differences=["plant.state.y"]) == [
        "--difference: found a single run; valid: two runs or more. macrostep show RUN OTHER"
    ]
    assert refused(static, times=[1.0]) == [
        "--at: found no picture to be taken; valid: --at together with --picture FILE.png"
    ]
    assert refused(static, picture=tmp_path / "a.png", times=[1.0, float("nan"), float("inf")]) == [
        "--at: found nan; valid: a finite number of seconds",
        "--at: found inf; valid: a finite number of seconds",
    ]
    wrong = tmp_path / "picture.jpg"
    assert refused(static, picture=wrong) == [
        f"--picture {wrong}: found `picture.jpg`; valid: a file .png in a folder that exists"
    ]
    wrong = tmp_path / "nowhere" / "a.png"
    assert refused(static, picture=wrong) == [
        f"--picture {wrong}: found no folder `{wrong.parent}`; valid: a file .png in a folder that exists"
    ]


def test_a_picture_that_cannot_be_written_is_told(static, refused, tmp_path, monkeypatch):
    monkeypatch.setattr("orchestrator.viewing.photograph.photograph", lambda *_, **__: [b"a picture"])
    (tmp_path / "a.png").mkdir()
    assert refused(static, picture=tmp_path / "a.png") == [
        f"--picture {tmp_path / 'a.png'}: found a file that cannot be written (Is a directory); "
        "valid: a file .png in a folder that exists. Choose another place."
    ]


def test_a_viewer_that_fails_says_why(static, monkeypatch, tmp_path):
    fake = tmp_path / "viewer"
    fake.write_text("#!/bin/sh\necho 'Error: no graphics adapter was found' >&2\nexit 1\n")
    fake.chmod(0o755)
    monkeypatch.setattr(viewer, "executable", lambda: str(fake))
    with pytest.raises(RequestError) as raised:
        viewer.open_viewer(static / "recording.rrd", [].append, web=False)
    assert str(raised.value).startswith(
        "Rerun viewer: found exit code 1 (no graphics adapter was found); "
        "valid: a machine with a display and a graphics driver."
    )


@pytest.mark.viewer
def test_a_picture_has_the_size_and_the_tab_that_are_asked_for(static, graphics, tmp_path):
    sizes = {}
    for tab in ("run", "about"):
        (file,) = photograph_module.write_pictures(
            static / "recording.rrd", tmp_path / f"{tab}.png", [3.0], photograph_module.Look("1280x800", tab)
        )
        with Image.open(file) as picture:
            sizes[tab] = picture.size
    assert sizes == {"run": (1280, 800), "about": (1280, 800)}
    assert (tmp_path / "run.png").read_bytes() != (tmp_path / "about.png").read_bytes()
    with pytest.raises(RequestError, match="found no tab `zzz`, but Run, All signals, About this run"):
        photograph(static / "recording.rrd", [3.0], look=photograph_module.Look(tab="zzz"))


@pytest.mark.viewer
def test_a_time_at_which_nothing_was_recorded_has_no_picture(static, graphics):
    with pytest.raises(RequestError) as raised:
        photograph(static / "recording.rrd", [1.0, 99.0, -2.0])
    last = kept.find(static).scenario.until
    told = f"s, when nothing was recorded; valid: 0 to {last:g} s. The last row is at {last:g} s."
    assert str(raised.value).splitlines() == [f"--at: found 99 {told}", f"--at: found -2 {told}"]


@pytest.mark.parametrize("size", ["5x5", "1280", "1280x", "axb", "12800x900"])
def test_a_size_of_another_form_is_refused(size):
    with pytest.raises(RequestError, match=f"--size {size}: found text of another form; valid: WIDTHxHEIGHT"):
        photograph_module.Look(size)


def test_size_and_tab_need_a_picture(macrostep):
    code, _, err = macrostep("show", "r", "--tab", "about")
    assert code == 2
    assert "r: found" in err or "--size, --tab: found no picture to be taken" in err
