"""One step of a controller's FMU at every instant of the static run: the median, and the longest.

Each instant is timed in many passes, and its shortest time counts: what else the machine does is left out, what the
solve needs at that instant is not. Ratios are to the shortest instant of the same run, at which the search begins
almost at the optimum.
"""

from __future__ import annotations

from statistics import median
from time import perf_counter_ns

import pytest

from components.interfaces.quantity import zeros
from fmus import fmu_unit, open_fmu
from fmus.toolchain.version import WRITTEN_VERSIONS
from fmus.units.unit import views, widths
from orchestrator import Options, load, simulate

H, PASSES = 0.1, 60
BUDGET = {"mpc, median": "9 us", "mpc, longest": "as long as ten iterations take, 20 us"}
SOURCES = {"ego": "plant.state", "obstacles": "traffic.obstacles"}


def driven(made, inputs):
    """What the controller reads at each tick of its run, as columns by type."""
    frame, rows = simulate(made.system, h=made.h, until=made.until), []
    for _, signals in frame.iterrows():
        columns = {kind: zeros(kind, n) for kind, n in widths(inputs).items()}
        for name, slots in views(inputs, columns).items():
            bus, _, signal = name.partition(".")
            source = f"{SOURCES[bus]}.{signal}"
            elements = [f"{source}[{i + 1}]" for i in range(len(slots))]
            slots[:] = signals[source] if source in signals else signals[elements]
        rows.append(columns)
    return rows


@pytest.mark.benchmark(group="one step of a controller's FMU")
@pytest.mark.parametrize("controller", ["mpc", "two_level_mp", "mpc_plus"])
@pytest.mark.parametrize("version", WRITTEN_VERSIONS, ids=lambda v: f"fmi{v}")
def test_each_instant_of_the_static_run(benchmark, built_fmus, version, controller):
    made = load("static", Options(mode="blocks", replacements={"controller": controller}))
    unit = fmu_unit("controller", open_fmu(built_fmus / f"fmi{version}" / f"{controller}.fmu"))
    rows = driven(made, unit.interface.inputs)
    shown = {kind: zeros(kind, n) for kind, n in widths(unit.interface.outputs).items()}
    columns = {kind: column.copy() for kind, column in rows[0].items()}
    shortest = [float("inf")] * len(rows)

    def begin():
        unit.reset()
        unit.bind(columns, shown)
        unit.enter_initialization(made.system.units["controller"].parameters)
        unit.exit_initialization()

    def one_pass():
        setters = unit.setters()
        for tick, row in enumerate(rows):
            for kind, column in row.items():
                columns[kind][:] = column
            for setter in setters:
                setter()
            before = perf_counter_ns()
            failed = unit.step(H * tick, H)
            shortest[tick] = min(shortest[tick], (perf_counter_ns() - before) / 1e3)
            assert not failed, unit.messages

    benchmark.pedantic(one_pass, setup=begin, rounds=PASSES, warmup_rounds=1)
    unit.close()
    typical = median(shortest)
    benchmark.extra_info |= {"budget": BUDGET, "median": f"{typical:.1f} us", "longest": f"{max(shortest):.1f} us"}
    benchmark.extra_info["over the shortest"] = [round(t / min(shortest), 2) for t in (typical, max(shortest))]
