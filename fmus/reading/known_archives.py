"""FMU files that this process has read: the same bytes at the same place are not read and checked again."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

from fmus.reading.archive import Archive
from fmus.toolchain.file_digest import digest_of

_MOST: Final = 64
_MOST_VARIABLES: Final = 5000
"""The most variables of a description that is kept; each takes some kilobytes."""
_known: OrderedDict[tuple[Any, ...], Archive] = OrderedDict()
_changing: Final = threading.Lock()


def known_or_read(path: Path, choices: tuple[Any, ...], read: Callable[[], Archive]) -> Archive:
    """The content of an FMU file.

    One with structural parameters is read each time, because their values decide what it looks like.

    Args:
        path: The file.
        choices: All else that the result depends on.
        read: Reads the file.
    """
    try:
        key = path, digest_of(path), *choices
    except OSError:
        return read()  # it tells why
    with _changing:
        if key in _known:
            _known.move_to_end(key)
            return _known[key]
    found = read()
    if not found.structural and len(found.description.modelVariables) <= _MOST_VARIABLES:
        with _changing:
            _known[key] = found
            if len(_known) > _MOST:
                _known.popitem(last=False)
    return found
