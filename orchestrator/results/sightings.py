"""Who is seen in a run: obstacles go by their `id`, as a slot of the bus may hold another one from row to row."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from components.interfaces.maths import Array


class Sightings(NamedTuple):
    """The first and the last time that each of some obstacles is seen, as indices `(obstacles,)`."""

    first: NDArray[np.int64]
    last: NDArray[np.int64]


def identities(valid: NDArray[np.bool_], identity: Array) -> NDArray[np.int64]:
    """The identities of the obstacles in n rows, `(n, slots)`.

    They are the numbers of the slots where the traffic gives two obstacles of a row the same identity: it has none.

    Args:
        valid: Whether the slot holds an obstacle, `(n, slots)`.
        identity: What the bus says, `(n, slots)`.
    """
    slots = np.arange(1, valid.shape[1] + 1, dtype=np.int64)
    distinct = np.sort(np.where(valid, identity, -slots - 0.5), axis=1)  # empty slots have numbers that no other has
    shared = (np.diff(distinct, axis=1) == 0).any()
    return np.broadcast_to(slots, valid.shape) if shared else np.nan_to_num(identity).astype(np.int64)


def sightings(identity: NDArray[np.int64]) -> Sightings:
    """When each obstacle is seen first and last, in the order of their identities.

    Args:
        identity: The identity of each sighting, row after row, `(sightings,)`.
    """
    _, first = np.unique(identity, return_index=True)
    _, behind = np.unique(identity[::-1], return_index=True)
    return Sightings(first, len(identity) - 1 - behind)
