"""Faults in the functions of FMI 2.0, in a process of its own, which the run survives."""

from __future__ import annotations

from fmus.toolchain.version import Version
from tests.faults.faulty_fmus import TYPES2
from tests.faults.fmu_deeds import ENDS, FATAL, HARMLESS, STATUSES, put, put_refused, put_states
from tests.faults.fmu_runs import command

_GROUP = "FMI 2.0 faults"
_EARLY = ("fmi2Instantiate", "fmi2SetupExperiment", "fmi2EnterInitializationMode", "fmi2ExitInitializationMode")
_STEPPING = ("fmi2DoStep", *(f"fmi2Get{kind}" for kind in TYPES2))
_MODEL = (
    *("fmi2SetTime", "fmi2SetContinuousStates", "fmi2GetContinuousStates", "fmi2GetDerivatives"),
    *("fmi2GetEventIndicators", "fmi2EnterEventMode", "fmi2NewDiscreteStates", "fmi2EnterContinuousTimeMode"),
)
_LATE = ("fmi2Terminate", "fmi2FreeInstance")
_WARNED = {"warning": "returned a warning"}
_SHORT = ("fmi2Instantiate: loop", "fmi2GetReal: segv", "fmi2DoStep: exit 0", "fmi2DoStep: negative")
_SHORT_DEEDS = ("fork and kill", "log escape", "log many and fail", "close all", "delete", "kill parent", "warning")

put(_GROUP, "2", ("constructor", *_EARLY), ENDS, 1, short=_SHORT)
put(_GROUP, "2", _EARLY[1:], STATUSES, 1)
put(_GROUP, "2", _EARLY[:1], dict.fromkeys(STATUSES, "refuses to make an instance"), 2)
put(_GROUP, "2", _EARLY[1:], _WARNED, 0)
put(_GROUP, "2", _STEPPING, ENDS | STATUSES, 1, rows=3, short=_SHORT)
put(_GROUP, "2", _STEPPING[1:], _WARNED, 0)
put(_GROUP, "2", [f"fmi2Set{kind}" for kind in TYPES2], ENDS | STATUSES, 1, rows=3)
put(_GROUP, "2", (*_LATE, "destructor"), ENDS, 0, short=("fmi2FreeInstance: segv", "fmi2Terminate: loop"))
put(_GROUP, "2", _LATE[:1], STATUSES, 0)
put(_GROUP, "2", ("fmi2DoStep",), FATAL, 1, rows=3, short=[f"fmi2DoStep: {deed}" for deed in _SHORT_DEEDS])
put(_GROUP, "2", ("fmi2DoStep",), HARMLESS, 0, short=[f"fmi2DoStep: {deed}" for deed in _SHORT_DEEDS])
put(_GROUP, "2", ("fmi2GetReal",), {"NaN": "is not finite|nan", "infinity": "is not finite|inf"}, 0)
put(_GROUP, "2", ("fmi2GetString",), {"NULL text": "gave no text for `yString`", "bad UTF-8": "not UTF-8"}, 0)
put(_GROUP, "2", ("fmi2GetString",), {"huge text": "more than 1048576 bytes", "wild text": "SIGSEGV"}, 1, rows=3)
put(_GROUP, "2", ("fmi2GetVersion",), {"wrong text": "", "NULL text": None, "segv": None}, 0)
put(_GROUP, "me2", _MODEL, ENDS, 1, rows=1)
put(_GROUP, "me2", _MODEL, {n: STATUSES[n] for n in ("error", "fatal", "negative", "status 99")}, 1, rows=1)
put(
    _GROUP,
    "me2",
    ("fmi2NewDiscreteStates",),
    {"for ever": "does not settle", "next NaN": "", "next before": ""},
    1,
    rows=1,
)
put(_GROUP, "me2", ("fmi2GetDerivatives",), {"NaN": "", "infinity": ""}, 1, rows=1)
put(
    _GROUP,
    "2",
    ("fmi2DoStep",),
    {n: ENDS[n] for n in ("segv", "exit 0", "loop")},
    1,
    rows=3,
    way=command,
    by="by the command",
    short=["fmi2DoStep: exit 0"],
)
put(
    _GROUP,
    "2",
    ("fmi2DoStep",),
    {n: FATAL[n] for n in ("kill group", "log markup", "log escape")},
    1,
    rows=3,
    way=command,
    by="by the command",
    short=["fmi2DoStep: log escape"],
)
put_states(_GROUP, "2", ("fmi2GetFMUstate", "fmi2SetFMUstate", "fmi2FreeFMUstate"))
put_refused(_GROUP, Version.FMI2)
