"""Model Exchange FMUs of FMI 1.0."""
# pyright: basic
# FMPy carries few types; everything that leaves this file is annotated.

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from typing_extensions import override

from fmus.units.fmi1_unit import Fmi1Unit
from fmus.units.model_exchange import ModelExchangeUnit
from fmus.units.unit import ExperimentSetup, Unit, UnitError


class Model1Unit(ModelExchangeUnit, Fmi1Unit):
    """An FMI 1.0 Model Exchange FMU, which has no modes: an event is one call that updates everything."""

    _initial_event: tuple[bool, bool, bool, bool, bool, float] | None = None

    @override
    def _enter(self, parameters: Mapping[str, Any], setup: ExperimentSetup) -> None:
        self._check("the time was refused", self._fmu.setTime, setup.start)
        super()._enter(parameters, setup)

    @override
    def _initialize(self) -> None:
        tolerance = self._told.tolerance
        arguments = (b"\x00", 0.0) if tolerance is None else (b"\x01", tolerance)
        self._initial_event = self._check("the initialization failed", self._fmu.initialize, *arguments)

    @override
    def _tell_stop(self, failure: UnitError) -> None:
        raise failure

    @override
    def reset(self) -> None:
        Unit.reset(self)  # FMI 1.0 has a reset for Co-Simulation only

    @override
    def _new_discrete_states(self) -> tuple[bool, bool, bool, bool, bool, float]:
        event, self._initial_event = self._initial_event or self._fmu.eventUpdate(), None
        converged, _, states_changed, terminate, defined, following = event
        return not converged, terminate, False, states_changed, defined, following

    @override
    def get_derivatives(self, dx: Any, n: int) -> None:
        self._fmu.getDerivatives(dx, n)

    @override
    def get_nominals(self, x: Any, n: int) -> None:
        self._fmu.getNominalContinuousStates(x, n)

    @override
    def _count(self) -> tuple[int, int]:
        description = self._archive.description
        return description.numberOfContinuousStates, description.numberOfEventIndicators

    @override
    def _completed_step(self) -> bool:
        return bool(self._fmu.completedIntegratorStep())

    @override
    def _free_instance(self) -> None:
        self._fmu.fmi1FreeModelInstance(self._fmu.component)
