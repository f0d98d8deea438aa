"""Watching a run: who is started, what listens where, and what is said; the stream itself arrives."""

from __future__ import annotations

import re
import signal
import socket
import subprocess
import time
import urllib.request
from collections import defaultdict
from contextlib import contextmanager, nullcontext, suppress
from pathlib import Path

import pytest
from rerun.chunk import RrdReader

from components.interfaces.problem import RequestError
from components.interfaces.progress import SILENT
from orchestrator.recording.recording import Afterwards
from orchestrator.run import Execution, execute
from orchestrator.scenario.options import Options
from orchestrator.scenario.prepare import prepare
from orchestrator.stepping.pacing import Pacer
from orchestrator.viewing import live, rerun_program
from orchestrator.viewing.live import LiveOptions, LiveStream, live_options

# a stream that was saved has no footer, and Rerun says so
pytestmark = pytest.mark.filterwarnings("ignore:RRD file has no footer")

PROC = pytest.mark.skipif(not Path("/proc/net/tcp").exists(), reason="looks for listeners in /proc")


def wrong(**options):
    with pytest.raises(RequestError) as error:
        live_options(**{"live": True, "viewer": True, "web": False, "url": None, **options})
    return str(error.value).splitlines()


def test_options_that_need_live_or_exclude_each_other_are_told():
    assert live_options(live=False, viewer=True, web=False, url=None) is None
    assert live_options(live=True, viewer=False, web=False, url=None) == LiveOptions(viewer=False)
    assert wrong(live=False, viewer=False, web=True, url="x") == [
        "--no-viewer: found no --live; valid: with --live only",
        "--web: found no --live; valid: with --live only",
        "--connect: found no --live; valid: with --live only",
    ]
    assert wrong(web=True, url="x") == ["--connect: found --web or --no-viewer too; valid: one of them"]
    for port in (1, 65535):
        live_options(live=True, viewer=True, web=False, url=f"rerun+http://[::1]:{port}/proxy")
    for address in ("rerun+http://127.0.0.1:0/proxy", "rerun+http://127.0.0.1:65536/proxy", "rerun+http://a:b:9/proxy"):
        assert wrong(url=address)[0].startswith(f"--connect {address}: found no address of a viewer; ")
    assert wrong(url="localhost") == [
        "--connect localhost: found no address of a viewer; valid: rerun+http://HOST:9876/proxy."
        " A viewer says it when it starts."
    ]


def listeners(pid):
    """Addresses on which a process listens, as /proc has them: hexadecimal, lowest byte first."""
    inodes = set()
    for link in Path(f"/proc/{pid}/fd").iterdir():
        try:
            inodes |= set(re.findall(r"socket:\[(\d+)\]", str(link.readlink())))
        except OSError:
            continue
    found = []
    for table in ("tcp", "tcp6"):
        for line in Path(f"/proc/net/{table}").read_text().splitlines()[1:]:
            fields = line.split()
            if fields[3] == "0A" and fields[9] in inodes:
                found.append(fields[1].partition(":")[0])
    return found


@PROC
@pytest.mark.parametrize(
    ("chosen", "count"), [(LiveOptions(viewer=False), 1), (LiveOptions(web=True), 2)], ids=["server", "web"]
)
def test_nothing_listens_to_other_machines(chosen, count, monkeypatch):
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    said = []
    with LiveStream(chosen, said.append) as stream:
        deadline = time.monotonic() + 30
        while len(listeners(stream._server.pid)) < count and time.monotonic() < deadline:
            time.sleep(0.1)
        assert listeners(stream._server.pid) == ["0100007F"] * count
        if chosen.web:
            (address,) = re.findall(r"live in the browser at (\S+)", said[-1])
            with urllib.request.urlopen(address) as page:  # noqa: S310 - our own server
                assert b"rerun" in page.read().lower()
        assert not listeners(stream._process._child._process.pid)
        server = stream._server
    assert server.returncode is not None


def test_a_port_that_is_taken_is_told_and_another_one_found(monkeypatch):
    said = []
    with socket.create_server(("127.0.0.1", 0)) as other:
        monkeypatch.setattr(live, "PORT", other.getsockname()[1])
        with LiveStream(LiveOptions(viewer=False), said.append) as stream:
            assert rerun_program.answers(stream._url)
    found = int(re.findall(r"127.0.0.1:(\d+)/proxy", said[1])[0])
    assert said == [
        f"port {live.PORT} is taken, by another viewer perhaps; this one has {found}",
        f"live at rerun+http://127.0.0.1:{found}/proxy, look with: rerun rerun+http://127.0.0.1:{found}/proxy",
    ]


def test_without_a_display_it_says_how_to_connect(monkeypatch):
    monkeypatch.setattr(live, "has_display", lambda: False)
    said = []
    with LiveStream(LiveOptions(), said.append):
        pass
    assert said[-1].startswith("no display here; live at rerun+http://127.0.0.1:")


