"""Faults of FMUs that run in this process, as far as it can stand them, and in that of a command, which is outlived."""

from __future__ import annotations

from functools import partial

from tests.faults.fmu_deeds import AT_THE_END, ENDS, FATAL, HARMLESS, STATUSES, put
from tests.faults.fmu_runs import command, run

_GROUP = "faults in process"
_HERE = partial(run, in_process=True)
_COMMAND = partial(command, place=("--in-process",))
_CHANGES = ("locale", "arithmetic", "folder", "lost folder", "permissions", "log many", "SIGCHLD", "SIGCONT", "warning")
_SAID = ("log many and fail", "log markup", "log escape", "log bad UTF-8", "log NULL", "log huge")
_SHORT = (
    *("fmi2DoStep: negative", "fmi3DoStep: status 99", "fmi3DoStep: folder", "fmi2DoStep: log huge"),
    *("fmi2EnterInitializationMode: fatal", "fmi3GetString: bad UTF-8", "fmi2Terminate: error"),
)
_TEXTS = {"NULL text": "gave no text for `yString`", "bad UTF-8": "not UTF-8"}

for version in "23":
    early, step = (f"fmi{version}EnterInitializationMode", f"fmi{version}ExitInitializationMode"), f"fmi{version}DoStep"
    kinds = ("Real", "String") if version == "2" else ("Float64", "String", "Binary")
    values = [f"fmi{version}{verb}{kind}" for verb in ("Get", "Set") for kind in kinds]
    put(_GROUP, version, early, STATUSES, 1, way=_HERE, short=_SHORT)
    put(_GROUP, version, (step, *values), STATUSES, 1, rows=3, way=_HERE, short=_SHORT)
    put(_GROUP, version, (f"fmi{version}Terminate",), STATUSES, 0, way=_HERE, short=_SHORT)
    put(_GROUP, version, (step,), {n: FATAL[n] for n in _SAID}, 1, rows=3, way=_HERE, short=_SHORT)
    put(_GROUP, version, (step,), {n: HARMLESS[n] for n in _CHANGES}, 0, way=_HERE, short=_SHORT)
    put(_GROUP, version, (f"fmi{version}GetString",), _TEXTS, 0, way=_HERE, short=_SHORT)
    put(_GROUP, version, (f"fmi{version}GetString",), {"huge text": "more than 1048576 bytes"}, 1, rows=3, way=_HERE)
    crashes = {n: s for n, s in ENDS.items() if n != "loop"}  # nobody waits for an answer here; a person ends it
    put(_GROUP, version, (step,), crashes, 1, way=_COMMAND, by="by the command")
    put(_GROUP, version, early[:1], crashes, 1, rows=-1, way=_COMMAND, by="by the command")  # no folder is there yet
    late = (f"fmi{version}FreeInstance", "destructor")
    assert all(map(AT_THE_END.fullmatch, late))
    put(_GROUP, version, late, dict.fromkeys(crashes), 0, rows=11, way=_COMMAND, by="by the command")
    others = ("close all", "handlers", "environment", "thread", "exit handler", "delete")
    put(_GROUP, version, (step,), dict.fromkeys(others), 0, rows=3, way=_COMMAND, by="by the command")
    # no file can be written any more: the process that is left completes the folder with the rows of half a second ago
    put(_GROUP, version, (step,), {"limits": "ticks are in"}, 1, way=_COMMAND, by="by the command")
put(
    _GROUP,
    "3",
    ("fmi3GetBinary",),
    {"NULL bytes": "no address of the 7 bytes", "huge size": "gave .* bytes"},
    1,
    rows=3,
    way=_HERE,
)
for kind, name in (("me2", "fmi2NewDiscreteStates"), ("me3", "fmi3UpdateDiscreteStates")):
    put(_GROUP, kind, (name,), STATUSES, 1, rows=1, way=_HERE)
