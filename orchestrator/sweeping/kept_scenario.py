"""A scenario that is loaded once, and whose settings then change from run to run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from components.interfaces.problem import raise_if_any
from components.interfaces.record import variables
from orchestrator.scenario.resolution import Setting, resolve
from orchestrator.scenario.settings import parse_settings
from orchestrator.stepping.simulation_pool import SimulationPool
from orchestrator.stepping.whole_run import simulation_of
from orchestrator.system.experiment import Scenario
from orchestrator.system.files import Given
from orchestrator.system.named_variables import named
from orchestrator.system.scene import Scene
from orchestrator.system.source import UnitSource


class KeptScenario:
    """A scenario whose simulations stay open, for many runs with other values.

    Args:
        scenario: The scenario.
    """

    def __init__(self, scenario: Scenario) -> None:
        self.scenario = scenario
        self.pool = SimulationPool(lambda: simulation_of(scenario))
        """Its simulations."""
        self._known = {
            name: named(source.interface.parameters)
            for name, source in scenario.system.units.items()
            if source.mapping_text() is None
        }

    def changes(self, texts: Sequence[str]) -> tuple[dict[str, Any], Scene | None] | None:
        """The values that settings change, by full path, and the scene.

        Args:
            texts: The settings, as `--set` takes them.

        Returns:
            None where a setting is more than another value of a parameter: of a unit that is mapped, a start value, or
            a length.

        Raises:
            RequestError: A setting does not fit.
        """
        values: dict[str, Any] = {}
        scene = self.scenario.scene
        for unit, settings in parse_settings(texts, any_unit=True).items():
            if not settings:
                continue
            if unit == "scene" and unit not in self.scenario.system.units:
                resolution = resolve(unit, variables(Scene), settings=settings)
                raise_if_any(resolution.problems)
                scene = replace(scene, **resolution.values) if scene is not None else None
                continue
            source, known = self.scenario.system.units[unit], self._known.get(unit)
            if known is None or not all(_is_plain(setting, source, known) for setting in settings):
                return None
            resolution = resolve(
                unit, source.interface.parameters, given=self._given(unit, settings), settings=settings
            )
            raise_if_any(resolution.problems)
            values |= {f"{unit}.{name}": value for name, value in resolution.values.items()}
        return values, scene

    def _given(self, unit: str, settings: Sequence[Setting]) -> dict[str, Given]:
        """The values before, of arrays of which a setting changes a part."""
        given: dict[str, Given] = {}
        for setting in settings:
            if meant := setting.means(self._known[unit]):
                name = meant[0].variable.name
                told = self.scenario.sources.get(f"{unit}.{name}")
                if told is not None and meant[0].variable.shape:
                    given[name] = Given(**told)
        return given


def _is_plain(setting: Setting, source: UnitSource, known: Mapping[str, Any]) -> bool:
    """Whether a setting is another value of a parameter, and no more."""
    meant = setting.means(known)
    return meant is not None and meant[0].variable.name not in source.structural
