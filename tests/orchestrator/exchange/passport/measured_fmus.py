"""FMUs that are right, or wrong in one way, for passports."""

from __future__ import annotations

from contextlib import contextmanager
from functools import cache

from fmus.toolchain.version import Version
from orchestrator.exchange.passport.bench import Bench
from orchestrator.system.source import Fmu
from tests.fmus.foreign import description2, kept_folder, library, pack, scalar

CAPABLE = 'canHandleVariableCommunicationStepSize="true" canGetAndSetFMUstate="true" canSerializeFMUstate="true"'
VOLT = (
    '<UnitDefinitions><Unit name="V"><BaseUnit kg="1" m="2" s="-3" A="-1"/></Unit>'
    '<Unit name="s"><BaseUnit s="1"/></Unit></UnitDefinitions>'
)
UNIT = 'unit="V"'
UNIT_AND_START = 'unit="V" start="1"'
EXPERIMENT = '<DefaultExperiment stepSize="0.1"/>'
RANGE = 'unit="V" start="1" min="-5" max="5"'
TRUCK = """
#define STEP { double *s = i->s, ms = 4500, mu = 500, k = 5e5, d = 4e4, kt = 2e6;      \\
    double f = k * (s[0] - s[2]) + d * (s[1] - s[3]), as = -f / ms, au = (f - kt * (s[2] - i->u)) / mu; \\
    s[0] += h * s[1]; s[1] += h * as; s[2] += h * s[3]; s[3] += h * au; }
#define SHOWN i->s[0]
"""
"""A quarter of a truck on its tyre, by explicit Euler with the communication step: it needs 0.016 s or less."""


def lag_description(u="", y="", capable=CAPABLE, dependencies="", experiment=EXPERIMENT, before=VOLT, more=()):
    """The description of `lag2.c`; `u` and `y` are attributes of their Real elements."""
    variables = [
        f'<ScalarVariable name="u" valueReference="1" causality="input"><Real {u or UNIT_AND_START}/></ScalarVariable>',
        f'<ScalarVariable name="y" valueReference="2" causality="output"><Real {y or UNIT}/></ScalarVariable>',
        scalar("T", 3, "parameter", variability="fixed", of_unit="s", of_start="0.5", of_min="0.01"),
        *more,
    ]
    return description2(
        variables,
        [f'<Unknown index="2" dependencies="{dependencies}"/>'],
        interface=f'<CoSimulation modelIdentifier="m" {capable}/>',
        before=before + experiment,
        initial=['<Unknown index="2"/>'],
    )


@cache
def lag_library(macros="", absent=()):
    """The library of the lag, with macros that change it; compiled once for all tests."""
    folder = kept_folder() / f"lag_{abs(hash((macros, absent)))}"
    return library(folder, Version.FMI2, f'{macros}\n#include "lag2.c"', absent=absent)


def lag(folder, macros="", *, absent=(), files=None, **description):
    """The FMU of the lag, as `m.fmu` in a folder."""
    text = lag_description(**description)
    return pack(folder / "m.fmu", Version.FMI2, text, lag_library(macros, tuple(absent)), **(files or {}))


@contextmanager
def on_the_bench(path, patience=10.0):
    """A bench for an FMU."""
    with Bench(Fmu(path, lenient=True).archive, lenient=True, patience=patience) as bench:
        yield bench


def told(lines):
    """The marks of lines by key, and their evidence."""
    return {line.key: (str(line.mark), line.evidence) for line in lines}
