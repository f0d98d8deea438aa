"""FMUs that do what they must not, in one function of FMI: chosen by a file inside, compiled once for each kind."""

from __future__ import annotations

import re
import subprocess
import tempfile
from collections.abc import Iterator
from functools import cache
from pathlib import Path

from fmus.toolchain.compiler import required_compiler
from fmus.toolchain.version import Version
from tests.fmus.foreign import (
    HEADERS,
    C,
    description2,
    description3,
    entries,
    functions,
    kept_folder,
    library,
    pack,
    scalar,
)
from tests.fmus.model_exchange_models import ball2, ball3
from tests.fmus.units.test_clocked_unit import CLOCKS
from tests.fmus.units.test_clocked_unit import made as metronome

OWN = Path(__file__).parent / "c"
TYPES2 = ("Real", "Integer", "Boolean", "String")
TYPES3 = (
    *("Float64", "Float32", "Int8", "UInt8", "Int16", "UInt16", "Int32", "UInt32", "Int64", "UInt64", "Boolean"),
    *("String", "Binary"),
)
_TYPEDEF = re.compile(r"typedef\s+([\w ]+?\*?)\s*(fmi\d\w+)TYPE\s*\(([^;]*)\)\s*;")
_STEPPING = re.compile(
    r"fmi\d([GS]et(?!FMU|up|Number|Debug|Types|Version|Time|Nominals)|DoStep|EnterEvent|EnterStep|UpdateD|NewD|EnterCont|Comp|SetTime)"
)
"""Functions whose deed begins at 0.25 s."""
_BEFORE = {
    "fmi2DoStep": "now_ = currentCommunicationPoint;",
    "fmi3DoStep": "now_ = currentCommunicationPoint;",
    "fmi2SetTime": "now_ = time;",
    "fmi3SetTime": "now_ = time;",
    "fmi2Instantiate": 'callbacks_ = functions; snprintf(name_, sizeof name_, "%s", instanceName);',
    "fmi3InstantiateCoSimulation": "log_ = logMessage; environment_ = instanceEnvironment;",
    "fmi3InstantiateModelExchange": "log_ = logMessage; environment_ = instanceEnvironment;",
}
_AFTER = {
    "fmi2GetReal": "for (size_t k = 0; k < nvr; k++) spoil_number(value + k);",
    "fmi3GetFloat64": "for (size_t k = 0; k < nValues; k++) spoil_number(values + k);",
    "fmi2GetString": "spoil_texts((const char **)value, nvr);",
    "fmi3GetString": "spoil_texts((const char **)values, nValues);",
    "fmi3GetBinary": "spoil_bytes(valueSizes, (const void **)values, nValues);",
    "fmi3DoStep": (
        "spoil_step((void *)eventHandlingNeeded, (void *)terminateSimulation, (void *)earlyReturn, lastSuccessfulTime,"
        " currentCommunicationPoint, communicationStepSize);"
    ),
    "fmi3UpdateDiscreteStates": 'if (does("for ever")) *discreteStatesNeedUpdate = 1;'
    ' if (does("next NaN")) { *nextEventTimeDefined = 1; *nextEventTime = NAN; }'
    ' if (does("next before")) { *nextEventTimeDefined = 1; *nextEventTime = -7; }',
    "fmi2NewDiscreteStates": 'if (does("for ever")) fmi2eventInfo->newDiscreteStatesNeeded = 1;'
    ' if (does("next NaN")) { fmi2eventInfo->nextEventTimeDefined = 1; fmi2eventInfo->nextEventTime = NAN; }'
    ' if (does("next before")) { fmi2eventInfo->nextEventTimeDefined = 1; fmi2eventInfo->nextEventTime = -7; }',
    "fmi3GetNumberOfContinuousStates": 'if (does("huge size")) *nContinuousStates = (size_t)-1;',
    "fmi3GetNumberOfEventIndicators": 'if (does("huge size")) *nEventIndicators = 1u << 30;',
    "fmi2GetDerivatives": "for (size_t k = 0; k < nx; k++) spoil_number(derivatives + k);",
    "fmi3GetContinuousStateDerivatives": "while (nContinuousStates--) spoil_number(derivatives + nContinuousStates);",
}
_LOGGING = {
    2: """static const fmi2CallbackFunctions *callbacks_; static char name_[256];
static void say(int status, const char *text) {
    if (!callbacks_) return;
    callbacks_->logger(callbacks_->componentEnvironment, name_, (fmi2Status)status, "logStatusError", text);
}
""",
    3: """static fmi3LogMessageCallback log_; static fmi3InstanceEnvironment environment_;
static void say(int status, const char *text) {
    if (log_) log_(environment_, (fmi3Status)status, "logStatusError", text);
}
""",
}
_VERSION_TEXTS = """if (due(name)) {
        if (does("wrong text")) return "99.0 \\033[31m";
        if (does("NULL text")) return NULL;
        done();
    }"""


def _declared(version: Version) -> Iterator[tuple[str, str, list[str]]]:
    """The result, the name and the parameters of every function of FMI."""
    text = (HEADERS / f"fmi{version}FunctionTypes.h").read_text("utf-8")
    for result, name, parameters in _TYPEDEF.findall(re.sub(r"/\*.*?\*/", "", text, flags=re.DOTALL)):
        given = [" ".join(p.split()) for p in parameters.split(",")]
        yield result, name, [] if given == ["void"] else [p.replace("fmi2Byte[]", "fmi2Byte state[]") for p in given]


