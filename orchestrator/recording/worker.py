"""The process that records: it reads messages until they end.

When they end without the last one, because the stepping process has died, it completes the recording with what it has.
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

from fmus.toolchain.child_process import ParentProcess
from orchestrator.recording.messages import NewRows, RecordingRequest

MessageQueue: TypeAlias = "queue.Queue[bytes | None]"
"""Pickled messages in the order in which they came; None after the last."""
_WAITING: Final = 32
"""The messages that may wait, so that a viewer that hangs does not fill the memory of this process."""
_LINGERS: Final = 5.0
"""[s] The time after the last message in which a viewer must take the rest; the stepping process waits for less."""


class _WithoutPandas(MetaPathFinder):
    """Hides pandas, which recording does not need, but which pyarrow imports as soon as Rerun hands it a list."""

    @override
    def find_spec(self, fullname: str, path: object, target: object = None) -> None:
        if fullname == "pandas":
            raise ModuleNotFoundError("left out of the process that records", name=fullname)


def main() -> None:
    """Record until the messages end."""
    sys.meta_path.insert(0, _WithoutPandas())
    parent = ParentProcess()
    messages: MessageQueue = queue.Queue(_WAITING)
    receiver = threading.Thread(target=_receive, args=(parent.requests, messages), daemon=True)
    receiver.start()
    _record(messages, receiver, parent)


def _receive(stream: IO[bytes], messages: MessageQueue) -> None:
    """Receive messages, so that the other process does not wait while this one gets ready; None comes after the last.

    Nothing is unpickled here, because that imports modules, and two threads that import modules that depend on each
    other would see them incomplete.
    """
    with contextlib.suppress(EOFError, pickle.UnpicklingError, OSError):
        while True:
            messages.put(pickle.load(stream))  # noqa: S301 - from the process that started this one
    messages.put(None)


def _give_up(receiver: threading.Thread) -> None:
    """End this process some time after the last message if its viewer hangs, because its parent may have died."""
    receiver.join()
    time.sleep(_LINGERS)
    os._exit(1)


def _next(messages: MessageQueue) -> Any:
    """The next message; waits for it."""
    message = messages.get()
    return None if message is None else pickle.loads(message)  # noqa: S301 - from the process that started this one


def _record(messages: MessageQueue, receiver: threading.Thread, parent: ParentProcess) -> None:
    # These are slow to import; the other process prepares the run at the same time.
    from orchestrator.recording.recording import Recording, joined  # noqa: PLC0415
    from orchestrator.results.run_folder import SYSTEM  # noqa: PLC0415
    from orchestrator.ssp import archive  # noqa: PLC0415
    from orchestrator.ssp import reader as ssp_reader  # noqa: PLC0415

    importlib.import_module("orchestrator.recording.stream")  # which `Recording` would import later
    request: RecordingRequest | None = _next(messages)
    if request is None:
        return
    if isinstance(request.sink, str):
        threading.Thread(target=_give_up, args=(receiver,), daemon=True).start()
    with archive.removed_packages():  # now, because later this process may be ended at any moment
        recording = Recording(request, ssp_reader.read(request.folder / SYSTEM))
    parent.answer("open")
    about, over = {**request.about, "status": "cut short"}, False
    while not over:
        received = _waiting(messages)
        over = received[-1] is None
        rows: list[NewRows] = [message for message in received if message is not None]
        about = next((part.about for part in rows if part.about is not None), about)
        recording.log(joined([batch for part in rows for batch in part.batches]), last=over)
    recording.close(about)


def _waiting(messages: MessageQueue) -> list[Any]:
    """All messages that have come, at least one; None after the last."""
    received = [_next(messages)]
    while not messages.empty() and received[-1] is not None:
        received.append(_next(messages))
    return received


if __name__ == "__main__":
    code = 0
    try:
        main()
    except Exception:  # noqa: BLE001 - the other process reports it
        traceback.print_exc()
        code = 1
    # Everything is written; an ordinary end would wait for threads that read from the pipe, or for a viewer that hangs.
    sys.stderr.flush()
    os._exit(code)
