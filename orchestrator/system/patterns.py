"""Patterns of signals, as people type them."""

from __future__ import annotations

from fnmatch import fnmatchcase


def fits(path: str, pattern: str) -> bool:
    """Whether a pattern fits a path; the brackets of arrays may be typed as they are.

    Args:
        path: The full path of a signal, such as `plant.tyre[1].F_z`.
        pattern: The pattern, such as `plant.tyre[1].*`.
    """
    if path == pattern or fnmatchcase(path, pattern):
        return True
    return "[" in pattern and fnmatchcase(path, pattern.replace("[", "[[]"))
