"""The equals of the Reference FMUs, in our own C: the same variables, flags, default experiments and numbers.

Their equations stand in `c/models`. Each is made for Co-Simulation, Model Exchange or both, in FMI 2.0 and 3.0.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

from fmus.toolchain.version import Version
from tests.fmus.foreign import description2, description3, kept_folder, library, pack

GUID = "{1d2b6c9e-3a57-4c0e-9a63-2f6c6f0a8e11}"
EXACT = "-ffp-contract=off"
"""The compiler must round after each operation, as Python does."""
_TYPES2 = {
    "Float64": "Real",
    "Int32": "Integer",
    "Boolean": "Boolean",
    "String": "String",
    "Enumeration": "Enumeration",
}
_OF_VARIABLE = ("causality", "variability", "initial", "description")
_CATEGORIES = (
    '<LogCategories><Category name="logEvents" description="Log events"/>'
    '<Category name="logStatusError" description="Log error messages"/></LogCategories>'
)


@dataclass(frozen=True)
class Declared:
    """A variable, with its attributes as in FMI 3.0 and what is inside its element there."""

    name: str
    reference: int
    kind: str
    attributes: Mapping[str, str]
    inside: str = ""

    def in_fmi3(self) -> str:
        """Its element in FMI 3.0."""
        head = f'{self.kind} name="{self.name}" valueReference="{self.reference}" {_text(self.attributes)}'
        return f"<{head}>{self.inside}</{self.kind}>"

    def in_fmi2(self, index: Mapping[int, int]) -> str:
        """Its element in FMI 2.0, where variables are known by `index` as well."""
        own = {n: v for n, v in self.attributes.items() if n in _OF_VARIABLE}
        of = {n: v for n, v in self.attributes.items() if n not in (*_OF_VARIABLE, "intermediateUpdate")}
        if "derivative" in of:
            of["derivative"] = str(index[int(of["derivative"])])
        if self.kind != "Float64":
            own.setdefault("variability", "discrete")
        if self.kind == "String" and self.inside:
            of["start"] = "Set me!"
        head = f'name="{self.name}" valueReference="{self.reference}" {_text(own)}'
        return f"<ScalarVariable {head}><{_TYPES2[self.kind]} {_text(of)}/></ScalarVariable>"


@dataclass(frozen=True)
class ReferenceModel:
    """What the description of a model says; dependencies are value references, or None where none are listed."""

    variables: tuple[Declared, ...]
    experiment: str
    internal_step: str
    outputs: Mapping[int, str | None]
    derivatives: Mapping[int, str | None] = field(default_factory=dict[int, "str | None"])
    initials: Mapping[int, str | None] = field(default_factory=dict[int, "str | None"])
    indicators: tuple[int, ...] = ()
    attributes: str = ""
    """Attributes of both interface types."""
    co_simulation: str = ""
    """Attributes of FMI 3.0 Co-Simulation alone."""
    types: Mapping[Version, str] = field(default_factory=dict[Version, str])
    """The elements for units and types."""

    def in_fmi3(self, *interfaces: str) -> str:
        """The description of FMI 3.0."""
        state = f'canGetAndSetFMUState="true" canSerializeFMUState="true" {self.attributes}'
        common = (
            'canHandleVariableCommunicationStepSize="true" providesIntermediateUpdate="true"'
            f' canReturnEarlyAfterIntermediateUpdate="true" fixedInternalStepSize="{self.internal_step}"'
        )
        own = {"ModelExchange": state, "CoSimulation": f"{state} {common} {self.co_simulation}"}
        structure = _unknowns("Output", "valueReference", self.outputs)
        structure += _unknowns("ContinuousStateDerivative", "valueReference", self.derivatives)
        structure += _unknowns("InitialUnknown", "valueReference", self.initials)
        structure += [f'<EventIndicator valueReference="{i}"/>' for i in self.indicators]
        return description3(
            [v.in_fmi3() for v in self.variables],
            structure,
            interface="".join(f'<{name} modelIdentifier="m" {own[name]}/>' for name in interfaces),
            guid=GUID,
            before=self._before(Version.FMI3),
        )

    def in_fmi2(self, *interfaces: str) -> str:
        """The description of FMI 2.0, with the variables that it can express."""
        variables = [v for v in self.variables if v.kind in _TYPES2]
        index = {v.reference: i for i, v in enumerate(variables, 2)}
        state = 'canNotUseMemoryManagementFunctions="true" canGetAndSetFMUstate="true" canSerializeFMUstate="true"'
        own = {
            "ModelExchange": state,
            "CoSimulation": f'canHandleVariableCommunicationStepSize="true" {state}',
        }
        time = '<ScalarVariable name="time" valueReference="0" causality="independent" variability="continuous">'
        parts = [_unknowns("Unknown", "index", _by_index(of, index)) for of in (self.outputs, self.derivatives)]
        return description2(
            [f"{time}<Real/></ScalarVariable>", *(v.in_fmi2(index) for v in variables)],
            parts[0],
            interface="".join(f'<{name} modelIdentifier="m" {own[name]}/>' for name in interfaces),
            guid=GUID,
            attributes=f'numberOfEventIndicators="{len(self.indicators)}"',
            before=self._before(Version.FMI2),
            derivatives=parts[1],
            initial=_unknowns("Unknown", "index", _by_index(self.initials, index)),
        )

    def _before(self, version: Version) -> str:
        return f"{self.types.get(version, '')}{_CATEGORIES}<DefaultExperiment {self.experiment}/>"


def _text(attributes: Mapping[str, str]) -> str:
    return " ".join(f'{name}="{value}"' for name, value in attributes.items())


def _unknowns(element: str, attribute: str, of: Mapping[int, str | None]) -> list[str]:
    return [
        f'<{element} {attribute}="{known}"' + ("/>" if needs is None else f' dependencies="{needs}"/>')
        for known, needs in of.items()
    ]


def _by_index(of: Mapping[int, str | None], index: Mapping[int, int]) -> dict[int, str | None]:
    return {
        index[known]: None if needs is None else " ".join(str(index[int(i)]) for i in needs.split())
        for known, needs in of.items()
        if known in index
    }


def _real(name: str, reference: int, causality: str, start: str = "", **more: str) -> Declared:
    attributes = {"causality": causality, "variability": "continuous", "initial": "exact" if start else "calculated"}
    inside = more.pop("inside", "")
    return Declared(name, reference, "Float64", attributes | more | ({"start": start} if start else {}), inside)


def _parameter(name: str, reference: int, start: str, variability: str = "fixed", **more: str) -> Declared:
    return _real(name, reference, "parameter", start, variability=variability, **more)


def _pair(reference: int, name: str) -> tuple[Declared, Declared]:
    """An input and the output that shows it."""
    kind, _, variability = name.partition("_")
    common = {"declaredType": "Option"} if kind == "Enumeration" else {}
    common |= {"variability": variability} if variability == "discrete" else {}
    start = {"Boolean": "false", "Enumeration": "1"}.get(kind, "0")
    inside = {"String": '<Start value="Set me!"/>', "Binary": '<Start value="666f6f"/>'}.get(kind, "")
    given = {} if inside else {"start": start}
    return (
        Declared(f"{name}_input", reference, kind, {"causality": "input", **common, **given}, inside),
        Declared(f"{name}_output", reference + 1, kind, {"causality": "output", **common}),
    )


_FEET = '<Alias name="h_ft" description="Position in feet" displayUnit="ft"/>'
_BALL = (
    _real("h", 1, "output", "1", declaredType="Position", reinit="true", intermediateUpdate="true", inside=_FEET),
    _real("der(h)", 2, "local", declaredType="Velocity", derivative="1"),
    _real("v", 3, "output", "0", declaredType="Velocity", reinit="true", intermediateUpdate="true"),
    _real("der(v)", 4, "local", declaredType="Acceleration", derivative="3"),
    _parameter("g", 5, "-9.81", declaredType="Acceleration"),
    _parameter("e", 6, "0.7", "tunable", min="0.5", max="1"),
    Declared("v_min", 7, "Float64", {"variability": "constant", "declaredType": "Velocity", "start": "0.1"}),
)
_UNITS = """<UnitDefinitions>
<Unit name="m"><BaseUnit m="1"/><DisplayUnit name="ft" factor="3.280839895"/></Unit>
<Unit name="m/s"><BaseUnit m="1" s="-1"/></Unit><Unit name="m/s2"><BaseUnit m="1" s="-2"/></Unit>
</UnitDefinitions>"""
_QUANTITIES = {"Position": "m", "Velocity": "m/s", "Acceleration": "m/s2"}
_QUANTITIES2 = [
    f'<SimpleType name="{n}"><Real quantity="{n}" unit="{u}"/></SimpleType>' for n, u in _QUANTITIES.items()
]
_QUANTITIES3 = [f'<Float64Type name="{n}" quantity="{n}" unit="{u}"/>' for n, u in _QUANTITIES.items()]
_OPTIONS = '<Item name="Option 1" value="1" description="First"/><Item name="Option 2" value="2" description="Second"/>'
_STATES = (_real("x0", 1, "output", "2"), _real("x1", 3, "output", "0"))
_COUNTER = {"causality": "output", "variability": "discrete", "initial": "exact", "start": "1", "max": "10"}
PAIRS = {
    1: "Float32_continuous", 3: "Float32_discrete", 7: "Float64_continuous", 9: "Float64_discrete",
    11: "Int8", 13: "UInt8", 15: "Int16", 17: "UInt16", 19: "Int32", 21: "UInt32", 23: "Int64", 25: "UInt64",
    27: "Boolean", 29: "String", 31: "Binary", 33: "Enumeration",
}  # fmt: skip
"""The inputs of Feedthrough by their value references, without `_input`; their outputs follow them."""
MODELS = {
    "bouncing_ball": ReferenceModel(
        _BALL,
        'startTime="0" stopTime="3" stepSize="1e-2"',
        "1e-3",
        outputs={1: "", 3: ""},
        derivatives={2: "3", 4: "5"},
        initials={2: "3", 4: "5"},
        indicators=(1,),
        co_simulation='hasEventMode="true" mightReturnEarlyFromDoStep="true"',
        types={
            Version.FMI2: f"{_UNITS}<TypeDefinitions>{''.join(_QUANTITIES2)}</TypeDefinitions>",
            Version.FMI3: f"{_UNITS}<TypeDefinitions>{''.join(_QUANTITIES3)}</TypeDefinitions>",
        },
    ),
    "dahlquist": ReferenceModel(
        (_real("x", 1, "output", "1"), _real("der(x)", 2, "local", derivative="1"), _parameter("k", 3, "1")),
        'startTime="0" stopTime="10" stepSize="0.1"',
        "0.1",
        outputs={1: ""},
        derivatives={2: "1"},
        initials={2: "1 3"},
    ),
    "feedthrough": ReferenceModel(
        (
            _parameter("Float64_fixed_parameter", 5, "0"),
            _parameter("Float64_tunable_parameter", 6, "0", "tunable"),
            *(variable for reference, name in PAIRS.items() for variable in _pair(reference, name)),
        ),
        'startTime="0" stopTime="2"',
        "0.1",
        outputs={reference + 1: str(reference) for reference in PAIRS},
        initials={reference + 1: str(reference) for reference in PAIRS},
        co_simulation='hasEventMode="true"',
        types={
            Version.FMI2: f'<TypeDefinitions><SimpleType name="Option"><Enumeration>{_OPTIONS}</Enumeration>'
            "</SimpleType></TypeDefinitions>",
            Version.FMI3: f'<TypeDefinitions><EnumerationType name="Option">{_OPTIONS}</EnumerationType>'
            "</TypeDefinitions>",
        },
    ),
    "resource": ReferenceModel(
        (Declared("y", 1, "Int32", {"causality": "output"}),),
        'startTime="0" stopTime="1"',
        "1",
        outputs={1: None},
        initials={1: None},
    ),
    "stair": ReferenceModel(
        (Declared("counter", 1, "Int32", _COUNTER),),
        'startTime="0" stopTime="10" stepSize="0.2"',
        "0.2",
        outputs={1: None},
        co_simulation='hasEventMode="true"',
    ),
    "van_der_pol": ReferenceModel(
        (
            *_STATES,
            _real("der(x0)", 2, "local", derivative="1"),
            _real("der(x1)", 4, "local", derivative="3"),
            _parameter("mu", 5, "1"),
        ),
        'startTime="0" stopTime="20" stepSize="1e-2"',
        "1e-2",
        outputs={1: "", 3: ""},
        derivatives={2: "3", 4: "1 3"},
        initials={2: "3", 4: "1 3 5"},
    ),
}


@cache
def _binary(name: str, version: Version) -> Path:
    flags = [f'-DMODEL="models/{name}.h"', f'-DTOKEN="{GUID}"', EXACT]
    flags += ["-DHAS_EVENTS"] if "hasEventMode" in MODELS[name].co_simulation else []
    return library(kept_folder() / f"reference-{name}-{version}", version, f'#include "reference{version}.c"', *flags)


@cache
def reference_fmu(name: str, version: Version, *interfaces: str) -> Path:
    """The equal of a Reference FMU, compiled once for all tests.

    Args:
        name: The model, one of `MODELS`.
        version: The version of FMI.
        interfaces: The interface types, `CoSimulation` or `ModelExchange`; both where none is given.
    """
    model = MODELS[name]
    chosen = interfaces or ("ModelExchange", "CoSimulation")
    text = model.in_fmi2(*chosen) if version is Version.FMI2 else model.in_fmi3(*chosen)
    binary = _binary(name, version)
    files = {"resources__y_txt": "a\n"} if name == "resource" else {}
    return pack(binary.parent / "-".join(chosen) / f"{name}.fmu", version, text, binary, **files)
