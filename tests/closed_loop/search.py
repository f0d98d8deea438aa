"""A search for scenarios that break the rules of the planners, for every controller that plans a path:

* the path under the vehicle never jumps;
* a return that has begun is finished where it was planned;
* a change that has begun goes to the lane that it was planned to;
* the vehicle stays on its path, as long as that leads into nobody who is ahead.

    python -m tests.closed_loop.search --count 10000 --seed 1
"""

from __future__ import annotations

import argparse
from collections import Counter
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import pandas as pd

from components import BLOCKS
from components.interfaces.buses import SLOTS, WAYPOINTS
from orchestrator import Options, load, simulate
from orchestrator.results.path_geometry import path_error

CONTROLLERS = ("mpc", "mpc_plus", "lqr", "stanley", "pure_pursuit", "two_level_mp")
JUMP = 0.05
"""[m] The largest jump of the path under the vehicle that is none."""
LOST = 2.6
"""[m] Distance from the path at which a vehicle is lost: half of a lane and half of its width."""
AHEAD = 25.0
"""[m] Distance to somebody ahead in the path at which nothing is expected any more: it cannot be braked in time."""
P1, P7, P8, P11 = 1, 7, 8, 11
W = 3.5
"""[m] Width of a lane."""


@dataclass(frozen=True)
class Case:
    """A scenario: who drives, how fast, and what is on the road.

    Lane 0 is the own one, 1 the adjacent one on its left, and 2 the third one, if there is one.
    """

    controller: str
    v_ref: float
    v_start: float
    x: tuple[float, ...]
    lanes: tuple[int, ...]
    v: tuple[float, ...]
    y_third: float | None = None

    def run(self, until: float = 12.0) -> pd.DataFrame:
        """The rows of the run."""
        settings = [
            f"traffic.valid={[i < len(self.x) for i in range(SLOTS)]}".lower(),
            f"traffic.x_start={list(self.x)}",
            f"traffic.y_start={[self._across[lane] for lane in self.lanes]}",
            f"traffic.v_start={list(self.v)}",
            f"traffic.v_final={list(self.v)}",
            f"plant.v_x_start={self.v_start}",
            f"controller.v_ref={self.v_ref}",
            *([] if self.y_third is None else self._road),
        ]
        replaced = {"controller": self.controller}
        made = load("static", Options(mode="blocks", settings=settings, replacements=replaced))
        return simulate(made.system, h=made.h, until=until)

    @property
    def _across(self) -> tuple[float, ...]:
        """Where the lanes are."""
        return 0.0, W, W if self.y_third is None else self.y_third

    @property
    def _road(self) -> list[str]:
        """The settings of a road with three lanes; controllers that track a fixed path know no edges."""
        edges = {"y_left": max(self._across) + W / 2, "y_right": min(self._across) - W / 2}
        known = BLOCKS[self.controller].parameters()
        values = {"y_third": self.y_third, **{n: y for n, y in edges.items() if n in {p.name for p in known}}}
        scene = {"y_third": self.y_third, **edges}
        return [f"{unit}.{n}={y}" for unit, of in (("controller", values), ("scene", scene)) for n, y in of.items()]

    def breaches(self, frame: pd.DataFrame | None = None) -> dict[str, str]:
        """What breaks a rule, by rule, in words."""
        frame = self.run() if frame is None else frame
        x, y = (frame[f"plant.state.{axis}"].to_numpy() for axis in "xy")
        points = [[f"controller.path.{axis}[{i}]" for i in range(1, WAYPOINTS + 1)] for axis in "xy"]
        path_x, path_y = (frame[names].to_numpy() for names in points)
        error = path_error(path_x, path_y, x, y)
        before = path_error(path_x[:-1], path_y[:-1], x[1:], y[1:])  # where the vehicle would be on the path of before
        found: dict[str, str] = {}
        jump = np.abs(error[1:] - before)
        if jump.max() > JUMP:
            found["jump"] = f"the path jumps by {jump.max():.3g} m at {0.1 * (1 + jump.argmax()):.3g} s"
        begun = (path_x[:-1, P8] < x[:-1]) & (x[1:] < path_x[:-1, P11]) & (path_y[:-1, P8] != path_y[:-1, P11])
        moved = begun & (np.abs(np.diff(path_x[:, P8])) > 1e-9)
        if moved.any():
            found["return"] = f"a return that has begun is moved at {0.1 * (1 + moved.argmax()):.3g} s"
        going = (x[1:] > path_x[:-1, P1] + 1e-9) & (x[1:] < path_x[:-1, P11]) & (path_y[:-1, P7] != path_y[:-1, P11])
        switched = going & (path_x[:-1, P1] < x[:-1]) & (path_y[1:, P7] != path_y[:-1, P7])
        if switched.any():
            found["lane"] = f"a change that has begun goes to another lane at {0.1 * (1 + switched.argmax()):.3g} s"
        clear = np.logical_and.accumulate(~self._is_led_into_somebody(frame, path_x, path_y))
        off = np.abs(error[clear]).max(initial=0.0)
        if off > LOST:
            found["lost"] = f"{off:.3g} m from the path at {0.1 * np.abs(error[clear]).argmax():.3g} s"
        return found

    def _is_led_into_somebody(self, frame: pd.DataFrame, path_x: np.ndarray, path_y: np.ndarray) -> np.ndarray:
        """In which rows somebody is close ahead in the way of the path."""
        led = np.zeros(len(frame), dtype=bool)
        for i in range(1, len(self.x) + 1):
            x, y = (frame[f"traffic.obstacles.{axis}[{i}]"].to_numpy() for axis in "xy")
            ahead = x - frame["plant.state.x"].to_numpy()
            led |= (ahead > 0) & (ahead < AHEAD) & (np.abs(path_error(path_x, path_y, x, y)) < 1.75)
        return led


