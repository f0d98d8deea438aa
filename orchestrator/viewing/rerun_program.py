"""Rerun's own program: the viewer and its servers, which listen on this machine only."""

from __future__ import annotations

import ctypes
import os
import re
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from importlib.util import find_spec
from pathlib import Path
from typing import IO, Final
from urllib.parse import quote, urlsplit

from platformdirs import user_config_path

from components.interfaces.problem import refuse
from fmus.toolchain.limits import LIBRARY_MEMORY, LIBRARY_TIME
from fmus.toolchain.memory_limit import memory_limit

LOOPBACK: Final = "127.0.0.1"
PORT: Final = 9876
"""The port that viewers use unless they are given another one."""
_PAGE: Final = re.compile(rf"http://{re.escape(LOOPBACK)}:\d+")
_ANSWERS_WITHIN: Final = 2.0
"""[s] The time within which a viewer that is already running must accept a connection."""


def executable() -> str:
    """The path of Rerun's program itself; its Python wrapper would be a process between this one and the viewer.

    Raises:
        RequestError: The package has no such program.
    """
    spec = find_spec("rerun_cli")
    places = list(spec.submodule_search_locations or ()) if spec else []
    for name in ("Rerun.app/Contents/MacOS/Rerun", "rerun", "rerun.exe"):
        for place in places:
            if (path := Path(place) / name).is_file():
                return str(path)
    raise refuse("Rerun viewer", "no viewer in the package rerun-sdk", "rerun-sdk with its viewer", "Install it again.")


def tell_of_usage_data(tell: Callable[[str], None]) -> None:
    """Say that Rerun collects usage data, before its program is used for the first time: its own notice is not shown.

    On a machine for continuous integration (the environment variable CI) it collects none, and keeps no settings.

    Args:
        tell: Called with a line of text for the user.
    """
    if "CI" in os.environ and "FORCE_RERUN_ANALYTICS" not in os.environ:
        return
    folder = user_config_path("rerun", appauthor=False, roaming=True)
    if not any((folder / name).is_file() for name in ("analytics.json", "config/analytics.json")):
        tell(
            "note: the Rerun viewer sends anonymous usage data from its second start on, no data of runs;"
            " `rerun analytics details` says more, `rerun analytics disable` opts out"
        )


def answer_of(*arguments: str) -> str:
    """What Rerun's program prints when it is asked about a file; damaged ones may crash it, or hang it.

    Args:
        arguments: What it is asked.

    Returns:
        Its words; empty where it finds a fault, or does not come to an end.

    Raises:
        RequestError: There is no such program.
    """
    try:
        done = subprocess.run(  # noqa: S603 - the program that rerun-sdk brings
            [executable(), *arguments],
            capture_output=True,
            check=False,
            timeout=LIBRARY_TIME,
            preexec_fn=_with_limits() if os.name == "posix" else None,
        )
    except subprocess.TimeoutExpired:
        return ""
    return (done.stdout + done.stderr).decode("utf-8", "replace") if done.returncode == 0 else ""


def _with_limits() -> Callable[[], object]:
    """What the process does first so that it takes no more memory than it may, and ends with this one."""
    limit_memory, with_parent = memory_limit(LIBRARY_MEMORY), end_with_parent()

    def prepare() -> None:
        limit_memory()
        if with_parent is not None:
            with_parent()

    return prepare


def serve(  # noqa: PLR0913 - what a process is started with
    port: int,
    how: list[str],
    *,
    stays: bool = False,
    environment: Mapping[str, str] | None = None,
    fed: bool = False,
    said: IO[bytes] | None = None,
) -> subprocess.Popen[bytes]:
    """Start Rerun's program with a server that listens on this machine only.

    Args:
        port: Where it listens.
        how: Further options of the program.
        stays: Whether it may outlive this process.
        environment: Its environment variables; those of this process if not given.
        fed: Whether its standard input is a pipe, to which this process writes.
        said: A file for what it says; nobody reads that if not given.

    Returns:
        The process.

    Raises:
        RequestError: There is no such program.
    """
    command = [executable(), "--bind", LOOPBACK, "--port", str(port), *how]
    # It has a session of its own, because Ctrl-C in the terminal ends the run, and a window stays open after that.
    return subprocess.Popen(  # noqa: S603 - the program that rerun-sdk brings
        command,
        bufsize=0,
        stdin=subprocess.PIPE if fed else subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL if said is None else said,
        env=environment,
        start_new_session=True,
        preexec_fn=None if stays else end_with_parent(),  # noqa: PLW1509 - one call into libc, which takes no locks
    )


def address(port: int) -> str:
    """The URL at which a server on a port of this machine takes streams."""
    return f"rerun+http://{LOOPBACK}:{port}/proxy"


def listens(port: int, within: float, server: subprocess.Popen[bytes]) -> bool:
    """Wait until a server listens.

    Args:
        port: Where it will listen.
        within: Longest time to wait [s].
        server: Its process; there is nothing to wait for when it has ended.

    Returns:
        Whether it listens.
    """
    deadline = time.monotonic() + within
    while time.monotonic() < deadline and server.poll() is None:
        with socket.socket() as probe:
            probe.settimeout(1)
            if probe.connect_ex((LOOPBACK, port)) == 0:
                return True
        time.sleep(0.05)
    return False


def answers(url: str) -> bool:
    """Whether a viewer listens at a URL."""
    parts = urlsplit(url)
    try:
        with socket.create_connection((parts.hostname or "", parts.port or PORT), _ANSWERS_WITHIN):
            return True
    except (OSError, ValueError):
        return False


def free_port(wanted: int) -> int:
    """A free port of this machine.

    Args:
        wanted: The port to prefer.

    Raises:
        RequestError: No port is free.
    """
    for port in (wanted, 0):
        with socket.socket() as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            try:
                probe.bind((LOOPBACK, port))
            except OSError:
                continue
            return int(probe.getsockname()[1])
    raise refuse("--live", "no free port on this machine", "a machine with one")


def has_display() -> bool:
    """Whether this machine has a display on which a window can open."""
    if sys.platform.startswith("linux"):
        return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
    return True


def page_address(said: str) -> str | None:
    """Where the program serves its page, from what it says; None as long as it has not said it."""
    found = _PAGE.search(said)
    return None if found is None else found[0]


def web_address(page: str, url: str) -> str:
    """The address of the web viewer whose `page` shows the recording at a URL."""
    return f"{page}/?url={quote(url, safe='')}"


def end_with_parent() -> Callable[[], object] | None:
    """What a child process must do first so that it ends when its parent dies; None where no system call does it."""
    if not sys.platform.startswith("linux"):
        return None
    prctl = ctypes.CDLL(None).prctl
    return lambda: prctl(1, signal.SIGKILL)  # PR_SET_PDEATHSIG
