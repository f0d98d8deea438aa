"""Systems and scenarios, their simulation, and what becomes of a run.

The public names are imported when they are first used: `import orchestrator` itself loads nothing else.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from components.interfaces.facade import facade

if TYPE_CHECKING:
    from components.interfaces.conversion import Linear
    from components.interfaces.problem import RequestError
    from components.interfaces.progress import SILENT, Progress
    from orchestrator.loading import load
    from orchestrator.results import metrics
    from orchestrator.run import Execution, Finished, execute
    from orchestrator.scenario.options import Options
    from orchestrator.stepping.master import Simulation, SimulationError, simulate
    from orchestrator.system.experiment import Algorithm, Scenario
    from orchestrator.system.shown import shown
    from orchestrator.system.source import Fmu, block_source
    from orchestrator.system.system import System

__all__ = [
    "SILENT",
    "Algorithm",
    "Execution",
    "Finished",
    "Fmu",
    "Linear",
    "Options",
    "Progress",
    "RequestError",
    "Scenario",
    "Simulation",
    "SimulationError",
    "System",
    "block_source",
    "execute",
    "load",
    "metrics",
    "shown",
    "simulate",
]

__getattr__, __dir__ = facade(
    __name__,
    {
        "components.interfaces.conversion": ("Linear",),
        "components.interfaces.problem": ("RequestError",),
        "components.interfaces.progress": ("SILENT", "Progress"),
        "orchestrator.loading": ("load",),
        "orchestrator.results": ("metrics",),
        "orchestrator.run": ("Execution", "Finished", "execute"),
        "orchestrator.scenario.options": ("Options",),
        "orchestrator.stepping.master": ("Simulation", "SimulationError", "simulate"),
        "orchestrator.system.experiment": ("Algorithm", "Scenario"),
        "orchestrator.system.shown": ("shown",),
        "orchestrator.system.source": ("Fmu", "block_source"),
        "orchestrator.system.system": ("System",),
    },
)
