"""All processes of a run are killed at any tick: its rows are on disk, two seconds behind at most, for pandas."""

from __future__ import annotations

import os
import signal
import time

import numpy as np
import pandas as pd

from orchestrator.results.completion import finish
from tests.faults.commands import Started, is_whole, running
from tests.faults.scoring import fault
from tests.faults.security import simple

GROUP = "rows"
H, MOST = 0.1, 2.0


def counted(folder):
    """How many rows pandas reads; 0 while there are none."""
    try:
        return len(pd.read_parquet(folder / "rows"))
    except FileNotFoundError:
        return 0


def killed(number, name, *options, short):
    @fault(GROUP, name, short=short)
    def check(folder, random):
        run = Started(folder, "run", "static", "--blocks", "--realtime", 1, "--out", "r", *options)
        run.wait_for("r/rows/part-000001.parquet")
        while not counted(folder / "r") and run.process.poll() is None:
            time.sleep(0.05)
        until, ahead = time.monotonic() + 6 * random.random(), float("-inf")
        while (now := time.monotonic()) < until:
            ahead = max(ahead, counted(folder / "r") * H - now)  # the pace of the run is that of the clock
            time.sleep(0.05)
        os.killpg(run.process.pid, number)
        late = time.monotonic()
        run.process.communicate()
        rows = pd.read_parquet(folder / "r" / "rows")
        assert len(rows) >= 1
        assert np.rint(rows["time"] / H).tolist() == list(range(len(rows)))
        assert late + ahead - len(rows) * H <= MOST, (late, ahead, len(rows))
        assert not running(run.process.pid), "processes are left"
        finish(folder / "r", "it was killed")
        told = is_whole(folder / "r", "fault")
        assert told["fault"]["reason"] == "it was killed"

    return check


for i in range(4):
    killed(signal.SIGKILL, f"SIGKILL to all processes at any tick ({i + 1})", short=i == 0)


HANGS = """
#include <unistd.h>
#include "fmi3Functions.h"
#undef fmi3DoStep
#define fmi3DoStep stepped
#include "echo3.c"
#undef fmi3DoStep
fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 t, fmi3Float64 h, fmi3Boolean n, fmi3Boolean *e, fmi3Boolean *d,
                      fmi3Boolean *r, fmi3Float64 *l) {
    while (t > 0.45) sleep(1);
    return stepped(c, t, h, n, e, d, r, l);
}
"""


@fault(GROUP, "SIGKILL while a step hangs", short=False)
def while_a_step_hangs(folder, _):
    simple(folder, source=HANGS)
    run = Started(folder, "run", "m.fmu", "--in-process", "--stop-time", 2, "--step", H, "--out", "r")
    run.wait_for("r/rows/part-000001.parquet")
    deadline = time.monotonic() + 60
    while counted(folder / "r") < 6 and time.monotonic() < deadline:
        time.sleep(0.05)
    os.killpg(run.process.pid, signal.SIGKILL)
    run.process.communicate()
    assert counted(folder / "r") == 6
