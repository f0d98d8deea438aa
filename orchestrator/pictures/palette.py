"""Colours of the viewer's pictures, which are legible on a dark and on a light ground alike.

The viewer draws a label in the colour of its entity, on a plate that is dark in one theme and grey in the other.
Entities with labels are therefore nearly white.
"""

from __future__ import annotations

from typing import Final

from orchestrator.pictures.shapes import Colour

GROUND: Final[Colour] = (28, 32, 30)
ROAD: Final[Colour] = (58, 61, 66)
EDGE: Final[Colour] = (225, 225, 225)
MARK: Final[Colour] = (190, 190, 190)
EGO: Final[Colour] = (70, 150, 255)
HEADING: Final[Colour] = (10, 25, 60)
NAME: Final[Colour] = (240, 240, 240)
OBSTACLE: Final[Colour] = (215, 95, 45)
BOUNDARY: Final[Colour] = (255, 195, 150)
PATH: Final[Colour] = (190, 145, 255)
WAYPOINT: Final[Colour] = (235, 225, 250)
PLAN: Final[Colour] = (255, 255, 255)
CORRIDOR: Final[Colour] = (250, 205, 70)
LIMIT: Final[Colour] = (150, 150, 150)
GRID: Final[Colour] = (110, 110, 110)
LEVELS: Final[dict[str, Colour]] = {"INFO": (140, 140, 140), "WARN": (225, 135, 40), "ERROR": (220, 85, 85)}
"""The colour of a line of the log, which has no room for the name of its level."""

SERIES: Final[tuple[Colour, ...]] = (
    (70, 145, 230),
    (225, 135, 40),
    (50, 165, 105),
    (220, 85, 85),
    (155, 115, 220),
    (45, 170, 185),
)
SERIES_NAMES: Final = ("blue", "orange", "green", "red", "violet", "cyan")
"""The name of each colour, for titles."""
RUNS: Final[tuple[Colour, ...]] = (
    EGO,
    (240, 140, 40),
    (60, 180, 110),
    (225, 80, 130),
    (165, 120, 230),
    (50, 185, 195),
    (180, 150, 30),
    (165, 105, 70),
    (125, 135, 150),
    (220, 70, 60),
    (105, 165, 40),
    (215, 135, 185),
)
"""One per run of a comparison, from the start again where there are more runs."""

RUN_NAMES: Final = (
    "blue",
    "orange",
    "green",
    "pink",
    "violet",
    "cyan",
    "yellow",
    "brown",
    "grey",
    "red",
    "lime",
    "mauve",
)

STATES: Final[dict[str, Colour]] = {
    "converged": (55, 150, 95),
    "iteration_limit": (205, 140, 35),
    "fallback": (205, 65, 60),
    "own lane": (90, 105, 125),
    "changing out": (70, 130, 210),
    "adjacent lane": (45, 140, 150),
    "third lane": (150, 120, 45),
    "changing back": (125, 100, 200),
    "false": (95, 100, 110),
    "true": (55, 150, 95),
}


def state(name: str, i: int) -> Colour:
    """The colour of the state `name`, which is the `i`-th state of its signal."""
    return STATES.get(name, SERIES[i % len(SERIES)])


def series_name(i: int) -> str:
    """The name of the colour of the `i`-th series of a bus."""
    return SERIES_NAMES[i % len(SERIES)]


def run_name(i: int) -> str:
    """The name of the colour of the `i`-th run of a comparison."""
    return RUN_NAMES[i % len(RUNS)]


def run(i: int) -> Colour:
    """The colour of the `i`-th run of a comparison."""
    return RUNS[i % len(RUNS)]


def paler(colour: Colour, share: float = 0.45) -> Colour:
    """The colour mixed with a share of grey, for what is less important."""
    r, g, b = (round(c + (165 - c) * share) for c in colour)
    return r, g, b
