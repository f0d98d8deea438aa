"""Watching a run: who is started, what listens where, who may read it, and what is said; the stream itself arrives.

Shows `live_viewers.py` and `live_server.py`, too.
"""

from __future__ import annotations

import os
import re
import signal
import socket
import subprocess
import threading
import time
import urllib.error
import urllib.request
from collections import defaultdict
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pandas as pd
import pytest
from rerun.chunk import RrdReader
from rerun.experimental import ViewerClient

from components.interfaces.problem import RequestError
from components.interfaces.progress import SILENT
from orchestrator.execution import Execution, execute
from orchestrator.recording.recording import Afterwards
from orchestrator.scenario.options import Options
from orchestrator.scenario.prepare import prepare
from orchestrator.stepping.pacing import Pacer
from orchestrator.viewing import live, live_viewers, rerun_program
from orchestrator.viewing.live import LiveOptions, LiveStream, live_options
from tests.waiting import wait_until

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
    """Hosts and ports on which a process listens, as /proc has them: hexadecimal, lowest byte first."""
    inodes = set()
    try:
        links = list(Path(f"/proc/{pid}/fd").iterdir())
    except OSError:  # the process has ended since it was counted
        links = []
    for link in links:
        try:
            inodes |= set(re.findall(r"socket:\[(\d+)\]", str(link.readlink())))
        except OSError:
            continue
    found = []
    for table in ("tcp", "tcp6"):
        for line in Path(f"/proc/net/{table}").read_text().splitlines()[1:]:
            fields = line.split()
            if fields[3] == "0A" and fields[9] in inodes:
                found.append(tuple(fields[1].split(":")))
    return found


@pytest.fixture
def no_display(monkeypatch):
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)


def page_and_file(said):
    """The page in the browser and the file that it shows, from what was said."""
    (address,) = re.findall(r"live in the browser at (\S+)", said[0])
    page, _, file = address.partition("?url=")
    return page, unquote(file)


def got(url, method="GET", **headers):
    """What a request gives: the status and the content."""
    request = urllib.request.Request(url, method=method, headers=headers)  # noqa: S310 - our own server
    try:
        with urllib.request.urlopen(request) as answer:  # noqa: S310
            return answer.status, answer.read()
    except urllib.error.HTTPError as error:
        with error:
            return error.code, error.read()


@PROC
def test_nothing_listens_to_other_machines_and_nothing_takes_a_stream(no_display):
    said = []
    with LiveStream(LiveOptions(web=True), said.append) as stream:
        page, file = page_and_file(said)
        program, server = stream._viewer._program, stream._viewer._server
        assert [f"{int(port, 16)}" for _, port in listeners(program.pid)] == [str(urlsplit(page).port)]
        of_server = [found for pid in family(server._process.pid) for found in listeners(pid)]
        assert {(host, int(port, 16)) for host, port in of_server} == {("0100007F", urlsplit(file).port)}
        assert {host for host, _ in listeners(program.pid)} == {"0100007F"}
        assert b"rerun" in got(page)[1].lower()
        assert not [found for pid in family(stream._process._child._process.pid) for found in listeners(pid)]
    assert program.returncode is not None
    assert not server.is_alive
    assert said[1:] == ["whoever has this address can watch on this machine, nobody can write"]


def test_only_who_knows_the_address_gets_the_stream(no_display):
    said = []
    with LiveStream(LiveOptions(viewer=False), said.append) as stream:
        page, file = page_and_file(said)
        stream._sink.write_bytes(b"the rows")
        assert stream._viewer.complete()
        parts = urlsplit(file)
        assert got(file) == (200, b"the rows")
        assert got(file.replace("127.0.0.1", "localhost")) == (200, b"the rows")
        secret = parts.path.split("/")[1]
        assert len(secret) > 20
        for path in ("/", "/live.rrd", f"/{secret}", f"/{secret[:-1]}/live.rrd", f"/{secret}/../{secret}/live.rrd"):
            assert got(f"http://{parts.netloc}{path}")[0] == 404
        for host in ("attacker.example", f"attacker.example:{parts.port}", "127.0.0.1", f"127.0.0.1:{parts.port}.a"):
            assert got(file, Host=host)[0] == 404
        with socket.create_connection((parts.hostname, parts.port)) as plain:
            plain.sendall(f"GET {parts.path} HTTP/1.1\r\n\r\n".encode())
            assert plain.makefile("rb").read().startswith(b"HTTP/1.0 404")
        for method in ("POST", "PUT", "OPTIONS", "DELETE"):
            assert got(file, method)[0] == 501
        with urllib.request.urlopen(file) as answer:  # noqa: S310 - our own
            assert answer.headers["Access-Control-Allow-Origin"] == page.rstrip("/")
        assert secret not in " ".join(Path(f"/proc/{stream._viewer._program.pid}/cmdline").read_text().split("\0"))


