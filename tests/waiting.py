"""Waiting in tests: for what must happen, however busy the machine is; the time limit of a test ends what does not."""

from __future__ import annotations

import os
import signal
import threading
import time


def wait_until(holds):
    """Wait until something holds, and give it."""
    while not (found := holds()):
        time.sleep(0.05)
    return found


def ctrl_c_as_soon_as(holds):
    """Have this process interrupted by a thread, as soon as something holds."""

    def press():
        wait_until(holds)
        os.kill(os.getpid(), signal.SIGINT)

    threading.Thread(target=press, daemon=True).start()