def test_a_server_that_was_stopped_does_not_hold_up_the_end():
    with LiveStream(LiveOptions(viewer=False), lambda _: None) as stream:
        stream._server.send_signal(signal.SIGSTOP)
    assert stream._server.returncode == -signal.SIGKILL  # anything softer would wait for ever


@contextmanager
def saving(url, path):
    """A viewer without a window that joins at `url` and keeps what it sees."""
    port = rerun_program.free_port(0)
    command = [
        rerun_program.executable(),
        "--connect",
        url,
        "--bind",
        "127.0.0.1",
        "--port",
        str(port),
        "--save",
        str(path),
    ]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        assert rerun_program.listens(port, 60, process)
        yield
    finally:
        process.kill()
        process.wait()


def values(path):
    """Everything that was sent to each entity at each tick."""
    found = defaultdict(dict)
    for chunk in RrdReader(path).stream():
        if not chunk.is_static and not chunk.entity_path.startswith("/limits"):  # those stand at the ends of batches
            batch = chunk.to_record_batch()
            columns = [name for name in batch.schema.names if ":" in name]
            for row in batch.select(["tick", *columns]).to_pylist():
                found[chunk.entity_path][row["tick"]] = [row[name] for name in columns]
    return found


def test_a_viewer_that_cannot_open_leaves_the_run_alone(monkeypatch):
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(live, "has_display", lambda: True)
    said = []
    with LiveStream(LiveOptions(), said.append) as stream:
        stream._server.wait(60)  # it may have listened before it found that there is no display
        stream.begin(None, None)
        assert stream._url is None
    assert said[-1] == "the viewer did not start; the run goes on without it"
    assert len(said) == 2


@pytest.mark.viewer
def test_the_viewer_opens_where_there_is_a_display_and_stays_when_the_run_is_over(graphics, tmp_path, monkeypatch):
    headless = tmp_path / "viewer"
    headless.write_text(f'#!/bin/sh\necho "$@" >{tmp_path}/said\nexec {rerun_program.executable()} --headless "$@"\n')
    headless.chmod(0o755)
    monkeypatch.setattr(live, "has_display", lambda: True)
    monkeypatch.setattr(rerun_program, "executable", lambda: str(headless))
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    said = []
    with LiveStream(LiveOptions(), said.append) as stream:
        url, server = stream._url, stream._server
    try:
        assert said[-1] == f"live in the viewer; another one can join at {url}"
        assert "serve" not in (tmp_path / "said").read_text()
        assert server.poll() is None
        assert rerun_program.answers(url)
    finally:
        server.kill()
        server.wait()


@contextmanager
def there_already():
    """The address of a server that a person started before."""
    port = rerun_program.free_port(0)
    server = rerun_program.serve(port, ["--serve-grpc"])
    try:
        assert rerun_program.listens(port, 60, server)
        yield LiveOptions(url=rerun_program.address(port))
    finally:
        server.kill()
        server.wait()


@pytest.mark.parametrize(
    "wanted", [lambda: nullcontext(LiveOptions(viewer=False)), there_already], ids=["own", "connect"]
)
def test_a_viewer_sees_what_the_recording_holds(tmp_path, monkeypatch, wanted):
    seen_by_then, done = [], Pacer.done

    def looking(pacer, tick):
        done(pacer, tick)
        if 8 <= tick < 20 and not seen_by_then:
            with suppress(RuntimeError, OSError):  # read in the middle of a message
                seen_by_then.extend(values(tmp_path / "seen.rrd").get("/signals/plant/state/x", ()))

    monkeypatch.setattr(Pacer, "done", looking)
    made = prepare("static", Options(mode="blocks", stop_time=2.0))
    with (
        wanted() as wish_,
        LiveStream(wish_, lambda _: None) as stream,
        saving(stream._url, tmp_path / "seen.rrd"),
    ):
        execution = Execution(Afterwards(), stream, realtime=1.0, figures=False)
        finished = execute(made, tmp_path / "r", SILENT, execution)
        expected = values(tmp_path / "r" / "recording.rrd")
        deadline = time.monotonic() + 20
        while not (seen := values(tmp_path / "seen.rrd")).get("/signals/plant/state/x", {}).get(20):
            assert time.monotonic() < deadline, "the last tick did not arrive"
            time.sleep(0.2)
    assert finished.notes == ()
    assert seen_by_then == list(range(len(seen_by_then)))
    assert 0 < len(seen_by_then) < 21, "while it drove"
    assert seen["/signals/plant/state/x"] == expected["/signals/plant/state/x"]
    ids = [
        RrdReader(path).recordings()[0].recording_id for path in (tmp_path / "seen.rrd", tmp_path / "r/recording.rrd")
    ]
    assert ids[0] == ids[1], "to a viewer they are one"
    assert {e for e in expected if e.startswith(("/signals", "/world"))} <= seen.keys()
