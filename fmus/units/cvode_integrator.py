"""CVODE around a Model Exchange FMU: one internal step at a time, never past a given instant, ending at state events.

FMPy brings SUNDIALS and a class around CVODE. The subclass here returns after each internal step, as an FMU has to be
notified of each, never passes a time event or a communication point, reports errors of the FMU, and frees its memory.
"""
# pyright: basic
# FMPy and ctypes carry few types; everything that leaves this file is annotated.

from __future__ import annotations

import ctypes
from ctypes import byref, c_double, c_void_p
from typing import Any, Final, Protocol

import numpy as np
from typing_extensions import override

from fmus.toolchain.fmpy_library import FMICallException, sundials

_ONE_STEP: Final = 2
_DISCARD: Final = 2
_AGAIN, _GIVE_UP = 1, -1
"""The results of a failed evaluation for CVODE: try a smaller step, or stop."""

_SUNDIALS: Final = sundials()
_set_stop_time = _SUNDIALS.cvode["CVodeSetStopTime"]
_set_stop_time.argtypes = [c_void_p, c_double]
_clear_handlers = _SUNDIALS.core["SUNContext_ClearErrHandlers"]
_clear_handlers.argtypes = [c_void_p]
_push_handler = _SUNDIALS.core["SUNContext_PushErrHandler"]
_free = {name: _SUNDIALS.core[name] for name in ("SUNMatDestroy", "SUNLinSolFree", "SUNContext_Free")}
for _function in _free.values():
    _function.argtypes = [c_void_p]


class ContinuousModel(Protocol):
    """What the integrator needs of an FMU in Continuous-Time Mode; the methods raise `FMICallException`.

    All arrays are pointers to `n` numbers in C.
    """

    n_states: int
    n_indicators: int

    def get_states(self, x: Any, n: int) -> None:
        """Read the continuous states."""

    def set_states(self, x: Any, n: int) -> None:
        """Set them."""

    def get_derivatives(self, dx: Any, n: int) -> None:
        """Evaluate their derivatives."""

    def get_indicators(self, z: Any, n: int) -> None:
        """Evaluate the event indicators."""

    def get_nominals(self, x: Any, n: int) -> None:
        """Read the nominal values of the states."""

    def set_time(self, t: float) -> None:
        """Set the time."""


class IntegrationError(RuntimeError):
    """An integration that cannot continue."""


class CvodeIntegrator(_SUNDIALS.CVodeSolver):
    """BDF of variable order and step; absolute tolerances are the relative one times the nominal values.

    Args:
        model: The FMU.
        time: The present time [s].
        tolerance: Relative tolerance [1].
    """

    def __init__(self, model: ContinuousModel, time: float, tolerance: float) -> None:
        self._failure: FMICallException | None = None
        super().__init__(
            nx=model.n_states,
            nz=model.n_indicators,
            get_x=model.get_states,
            set_x=model.set_states,
            get_dx=model.get_derivatives,
            get_z=model.get_indicators,
            get_nominals=model.get_nominals,
            set_time=model.set_time,
            input=None,
            startTime=time,
            relativeTolerance=tolerance,
        )
        _clear_handlers(self.sunctx)  # the first of them writes to the terminal
        _push_handler(self.sunctx, self.ehfun_, None)

    @override
    def f(self, t: float, y: Any, ydot: Any, user_data: Any) -> int:
        status = self._evaluated(lambda: _SUNDIALS.CVodeSolver.f(self, t, y, ydot, user_data))
        finite = np.isfinite(np.ctypeslib.as_array(_SUNDIALS.NV_DATA_S(ydot), (self.nx,))).all()
        return status or (0 if finite else _AGAIN)

    @override
    def g(self, t: float, y: Any, gout: Any, user_data: Any) -> int:
        def evaluate() -> None:
            self.set_time(t)
            if not self.discrete:
                self.set_x(_SUNDIALS.NV_DATA_S(y), self.nx)
            self.get_z(gout, self.nz)

        return self._evaluated(evaluate)

    def _evaluated(self, evaluate: Any) -> int:
        """An exception must not leave a function that C calls."""
        try:
            evaluate()
        except FMICallException as error:
            self._failure = error
            return _AGAIN if error.status == _DISCARD else _GIVE_UP
        return 0

    def advance(self, target: float) -> tuple[float, bool]:
        """Make one internal step towards `target` [s], after which the FMU is at the time reached with its states.

        Returns:
            The time that was reached [s], and whether there is a state event.

        Raises:
            IntegrationError: CVODE cannot continue.
        """
        self._failure, self.error_info = None, None
        reached = c_double()
        _set_stop_time(self.cvode_mem, target)
        flag = _SUNDIALS.CVode(self.cvode_mem, target, self.x, byref(reached), _ONE_STEP)
        if flag < 0:
            reason = self.error_info[3] if self.error_info else f"status {flag}"
            if self._failure is not None:
                reason = f"{reason} ({self._failure})"
            raise IntegrationError(f"CVODE cannot go on at {reached.value:g} s: {' '.join(reason.split())}")
        self.set_time(reached.value)
        if not self.discrete:
            self.set_x(self.px, self.nx)
        return reached.value, flag == _SUNDIALS.CV_ROOT_RETURN

    def close(self) -> None:
        """Free all memory; nothing may be called afterwards."""
        if self.cvode_mem is None:
            return
        super().__del__()
        self.cvode_mem = None
        _free["SUNLinSolFree"](self.LS)
        _free["SUNMatDestroy"](self.A)
        for vector in (self.x, self.abstol):
            _SUNDIALS.N_VDestroy_Serial(vector)
        _free["SUNContext_Free"](ctypes.addressof(self.sunctx))

    @override
    def __del__(self) -> None:
        """Nothing is left to free: `close` has done it."""