def test_many_connections_do_not_use_the_server_up(no_display, monkeypatch):
    said = []
    with LiveStream(LiveOptions(viewer=False), said.append) as stream, ExitStack() as held:
        _, file = page_and_file(said)
        stream._sink.write_bytes(b"the rows")
        assert stream._viewer.complete()
        place = urlsplit(file).hostname, urlsplit(file).port
        for _ in range(64):
            held.enter_context(socket.create_connection(place))
        for _ in range(50):
            with socket.create_connection(place) as other:
                assert other.recv(1) == b"", "it is closed at once"
        held.close()
        assert until_got(file) == (200, b"the rows")


def until_got(file):
    """What a request gives as soon as the server takes one."""
    while True:
        try:
            return got(file)
        except OSError:
            time.sleep(0.1)


def test_the_browser_is_opened_by_a_file_that_only_its_user_reads(monkeypatch):
    monkeypatch.setattr(live_viewers, "has_display", lambda: True)
    opened, said = [], []
    monkeypatch.setattr(live_viewers.webbrowser, "open", opened.append)
    with LiveStream(LiveOptions(web=True), said.append):
        (url,) = opened
        path = Path(url.removeprefix("file://"))
        assert path.stat().st_mode & 0o077 == 0
        assert "".join(page_and_file(said)) in unquote(path.read_text()).replace("?url=", "")
    assert not path.exists()


def test_without_a_display_it_says_so(no_display):
    said = []
    with LiveStream(LiveOptions(), said.append):
        pass
    assert said[0].startswith("no display here; live in the browser at http://127.0.0.1:")


def test_a_page_that_was_stopped_does_not_hold_up_the_end(no_display):
    with LiveStream(LiveOptions(viewer=False), lambda _: None) as stream:
        program, server = stream._viewer._program, stream._viewer._server
        program.send_signal(signal.SIGSTOP)
        for pid in family(server._process.pid):
            os.kill(pid, signal.SIGSTOP)
    assert program.returncode == -signal.SIGKILL  # anything softer would wait for ever
    assert not server.is_alive


def family(pid):
    """A process and all that it has started."""
    found = [pid]
    for each in found:
        children = Path(f"/proc/{each}/task/{each}/children")
        found += map(int, children.read_text().split()) if children.exists() else []
    return found


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


def test_a_viewer_that_cannot_open_leaves_the_run_alone(no_display, tmp_path, monkeypatch):
    monkeypatch.setattr(live, "has_display", lambda: True)
    made = prepare("static", Options(mode="blocks", stop_time=0.5))
    with LiveStream(LiveOptions(), lambda _: None) as stream:
        finished = execute(made, tmp_path / "r", SILENT, Execution(Afterwards(), stream, figures=False))
        assert stream._viewer._program.wait() == 1
    assert finished.ended is None
    assert finished.notes == ("the viewer did not take the whole run in time; the recording has it",)


def test_a_program_that_does_not_start_leaves_the_run_alone(no_display, monkeypatch):
    monkeypatch.setattr(rerun_program, "executable", lambda: "/bin/false")
    for has_display in (True, False):
        monkeypatch.setattr(live, "has_display", lambda has_display=has_display: has_display)
        said = []
        with LiveStream(LiveOptions(), said.append) as stream:
            stream.begin(None, None)
            assert stream.wait() == ""
        assert said[-1] == "the viewer did not start; the run goes on without it"


@pytest.fixture
def headless(graphics, tmp_path, monkeypatch):
    """The real viewer without a screen, and a list of what is said."""
    program = tmp_path / "viewer"
    program.write_text(f'#!/bin/sh\necho "$@" >{tmp_path}/said\nexec {rerun_program.executable()} --headless "$@"\n')
    program.chmod(0o755)
    monkeypatch.setattr(live, "has_display", lambda: True)
    monkeypatch.setattr(rerun_program, "executable", lambda: str(program))


def timelines(url):
    """The end of each timeline of the recording that a viewer shows."""
    state = ViewerClient.connect(url).get_state()
    return {timeline.name: timeline.end for recording in state.recordings for timeline in recording.timelines}


@pytest.mark.viewer
def test_the_window_is_fed_by_its_standard_input_and_stays_when_the_run_is_over(headless, tmp_path):
    said = []
    made = prepare("static", Options(mode="blocks", stop_time=0.5))
    with LiveStream(LiveOptions(), said.append) as stream:
        program = stream._viewer._program
        try:
            (port,) = re.findall(r"port (\d+)", said[0])
            arguments = (tmp_path / "said").read_text().split()
            assert arguments == ["--bind", "127.0.0.1", "--port", port, "--expect-data-soon", "-"]
            finished = execute(made, tmp_path / "r", SILENT, Execution(Afterwards(), stream, figures=False))
            assert finished.notes == ()
        except BaseException:
            program.kill()
            raise
    try:
        url = f"rerun+http://127.0.0.1:{port}/proxy"
        shown = {}
        while not shown:  # the time limit of the test ends this
            with suppress(RuntimeError, OSError):
                shown = timelines(url)
        assert shown["tick"] == 5
        assert program.poll() is None
    finally:
        program.kill()
        program.wait()
    assert said == [
        f"live in the viewer; any program on this machine that finds its port {port} can draw into its window and"
        " photograph it"
    ]


