"""The process that gives a live recording to the browser of whoever knows its address, and to nobody else.

Rerun's own server asks nobody who he is: every program on the machine, and every page in the browser that forges its
host, could read what is streamed to it, and write to it. This one gives away one file while it grows and takes nothing.
The file has a secret in its path, and a request must name this server as its host.
"""

from __future__ import annotations

import hmac
import socketserver
import threading
import time
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler
from pathlib import Path
from typing import Any, Final

from typing_extensions import override

from fmus.toolchain.child_process import ParentProcess

WATCHED: Final = "watched"
"""The message that asks whether anybody has asked for the file."""
_MOST_REQUESTS: Final = 64
"""The most requests that are served at a time, so that nobody can use up this process."""
STALLS_AFTER: Final = 1.5
"""[s] The time in which a viewer must take more of a recording that is complete, if it is to be waited for."""
_PAUSE: Final = 0.05
"""[s] The time after which a file is read on."""
_CHUNK: Final = 2**16


@dataclass(frozen=True)
class LiveFile:
    """What is given away."""

    path: Path
    secret: str
    """What the path of the address begins with."""
    page: str
    """The origin of the page whose scripts may read it."""

    @property
    def place(self) -> str:
        """The path of the address."""
        return f"/{self.secret}/live.rrd"


def growing(path: Path, complete: threading.Event) -> Iterator[bytes]:
    """The content of a file, part by part as it is written.

    Args:
        path: The file, which may not be there yet.
        complete: Set when nothing more will be written.
    """
    while not path.exists():
        if complete.wait(_PAUSE):
            return
    with path.open("rb") as file:
        over = False
        while not over:
            over = complete.is_set()  # before what is left is read
            while part := file.read(_CHUNK):
                yield part
            complete.wait(_PAUSE)


class LiveServer(socketserver.ThreadingTCPServer):
    """The server, on a free port of this machine that only this machine reaches.

    Args:
        file: What it gives away.
    """

    daemon_threads = True
    block_on_close = False

    def __init__(self, file: LiveFile) -> None:
        super().__init__(("127.0.0.1", 0), _Request)
        self.file, self.port = file, int(self.server_address[1])
        self.hosts = [f"127.0.0.1:{self.port}", f"localhost:{self.port}"]
        self.complete = threading.Event()
        self.asked, self.active, self.sent = 0, 0, 0
        """The requests so far and those that are being answered, and the bytes [byte] that have been sent."""
        self._counting = threading.Lock()
        self._free = threading.BoundedSemaphore(_MOST_REQUESTS)

    @override
    def process_request(self, request: Any, client_address: Any) -> None:
        if self._free.acquire(blocking=False):
            super().process_request(request, client_address)
        else:
            self.shutdown_request(request)

    @override
    def process_request_thread(self, request: Any, client_address: Any) -> None:
        try:
            super().process_request_thread(request, client_address)
        finally:
            self._free.release()

    def count(self, *, active: int = 0, sent: int = 0) -> None:
        """Count a request that begins or ends, or what has been sent."""
        with self._counting:
            self.asked += active > 0
            self.active, self.sent = self.active + active, self.sent + sent

    def finish(self) -> int:
        """Wait as long as the rest is taken, and return the number of requests that have not been answered."""
        self.complete.set()
        sent = -1
        while self.active and sent != self.sent:
            sent, ends = self.sent, time.monotonic() + STALLS_AFTER
            while self.active and time.monotonic() < ends:
                time.sleep(_PAUSE)
        return self.active

    @override
    def handle_error(self, request: Any, client_address: Any) -> None:
        """A client that has gone away is nobody's fault."""


class _Request(BaseHTTPRequestHandler):
    server: LiveServer  # type: ignore[assignment] - the only one that it is used with
    timeout = 30.0

    def do_GET(self) -> None:
        """Send the file as it grows, to the end of the run."""
        file = self.server.file
        known = hmac.compare_digest(self.path.encode(), file.place.encode())
        hosts = self.headers.get_all("Host", [])
        if not known or len(hosts) != 1 or hosts[0] not in self.server.hosts:
            self.send_error(HTTPStatus.NOT_FOUND)
            return
        self.send_response(HTTPStatus.OK)
        self.send_header("Content-Type", "application/octet-stream")
        self.send_header("Access-Control-Allow-Origin", file.page)
        self.send_header("Cache-Control", "no-store")
        self.end_headers()
        self.server.count(active=1)
        try:
            for part in growing(file.path, self.server.complete):
                self.wfile.write(part)
                self.server.count(sent=len(part))
        except OSError:
            pass  # the page has been closed
        finally:
            self.server.count(active=-1)

    @override
    def version_string(self) -> str:
        return "macrostep"

    @override
    def log_message(self, format: str, *args: Any) -> None:
        """Nobody reads it."""


def main() -> None:
    """Serve what the first request says until the other process ends.

    Each `WATCHED` is answered with the number of requests so far; any other message says that the file is complete.
    """
    parent = ParentProcess()
    with suppress(EOFError), LiveServer(parent.request()) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        parent.answer(server.port)
        while parent.request() == WATCHED:
            parent.answer(server.asked)
        parent.answer(server.finish())
        parent.request()


if __name__ == "__main__":
    main()
