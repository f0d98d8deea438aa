"""What the commands say on the terminal."""

from __future__ import annotations

from collections.abc import Callable, Generator
from contextlib import contextmanager

from rich.console import Console

# no emoji: a pattern like `plant.*:x` is said as it was written
out = Console(soft_wrap=True, highlight=False, emoji=False)
err = Console(stderr=True, soft_wrap=True, highlight=False, emoji=False)


@contextmanager
def working() -> Generator[Callable[[str], None]]:
    """A line that says what is going on, on terminals; plain lines elsewhere only for what takes long."""
    with err.status("starting") as status:

        def tell(text: str) -> None:
            status.update(text)
            if text.startswith("built "):
                err.print(text)

        yield tell
