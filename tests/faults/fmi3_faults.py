"""Faults in the functions of FMI 3.0, in a process of its own, which the run survives."""

from __future__ import annotations

from fmus.toolchain.version import Version
from tests.faults.faulty_fmus import TYPES3
from tests.faults.fmu_deeds import ENDS, FATAL, HARMLESS, STATUSES, put, put_random, put_refused, put_states
from tests.faults.fmu_runs import command

_GROUP = "FMI 3.0 faults"
_EARLY = ("fmi3InstantiateCoSimulation", "fmi3EnterInitializationMode", "fmi3ExitInitializationMode")
_MODEL = (
    *("fmi3SetTime", "fmi3SetContinuousStates", "fmi3GetContinuousStates", "fmi3GetContinuousStateDerivatives"),
    *("fmi3GetEventIndicators", "fmi3EnterEventMode", "fmi3UpdateDiscreteStates", "fmi3EnterContinuousTimeMode"),
)
_CLOCKED = ("fmi3EnterEventMode", "fmi3EnterStepMode", "fmi3UpdateDiscreteStates", "fmi3SetClock", "fmi3GetClock")
_LATE = ("fmi3Terminate", "fmi3FreeInstance")
_STEP = {
    "early": "returned early",
    "early without a move": "returned early",
    "early before": "it returned early, and says that it has reached",
    "early after": "it returned early, and says that it has reached",
    "early NaN": "it returned early, and says that it has reached nan s",
}
_TOLD = {
    "last before": "it says that it has reached",
    "last after": "it says that it has reached",
    "last NaN": "it says that it has reached nan s in .*|has reached nan s",
    "event": "asks for Event Mode",
    "warning": "returned a warning",
}
_BYTES = {"NULL bytes": "no address of the 7 bytes", "huge size": r"gave \d+ bytes", "wrong size": "SIGSEGV"}
_SHORT = (
    "fmi3InstantiateCoSimulation: exit 0",
    "fmi3SetBinary: abort",
    "fmi3DoStep: status 99",
    "fmi3GetBinary: huge size",
)

put(_GROUP, "3", ("constructor", *_EARLY), ENDS, 1, short=_SHORT)
put(_GROUP, "3", _EARLY[1:], STATUSES, 1)
put(_GROUP, "3", _EARLY[:1], dict.fromkeys(STATUSES, "refuses to make an instance"), 2)
put(_GROUP, "3", _EARLY[1:], {"warning": "returned a warning"}, 0)
put(_GROUP, "3", ("fmi3DoStep",), ENDS | STATUSES, 1, rows=3, short=_SHORT)
put(_GROUP, "3", ("fmi3GetFloat64", "fmi3GetString", "fmi3GetBinary"), ENDS | STATUSES, 1, rows=3, short=_SHORT)
put(_GROUP, "3", ("fmi3SetFloat64", "fmi3SetString", "fmi3SetBinary"), ENDS | STATUSES, 1, rows=3, short=_SHORT)
put_random(_GROUP, "3", [f"fmi3{verb}{kind}" for kind in TYPES3[1:11] for verb in ("Get", "Set")], 3)
put(_GROUP, "3", (*_LATE, "destructor"), ENDS, 0, short=("fmi3FreeInstance: loop", "destructor: segv"))
put(_GROUP, "3", _LATE[:1], STATUSES, 0)
put(_GROUP, "3", ("fmi3DoStep",), FATAL, 1, rows=3, short=["fmi3DoStep: log huge", "fmi3DoStep: fork and die"])
put(
    _GROUP, "3", ("fmi3DoStep",), HARMLESS, 0, short=["fmi3DoStep: shorten", "fmi3DoStep: fork 64", "fmi3DoStep: print"]
)
put(
    _GROUP,
    "3",
    ("fmi3DoStep",),
    {n: s for n, s in _STEP.items() if n.startswith("early")},
    1,
    rows=3,
    short=["fmi3DoStep: early NaN"],
)
put(_GROUP, "3", ("fmi3DoStep",), dict.fromkeys(("flags", "terminate", "terminate NaN")), 1, rows=3)
put(_GROUP, "3", ("fmi3DoStep",), _TOLD, 0, short=["fmi3DoStep: last NaN"])
put(_GROUP, "3", ("fmi3GetFloat64",), {"NaN": "is not finite|nan", "infinity": "is not finite|inf"}, 0)
put(_GROUP, "3", ("fmi3GetString",), {"NULL text": "gave no text for `yString`", "bad UTF-8": "not UTF-8"}, 0)
put(_GROUP, "3", ("fmi3GetString",), {"huge text": "more than 1048576 bytes", "wild text": "SIGSEGV"}, 1, rows=3)
put(_GROUP, "3", ("fmi3GetBinary",), _BYTES, 1, rows=3, short=_SHORT)
put(_GROUP, "3", ("fmi3GetBinary",), {"no bytes": "", "other bytes": ""}, 0)
put(_GROUP, "3", ("fmi3GetVersion",), {"wrong text": "", "NULL text": None, "segv": None}, 0)
put(_GROUP, "me3", _MODEL, ENDS, 1, rows=1)
put(_GROUP, "me3", _MODEL, {n: STATUSES[n] for n in ("error", "fatal", "negative", "status 99")}, 1, rows=1)
put(
    _GROUP,
    "me3",
    ("fmi3UpdateDiscreteStates",),
    {"for ever": "does not settle", "next NaN": "", "next before": ""},
    1,
    rows=1,
)
put(_GROUP, "me3", ("fmi3GetContinuousStateDerivatives",), {"NaN": "", "infinity": ""}, 1, rows=1)
put(_GROUP, "me3", ("fmi3GetNumberOfContinuousStates", "fmi3GetNumberOfEventIndicators"), {"huge size": ""}, 1)
put(_GROUP, "clocked", _CLOCKED, ENDS | {n: STATUSES[n] for n in ("error", "negative", "status 99")}, 1, rows=1)
put(_GROUP, "clocked", ("fmi3UpdateDiscreteStates",), {"for ever": "do not come to rest"}, 1, rows=1)
_MOVES = {"early without a move": "without having moved"}
_MOVES |= dict.fromkeys(("early before", "early after", "early NaN", "terminate NaN"), "it says that it has reached")
put(_GROUP, "clocked", ("fmi3DoStep",), _MOVES, 1, rows=1)
put(_GROUP, "clocked", ("fmi3DoStep",), {"early": "", "flags": ""}, 0)
put(
    _GROUP,
    "3",
    ("fmi3DoStep",),
    {n: ENDS[n] for n in ("segv", "exit 0", "loop")},
    1,
    rows=3,
    way=command,
    by="by the command",
    short=["fmi3DoStep: segv"],
)
put_states(_GROUP, "3", ("fmi3GetFMUState", "fmi3SetFMUState", "fmi3FreeFMUState"))
put_refused(_GROUP, Version.FMI3)