def drawn(random: np.random.Generator) -> Case:
    """A case by chance: up to four obstacles, or six, slower than the ego, none of them where it starts.

    Half of the roads have two lanes; the third of the others is on the right of the own one or beyond the adjacent one.
    """
    y_third = (None, None, -W, 2 * W)[int(random.integers(4))]
    count = int(random.integers(1, 5) if y_third is None else random.integers(3, 7))
    v_ref = float(np.round(random.uniform(8, 20), 1))
    return Case(
        controller=str(random.choice(CONTROLLERS)),
        v_ref=v_ref,
        v_start=float(np.round(random.choice([v_ref, random.uniform(0, v_ref)]), 1)),
        x=tuple(np.round(random.uniform(20 + 2 * v_ref, 200, count), 1).tolist()),
        lanes=tuple(random.integers(0, 2 if y_third is None else 3, count).tolist()),
        v=tuple(np.round(random.choice([0, random.uniform(0, 0.8 * v_ref)], count), 1).tolist()),
        y_third=y_third,
    )


def main() -> None:
    """Search, and print every breach and their numbers."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--three", action="store_true", help="only roads with three lanes")
    given = parser.parse_args()
    random = np.random.default_rng(given.seed)
    tried: Counter[str] = Counter()
    broken: Counter[tuple[str, str]] = Counter()
    for _ in range(given.count):
        case = drawn(random)
        if given.three and case.y_third is None:
            continue
        tried[case.controller] += 1
        try:
            found = case.breaches()
        except Exception as error:  # noqa: BLE001 - whatever breaks is what is searched for
            found: dict[str, Any] = {"fault": str(error)}
        for rule, text in found.items():
            broken[case.controller, rule] += 1
            print(rule, text, asdict(case), flush=True)  # noqa: T201 - a command
    for controller, number in sorted(tried.items()):
        rules = {rule: n for (name, rule), n in sorted(broken.items()) if name == controller}
        print(controller, number, rules)  # noqa: T201 - a command


if __name__ == "__main__":
    main()
