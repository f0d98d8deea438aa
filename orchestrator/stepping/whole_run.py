"""A run in one call."""

from __future__ import annotations

from typing import TYPE_CHECKING

from components.interfaces.arguments import checked_arguments
from orchestrator.stepping.master import Simulation
from orchestrator.system.experiment import Algorithm, Scenario
from orchestrator.system.system import System

if TYPE_CHECKING:  # slow to import
    import pandas as pd


@checked_arguments
def simulate(  # noqa: PLR0913 - what makes an experiment
    system: System,
    *,
    h: float,
    until: float,
    start: float = 0.0,
    algorithm: str = Algorithm.SEQUENTIAL,
    solve_loops: bool = False,
) -> pd.DataFrame:
    """Run a system from its start time to its stop time.

    Args:
        system: The system.
        h: The macro step [s].
        until: The stop time [s], a whole number of macro steps after the start time.
        start: The start time [s].
        algorithm: How the units exchange data: `sequential` (no hidden delay), `jacobi` or `clocked`.
        solve_loops: Whether algebraic loops are solved by iteration instead of being refused.

    Returns:
        A row per tick: column `time` [s], then one per signal element, such as `plant.state.x`.

    Raises:
        RequestError: The system cannot be run like this: an algebraic loop, an unknown algorithm, a wrong time.
        SimulationError: A unit failed, or a value is not finite.
    """
    with Simulation(system, h=h, until=until, start=start, algorithm=algorithm, solve_loops=solve_loops) as simulation:
        simulation.run()
        return simulation.frame()


def simulation_of(scenario: Scenario) -> Simulation:
    """The simulation of a scenario, which is not opened yet."""
    return Simulation(
        scenario.system,
        h=scenario.h,
        until=scenario.until,
        start=scenario.start,
        tolerance=scenario.tolerance,
        record=scenario.record,
        algorithm=scenario.algorithm,
        solve_loops=scenario.solve_loops,
    )
