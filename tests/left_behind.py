"""What processes have left in a folder for temporary files."""

from __future__ import annotations


def left_in(place):
    """The files and folders in it, but for the folder that a living process keeps, and its lock."""
    kept = {path.parent for path in place.glob("macrostep_*/.lock")}
    inside = [path for folder in kept for path in folder.iterdir() if path.name != ".lock"]
    return [path for path in place.iterdir() if path not in kept] + inside
