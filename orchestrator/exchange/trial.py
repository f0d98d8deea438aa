"""A trial of an FMU, before anybody relies on it: all that a run does, up to the end of its first step."""

from __future__ import annotations

from dataclasses import dataclass

from components.interfaces.problem import Problem, RequestError
from components.interfaces.progress import SILENT, Progress
from orchestrator.scenario.options import Options
from orchestrator.scenario.single_fmu import single_fmu
from orchestrator.stepping.master import Simulation, SimulationError
from orchestrator.system.source import Fmu


@dataclass(frozen=True)
class Trial:
    """How far an FMU came."""

    reached: str
    """What it can or cannot do here, as the end of a sentence."""
    problems: tuple[Problem, ...] = ()
    remarks: tuple[str, ...] = ()
    """What a run would tell of it."""


def try_first_step(fmu: Fmu, progress: Progress = SILENT, *, lenient: bool) -> Trial:
    """Open an FMU in a process of its own, because a faulty one may crash; initialise it, and step once.

    Args:
        fmu: The FMU, without values.
        progress: Is told before sources of the FMU are compiled.
        lenient: Whether broken rules of FMI are overlooked that do not keep it from running.
    """
    stepped = False
    try:
        # the stop time of the file, if it has one, is of no interest: the trial ends after a step
        scenario = single_fmu(fmu, {}, Options(lenient=lenient, isolate=["fmu"], stop_time=0.0))
        for source in scenario.system.units.values():
            source.make_ready(progress)
        simulation = Simulation(scenario.system, h=scenario.h, until=scenario.start + scenario.h, start=scenario.start)
        with simulation:
            stepped = True
            simulation.run()
    except RequestError as error:
        return Trial("cannot be instantiated here", error.problems)
    except SimulationError as fault:
        reached = "can be instantiated here, and cannot step" if stepped else "cannot be started here"
        found = f"an FMU {'whose first step fails' if stepped else 'that cannot be started'} ({fault.reason})"
        problem = Problem(fmu.named_as, found, "one that can be run", "Ask its maker for another.")
        return Trial(reached, (problem,))
    return Trial(f"can be instantiated here, and takes a step of {scenario.h:g} s", (), tuple(simulation.remarks))
