"""Model Exchange FMUs that are made in the tests, of both versions of FMI: their descriptions."""

from __future__ import annotations

from functools import cache

from fmus.toolchain.version import Version
from tests.fmus.foreign import description2, description3, kept_folder, library, pack, scalar

START = {"initial": "exact"}
DISCRETE = 'variability="discrete" initial="exact" start="0"'


def ball2():
    variables = [
        scalar("h", 1, "output", of_start="1", **START),
        scalar("v", 2, "output", of_start="0", **START),
        scalar("der(h)", 3, "local", of_derivative="1"),
        scalar("der(v)", 4, "local", of_derivative="2"),
        scalar("g", 5, "parameter", variability="tunable", of_start="9.81"),
        scalar("e", 6, "parameter", variability="tunable", of_start="0.7"),
        scalar("bounces", 7, "output", variability="discrete", of_start="0", **START),
    ]
    outputs = [f'<Unknown index="{i}" dependencies=""/>' for i in (1, 2, 7)]
    return description2(
        variables,
        outputs,
        interface='<ModelExchange modelIdentifier="m" completedIntegratorStepNotNeeded="true"/>',
        guid="me",
        attributes='numberOfEventIndicators="1"',
        derivatives=['<Unknown index="3" dependencies="2"/>', '<Unknown index="4" dependencies="5"/>'],
    )


def ball3():
    variables = [
        '<Float64 name="h" valueReference="1" causality="output" initial="exact" start="1"/>',
        '<Float64 name="v" valueReference="2" causality="output" initial="exact" start="0"/>',
        '<Float64 name="der(h)" valueReference="3" derivative="1"/>',
        '<Float64 name="der(v)" valueReference="4" derivative="2"/>',
        '<Float64 name="g" valueReference="5" causality="parameter" variability="tunable" start="9.81"/>',
        '<Float64 name="e" valueReference="6" causality="parameter" variability="tunable" start="0.7"/>',
        f'<Float64 name="bounces" valueReference="7" causality="output" {DISCRETE}/>',
        '<Float64 name="z" valueReference="8"/>',
    ]
    structure = [f'<Output valueReference="{i}" dependencies=""/>' for i in (1, 2, 7)]
    structure += ['<ContinuousStateDerivative valueReference="3"/>', '<ContinuousStateDerivative valueReference="4"/>']
    structure += ['<EventIndicator valueReference="8"/>']
    return description3(variables, structure, interface='<ModelExchange modelIdentifier="m"/>', guid="me")


def stiff2():
    variables = [
        scalar("x1", 1, "output", of_start="2", of_nominal="10", **START),
        scalar("x2", 2, "output", of_start="1", **START),
        scalar("der(x1)", 3, "local", of_derivative="1"),
        scalar("der(x2)", 4, "local", of_derivative="2"),
        scalar("u", 5, "input", of_start="0"),
        scalar("y", 6, "output"),
    ]
    outputs = [f'<Unknown index="{i}" dependencies="{needs}"/>' for i, needs in ((1, ""), (2, ""), (6, "1 5"))]
    return description2(
        variables,
        outputs,
        interface='<ModelExchange modelIdentifier="m" completedIntegratorStepNotNeeded="true"/>',
        guid="me",
        derivatives=['<Unknown index="3"/>', '<Unknown index="4"/>'],
        initial=['<Unknown index="3"/>', '<Unknown index="4"/>', '<Unknown index="6"/>'],
    )


def stiff3():
    variables = [
        '<Float64 name="x1" valueReference="1" causality="output" initial="exact" start="2" nominal="10"/>',
        '<Float64 name="x2" valueReference="2" causality="output" initial="exact" start="1"/>',
        '<Float64 name="der(x1)" valueReference="3" derivative="1"/>',
        '<Float64 name="der(x2)" valueReference="4" derivative="2"/>',
        '<Float64 name="u" valueReference="5" causality="input" start="0"/>',
        '<Float64 name="y" valueReference="6" causality="output"/>',
    ]
    structure = ['<Output valueReference="1" dependencies=""/>', '<Output valueReference="2" dependencies=""/>']
    structure += ['<Output valueReference="6" dependencies="1 5"/>']
    structure += ['<ContinuousStateDerivative valueReference="3"/>', '<ContinuousStateDerivative valueReference="4"/>']
    structure += [f'<InitialUnknown valueReference="{i}"/>' for i in (3, 4, 6)]
    return description3(variables, structure, interface='<ModelExchange modelIdentifier="m"/>', guid="me")


CLOCKWORK = {
    1: ("x", "output", 0.0),
    5: ("openings", "output", 0.0),
    6: ("steps", "output", 0.0),
    7: ("end", "parameter", 1e9),
    8: ("iterations", "parameter", 0.0),
    12: ("limit", "parameter", 1e9),
}


def clockwork2():
    variables = [
        scalar("x", 1, "output", of_start="0", **START),
        scalar("der(x)", 2, "local", of_derivative="1"),
        scalar("gate", 4, "input", "Boolean", variability="discrete", of_start="false"),
        scalar("openings", 5, "output", variability="discrete", of_start="0", **START),
        scalar("steps", 6, "output", variability="discrete", of_start="0", **START),
        *(
            scalar(CLOCKWORK[i][0], i, "parameter", variability="tunable", of_start=str(CLOCKWORK[i][2]))
            for i in (7, 8, 12)
        ),
    ]
    outputs = ['<Unknown index="1" dependencies=""/>', '<Unknown index="4" dependencies="3"/>']
    outputs += ['<Unknown index="5" dependencies=""/>']
    interface = '<ModelExchange modelIdentifier="m"/>'
    return description2(variables, outputs, interface=interface, guid="me", derivatives=['<Unknown index="2"/>'])


def clockwork3():
    variables = [
        '<Float64 name="x" valueReference="1" causality="output" initial="exact" start="0"/>',
        '<Float64 name="der(x)" valueReference="2" derivative="1"/>',
        '<Boolean name="gate" valueReference="4" causality="input" start="false"/>',
        f'<Float64 name="openings" valueReference="5" causality="output" {DISCRETE}/>',
        f'<Float64 name="steps" valueReference="6" causality="output" {DISCRETE}/>',
    ]
    for reference in (7, 8, 12):
        name, _, start = CLOCKWORK[reference]
        kind = f'causality="parameter" variability="tunable" start="{start}"'
        variables.append(f'<Float64 name="{name}" valueReference="{reference}" {kind}/>')
    structure = ['<Output valueReference="1" dependencies=""/>', '<Output valueReference="5" dependencies="4"/>']
    structure += ['<Output valueReference="6" dependencies=""/>', '<ContinuousStateDerivative valueReference="2"/>']
    interface = '<ModelExchange modelIdentifier="m" needsCompletedIntegratorStep="true"/>'
    return description3(variables, structure, interface=interface, guid="me")


DESCRIPTIONS = {
    ("ball", 2): ball2,
    ("ball", 3): ball3,
    ("stiff", 2): stiff2,
    ("stiff", 3): stiff3,
    ("clockwork", 2): clockwork2,
    ("clockwork", 3): clockwork3,
}


@cache
def built_models():
    """The FMUs by the name of the model and the version of FMI; compiled once for all tests."""
    made = {}
    for (name, version), description in DESCRIPTIONS.items():
        where = kept_folder() / f"{name}{version}"
        binary = library(where, Version(version), f'#include "me{version}.c"', f'-DMODEL="{name}.h"')
        made[name, version] = pack(where / f"{name}.fmu", Version(version), description(), binary)
    return made
