"""Headless Chromium, driven through its debugging pipe: enough to open a page and photograph it."""

from __future__ import annotations

import base64
import io
import json
import os
import shutil
import subprocess
import time
from pathlib import Path

import numpy as np
from PIL import Image

PROGRAM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
_FLAGS = (
    "--headless=new",
    "--no-sandbox",  # CI runs as root in a container
    "--disable-dev-shm-usage",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--no-first-run",
    "--disable-extensions",
    "--window-size=1600,900",
    "--remote-debugging-pipe",
)


class Chromium:
    """A browser with one page, in a `with` statement."""

    def __init__(self, profile: Path) -> None:
        self._profile = profile
        self._number = 0
        self._rest = b""

    def __enter__(self):
        to_browser, self._commands = os.pipe()
        self._answers, from_browser = os.pipe()
        moved = f'exec 3<&{to_browser} 4>&{from_browser}; exec "$@"'  # the pipe is file descriptors 3 and 4
        command = ["bash", "-c", moved, "bash", PROGRAM, *_FLAGS, f"--user-data-dir={self._profile}", "about:blank"]
        self._process = subprocess.Popen(
            command, pass_fds=(to_browser, from_browser), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        os.close(to_browser)
        os.close(from_browser)
        pages = [t for t in self.ask("Target.getTargets")["targetInfos"] if t["type"] == "page"]
        attached = self.ask("Target.attachToTarget", targetId=pages[0]["targetId"], flatten=True)
        self._session = attached["sessionId"]
        return self

    def __exit__(self, *_):
        self._process.terminate()
        try:
            self._process.wait(10)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        os.close(self._commands)
        os.close(self._answers)

    def ask(self, method, **parameters):
        """The result of one command of the DevTools protocol."""
        self._number += 1
        message = {"id": self._number, "method": method, "params": parameters}
        if not method.startswith("Target."):
            message["sessionId"] = self._session
        os.write(self._commands, json.dumps(message).encode() + b"\0")
        while True:
            while b"\0" not in self._rest:
                part = os.read(self._answers, 1 << 20)
                assert part, "the browser has ended"
                self._rest += part
            text, _, self._rest = self._rest.partition(b"\0")
            answer = json.loads(text)
            if answer.get("id") == self._number:
                if "error" in answer:
                    raise RuntimeError(answer["error"]["message"])
                return answer["result"]

    def open(self, url):
        self.ask("Page.navigate", url=url)

    def picture(self, *, until, seconds=600.0):
        """An RGB picture (height, width, 3), the first of which `until(picture)` holds, or the last in that time."""
        deadline = time.monotonic() + seconds
        while True:
            late = time.monotonic() > deadline
            try:
                content = base64.b64decode(self.ask("Page.captureScreenshot")["data"])
            except RuntimeError:  # between two pages there is none
                if late:
                    raise
            else:
                picture = np.asarray(Image.open(io.BytesIO(content)).convert("RGB")).astype(int)
                if until(picture) or late:
                    return picture
            time.sleep(0.5)
