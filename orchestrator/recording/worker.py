"""What the process that records does: it reads messages until they end.

When the rows end without a word, because the stepping process has died, it completes the recording with what it has.
"""

from __future__ import annotations

import contextlib
import importlib
import os
import pickle
import queue
import sys
import threading
import time
import traceback
from importlib.abc import MetaPathFinder
from typing import IO, Any, Final, TypeAlias

from typing_extensions import override

from orchestrator.recording.messages import NewRows, RecordingRequest

MessageQueue: TypeAlias = "queue.SimpleQueue[bytes | None]"
_LINGERS: Final = 5.0
"""[s] for a viewer to take what is left; the other side, if it lives, waits for less"""


class _WithoutPandas(MetaPathFinder):
    """Hides pandas, which recording has no need of: pyarrow imports all of it as soon as Rerun hands it a list."""

    @override
    def find_spec(self, fullname: str, path: object, target: object = None) -> None:
        if fullname == "pandas":
            raise ModuleNotFoundError("left out of the process that records", name=fullname)


def main(stream: IO[bytes]) -> None:
    """The recording side: read messages until they end."""
    sys.meta_path.insert(0, _WithoutPandas())
    messages: MessageQueue = queue.SimpleQueue()
    receiver = threading.Thread(target=_receive, args=(stream, messages), daemon=True)
    receiver.start()
    _record(messages, receiver)


def _receive(stream: IO[bytes], messages: MessageQueue) -> None:
    """Take what comes, so that the other side never waits; nothing more is `None`.

    Nothing is imported here: two threads that import modules that need each other find them half made.
    """
    with contextlib.suppress(EOFError, pickle.UnpicklingError, OSError):
        while True:
            messages.put(pickle.load(stream))  # noqa: S301 - from the process that started this one
    messages.put(None)


def _give_up(receiver: threading.Thread) -> None:
    """End this process when its viewer hangs, some time after the last row: who started it may have died."""
    receiver.join()
    time.sleep(_LINGERS)
    os._exit(1)


def _next(messages: MessageQueue) -> Any:
    """The next message, as soon as there is one."""
    message = messages.get()
    return None if message is None else pickle.loads(message)  # noqa: S301 - from the process that started this one


def _record(messages: MessageQueue, receiver: threading.Thread) -> None:
    # slow to import; the run is prepared meanwhile
    from orchestrator.recording.recording import Recording, joined  # noqa: PLC0415
    from orchestrator.ssp import archive  # noqa: PLC0415
    from orchestrator.ssp import reader as ssp_reader  # noqa: PLC0415

    importlib.import_module("orchestrator.recording.stream")  # `Recording` would import it later
    request: RecordingRequest | None = _next(messages)
    if request is None:
        return
    if isinstance(request.sink, str):
        threading.Thread(target=_give_up, args=(receiver,), daemon=True).start()
    try:
        recording = Recording(request, ssp_reader.read(request.folder / "system.ssp"))
    finally:
        archive.remove_packages()  # all is read; later this process may be ended at any moment
    print("open", flush=True)  # noqa: T201 - what the other side waits for
    about, over = {**request.about, "status": "cut short"}, False
    while not over:
        found = _waiting(messages)
        over = found[-1] is None
        rows: list[NewRows] = [message for message in found if message is not None]
        about = next((part.about for part in rows if part.about is not None), about)
        recording.log(joined([batch for part in rows for batch in part.batches]), last=over)
    recording.close(about)


def _waiting(messages: MessageQueue) -> list[Any]:
    """All messages that have come, at least one; after the last there is `None`."""
    found = [_next(messages)]
    while not messages.empty() and found[-1] is not None:
        found.append(_next(messages))
    return found


if __name__ == "__main__":
    code = 0
    try:
        main(sys.stdin.buffer)
    except Exception:  # noqa: BLE001 - the other side tells
        traceback.print_exc()
        code = 1
    # at once: threads still read from the pipe, or hold on to a viewer that hangs; everything is written by now
    sys.stderr.flush()
    os._exit(code)
