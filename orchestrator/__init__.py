"""Systems and scenarios, their simulation, and what becomes of a run.

The public names are imported when they are first used: `import orchestrator` itself loads nothing else.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from components.interfaces.facade import facade

if TYPE_CHECKING:
    from components.interfaces.conversion import Linear, Lookup
    from components.interfaces.problem import RequestError
    from components.interfaces.progress import SILENT, Progress
    from fmus.toolchain.compiler import BuildError
    from orchestrator.execution import Execution, Finished, execute
    from orchestrator.loading import load
    from orchestrator.mapping.mapped import mapped
    from orchestrator.mapping.mapping_reader import read_mapping
    from orchestrator.own_system import run
    from orchestrator.results import metrics
    from orchestrator.scenario.options import Options
    from orchestrator.stepping.master import Simulation, SimulationError
    from orchestrator.stepping.simulation_pool import SimulationPool
    from orchestrator.stepping.snapshot import Snapshot
    from orchestrator.stepping.whole_run import simulate
    from orchestrator.sweeping.sweep import sweep
    from orchestrator.system.experiment import Algorithm, Scenario
    from orchestrator.system.scene import Scene
    from orchestrator.system.shown import shown
    from orchestrator.system.source import Fmu, block_source
    from orchestrator.system.system import System

__all__ = [
    "SILENT",
    "Algorithm",
    "BuildError",
    "Execution",
    "Finished",
    "Fmu",
    "Linear",
    "Lookup",
    "Options",
    "Progress",
    "RequestError",
    "Scenario",
    "Scene",
    "Simulation",
    "SimulationError",
    "SimulationPool",
    "Snapshot",
    "System",
    "block_source",
    "execute",
    "load",
    "mapped",
    "metrics",
    "read_mapping",
    "run",
    "shown",
    "simulate",
    "sweep",
]

__getattr__, __dir__ = facade(
    __name__,
    {
        "components.interfaces.conversion": ("Linear", "Lookup"),
        "components.interfaces.problem": ("RequestError",),
        "components.interfaces.progress": ("SILENT", "Progress"),
        "fmus.toolchain.compiler": ("BuildError",),
        "orchestrator.loading": ("load",),
        "orchestrator.mapping.mapped": ("mapped",),
        "orchestrator.mapping.mapping_reader": ("read_mapping",),
        "orchestrator.results": ("metrics",),
        "orchestrator.execution": ("Execution", "Finished", "execute"),
        "orchestrator.own_system": ("run",),
        "orchestrator.scenario.options": ("Options",),
        "orchestrator.stepping.master": ("Simulation", "SimulationError"),
        "orchestrator.stepping.simulation_pool": ("SimulationPool",),
        "orchestrator.stepping.snapshot": ("Snapshot",),
        "orchestrator.stepping.whole_run": ("simulate",),
        "orchestrator.sweeping.sweep": ("sweep",),
        "orchestrator.system.experiment": ("Algorithm", "Scenario"),
        "orchestrator.system.scene": ("Scene",),
        "orchestrator.system.shown": ("shown",),
        "orchestrator.system.source": ("Fmu", "block_source"),
        "orchestrator.system.system": ("System",),
    },
)