@contextmanager
def there_already(port=None):
    """The address of a server that a person started before."""
    port = port or rerun_program.free_port(0)
    server = rerun_program.serve(port, ["--serve-grpc"])
    try:
        assert rerun_program.listens(port, 60, server)
        yield LiveOptions(url=rerun_program.address(port))
    finally:
        server.kill()
        server.wait()


def test_a_viewer_that_is_already_open_sees_what_the_recording_holds(tmp_path, monkeypatch):
    with (
        there_already() as options,
        LiveStream(options, lambda _: None) as stream,
        saving(options.url, tmp_path / "seen.rrd"),
    ):
        assert_seen(stream, tmp_path, monkeypatch)


def test_a_page_gets_what_the_recording_holds(no_display, tmp_path, monkeypatch):
    said = []
    with LiveStream(LiveOptions(viewer=False), said.append) as stream:
        reading = threading.Thread(target=save, args=(page_and_file(said)[1], tmp_path / "seen.rrd"))
        reading.start()
        assert_seen(stream, tmp_path, monkeypatch)
        reading.join()


def test_a_run_that_waits_begins_when_somebody_opens_the_page(no_display, tmp_path):
    said, stepped = [], []

    def watched():
        wait_until(lambda: "the run begins when somebody opens the address" in said)
        time.sleep(0.3)
        stepped.append(len(pd.read_parquet(tmp_path / "r" / "rows")))
        save(page_and_file(said)[1], tmp_path / "seen.rrd")

    with LiveStream(LiveOptions(viewer=False, wait=True), said.append) as stream:
        reading = threading.Thread(target=watched)
        reading.start()
        made = prepare("static", Options(mode="blocks", stop_time=0.5))
        finished = execute(made, tmp_path / "r", SILENT, Execution(Afterwards(), stream, figures=False))
        reading.join()
    assert stepped == [0]
    assert finished.ended is None
    assert values(tmp_path / "seen.rrd")["/signals/plant/state/x"].keys() == set(range(6))


def _port_that_nobody_is_given():
    """A free port below those of outgoing connections: one who asks for such a port again and again meets himself."""
    for port in range(20000 + os.getpid() % 8000, 32000):
        with socket.socket() as probe, suppress(OSError):
            probe.bind(("127.0.0.1", port))
            return port
    raise AssertionError


def test_a_run_that_waits_for_a_viewer_at_an_address_begins_when_it_answers():
    said = []
    port = _port_that_nobody_is_given()
    options = LiveOptions(url=f"rerun+http://127.0.0.1:{port}/proxy", wait=True)
    seen = threading.Event()

    def open_later():
        wait_until(lambda: said)
        with there_already(port):  # it ends with the thread that has started it
            seen.wait()

    opening = threading.Thread(target=open_later)
    opening.start()
    try:
        with LiveStream(options, said.append):
            pass
    finally:
        seen.set()
        opening.join()
    assert said == [f"the run begins when a viewer answers at {options.url}"]


def test_waiting_needs_live():
    with pytest.raises(RequestError, match="--wait: found no --live; valid: with --live only"):
        live_options(live=False, viewer=True, web=False, url=None, wait=True)


def save(url, path):
    """Read a stream to its end, and keep what has come at any time."""
    with urllib.request.urlopen(url) as answer, path.open("wb") as file:  # noqa: S310 - our own
        while part := answer.read1():
            file.write(part)
            file.flush()


def assert_seen(stream, folder, monkeypatch):
    """Run with a stream that is saved to a file, and compare that with the recording."""
    seen_by_then, done = [], Pacer.done

    def looking(pacer, tick):
        done(pacer, tick)
        if 8 <= tick < 20 and not seen_by_then:
            with suppress(RuntimeError, OSError):  # read in the middle of a message
                seen_by_then.extend(values(folder / "seen.rrd").get("/signals/plant/state/x", ()))

    monkeypatch.setattr(Pacer, "done", looking)
    made = prepare("static", Options(mode="blocks", stop_time=2.0))
    finished = execute(made, folder / "r", SILENT, Execution(Afterwards(), stream, realtime=1.0, figures=False))
    expected = values(folder / "r" / "recording.rrd")
    while not (seen := values(folder / "seen.rrd")).get("/signals/plant/state/x", {}).get(20):
        time.sleep(0.2)  # the time limit of the test ends this
    assert finished.notes == ()
    assert seen_by_then == list(range(len(seen_by_then)))
    assert 0 < len(seen_by_then) < 21, "while it drove"
    assert seen["/signals/plant/state/x"] == expected["/signals/plant/state/x"]
    files = folder / "seen.rrd", folder / "r/recording.rrd"
    ids = [RrdReader(path).recordings()[0].recording_id for path in files]
    assert ids[0] == ids[1], "to a viewer they are one"
    assert {e for e in expected if e.startswith(("/signals", "/world"))} <= seen.keys()