def _wrapper(result: str, name: str, parameters: list[str]) -> str:
    """The function, which does its deed before or after the true one."""
    names = [re.findall(r"\w+", p.removesuffix("[]"))[-1] for p in parameters]
    head, call = f"{result} {{}}{name}({', '.join(parameters) or 'void'})", f"real_{name}({', '.join(names)})"
    if result == "const char*":
        return f'{head.format("")} {{ const char *name = "{name}"; {_VERSION_TEXTS} return "{name[3]}.0"; }}\n'
    lines = [f"{head.format('real_')};", f"{head.format('')} {{", f'    const char *name = "{name}";']
    lines += [f"    {_BEFORE[name]}"] if name in _BEFORE else []
    if result == "void":
        return "\n".join([*lines, "    if (due(name)) done();", f"    {call};", "}\n"])
    refusal = "return status" if result.endswith("Status") else "return NULL"
    lines += [f"    int status = due(name) ? done() : GO;\n    if (status != GO) {refusal};"]
    lines += [f"    {result} found = {call};"]
    lines += [f"    if (due(name)) {{ {_AFTER[name]} }}"] if name in _AFTER else []
    return "\n".join([*lines, "    return found;", "}\n"])


@cache
def _library(version: Version, source: str, *options: str) -> Path:
    folder = Path(tempfile.mkdtemp(dir=kept_folder()))
    wrappers = [_wrapper(*each) for each in _declared(version)]
    head = f'#include "fmi{version}FunctionTypes.h"\n#include "deeds.h"\n{_LOGGING[int(version)]}'
    (folder / "wrappers.c").write_text(head + "\n".join(wrappers))
    (folder / "stubs.c").write_text(
        "".join(f"__attribute__((weak)) int real_{n}() {{ return 0; }}\n" for n in functions(version))
    )
    renamed = "".join(f"#undef {n}\n#define {n} real_{n}\n" for n in functions(version))
    (folder / "model.c").write_text(f'#include "fmi{version}Functions.h"\n{renamed}{source}')
    flags = ["-O1", "-D_GNU_SOURCE", "-w", "-fPIC", "-shared", f"-I{HEADERS}", f"-I{C}", f"-I{OWN}", *options]
    files = [str(folder / name) for name in ("wrappers.c", "stubs.c", "model.c")]
    target = folder / "m.so"
    subprocess.run([*required_compiler().command, *flags, *files, "-o", str(target), "-lm", "-lpthread"], check=True)
    return target


def _echo2() -> str:
    variables, outputs = [], []
    for k, kind in enumerate(TYPES2, 1):
        start = {"of_start": {"String": "a", "Boolean": "false"}.get(kind, "1")}
        variables += [scalar(f"u{kind}", k, "input", kind, **start), scalar(f"y{kind}", k + 100, "output", kind)]
        outputs.append(f'<Unknown index="{2 * k}" dependencies=""/>')
    states = 'canGetAndSetFMUstate="true" canSerializeFMUstate="true"'
    return description2(variables, outputs, interface=f'<CoSimulation modelIdentifier="m" {states}/>')


def _echo3() -> str:
    variables, structure = [], []
    starts = {"String": '<Start value="a"/>', "Binary": '<Start value="00ff"/>'}
    for k, kind in enumerate(TYPES3, 1):
        start = "" if kind in starts else f' start="{"false" if kind == "Boolean" else 1}"'
        own = f'name="u{kind}" valueReference="{k}" causality="input"{start}'
        variables.append(f"<{kind} {own}>{starts.get(kind, '')}</{kind}>")
        variables.append(f'<{kind} name="y{kind}" valueReference="{k + 100}" causality="output"/>')
        structure.append(f'<Output valueReference="{k + 100}" dependencies=""/>')
    interface = '<CoSimulation modelIdentifier="m" canGetAndSetFMUState="true"/>'
    return description3(variables, structure, interface=interface)


def _metronome() -> str:
    made = metronome(kept_folder() / "metronome", CLOCKS)
    return entries(made)["modelDescription.xml"].decode()


_ME = '#define MODEL "ball.h"\n#include "me{}.c"'
_KINDS = {
    "2": (Version.FMI2, _echo2, '#include "echo2.c"'),
    "3": (Version.FMI3, _echo3, '#include "echo3.c"'),
    "clocked": (Version.FMI3, _metronome, (C / "clocked.c").read_text("utf-8")),
    "me2": (Version.FMI2, ball2, _ME.format(2)),
    "me3": (Version.FMI3, ball3, _ME.format(3)),
}


def lacking(version: Version, function: str, folder: Path) -> Path:
    """An FMU whose library lacks a function."""
    _, description, source = _KINDS[str(version)]
    renamed = f'#include "fmi{version}Functions.h"\n#undef {function}\n#define {function} other\n{source}'
    return pack(folder / "m.fmu", version, description(), library(folder, version, renamed, absent=[function]))


def faulty(kind: str, function: str, deed: str, folder: Path, **other: str) -> Path:
    """An FMU of a kind (see `_KINDS`) that does a deed in a function; `other` is text of its description, replaced."""
    version, description, source = _KINDS[kind]
    text = description()
    for old, new in other.items():
        text = text.replace(old, new)
    fault = f"{function}\n{deed}\n{int(bool(_STEPPING.match(function)))}\n"
    return pack(folder / "m.fmu", version, text, _library(version, source), resources__fault=fault)
