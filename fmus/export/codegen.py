"""C from a block: its equations, by CasADi, and the table of its variables, as runtime/model.h declares it."""
# pyright: basic
# CasADi carries no types; everything that leaves this file is annotated.

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

import casadi as ca

from components.interfaces.quantity import Type
from components.interfaces.record import Variable
from fmus.export.fmi_variables import TIME_REFERENCE, FmiVariable, FmiVariables
from fmus.lowering import LoweredBlock

_ROLES = {
    ("parameter", "fixed"): "FIXED_PARAMETER",
    ("parameter", "tunable"): "TUNABLE_PARAMETER",
    ("input", "continuous"): "INPUT",
    ("input", "discrete"): "INPUT",
    ("output", "continuous"): "OUTPUT",
    ("output", "discrete"): "OUTPUT",
}
_TYPES = {Type.FLOAT64: "FLOAT64", Type.INT32: "INT32", Type.BOOLEAN: "BOOLEAN", Type.ENUMERATION: "ENUMERATION"}
_HIDE = """#include <math.h>

/* see model.h */
#ifdef __GNUC__
#pragma GCC visibility push(hidden)
#endif
"""
_SHOW = """#ifdef __GNUC__
#pragma GCC visibility pop
#endif"""
_MOST_VARIABLES = 65535
"""How many variables the type of `variable_of` in runtime/model.h can number."""


def equations_source(lowered: LoweredBlock) -> str:
    """The text of model.c: the functions of a block.

    A sampled block has no `output`: its outputs come from `step`, so that its equations stand in the file only once.
    """
    generator = ca.CodeGenerator("model.c", {"with_export": False, "casadi_int": "long long int"})
    for name in _functions(lowered.sampled):
        generator.add(_exported(getattr(lowered, name)))
    return f"{_HIDE}\n{generator.dump()}\n{_SHOW}\n"


def _functions(sampled: bool) -> tuple[str, ...]:  # noqa: FBT001 - private
    return ("start", "step") if sampled else ("start", "output", "step")


def _exported(function: ca.Function) -> ca.Function:
    """The function by its name in C, with all results as full columns.

    CasADi leaves structural zeros out of sparse results. The names have a prefix because the GNU C library has a
    function `step`, which would be called instead wherever symbols are not hidden.
    """
    arguments: list[Any] = function.sx_in() if function.is_a("SXFunction") else function.mx_in()
    results: list[Any] = [ca.densify(result) for result in function.call(arguments, True, False)]  # noqa: FBT003 - CasADi's signature
    return ca.Function(f"model_{function.name()}", arguments, results, function.name_in(), function.name_out())


def variables_source(variables: FmiVariables, token: str) -> str:
    """The text of variables.c: names, types, ranges and start values, and the sizes of all columns.

    Args:
        variables: The variables of the FMU.
        token: The instantiation token, called GUID in FMI 2.0.

    Raises:
        ValueError: There are more variables than the runtime can number.
    """
    table = _table(variables)
    if len(table) > _MOST_VARIABLES:
        message = f"{variables.block.name} has {len(table)} variables; valid: at most {_MOST_VARIABLES}"
        raise ValueError(message)
    start = [value for v in (*variables.parameters, *variables.inputs) for value in v.start]
    owner = [index for index, (size, _) in enumerate(table) for _ in range(size)]
    return "\n".join(
        [
            "/* Generated: the variables of this model, see model.h. */",
            '#include "model.h"',
            "",
            "#include <math.h>",
            "",
            *(f"Evaluate model_{name};\nWorkSizes model_{name}_work;" for name in _functions(variables.sampled)),
            "",
            _array("double", "start_values", map(_number, start)),
            _array("Variable", "variables", (row for _, row in table)),
            _array("uint16_t", "variable_of", map(str, owner)),
            _model(variables, token, len(table)),
            "",
        ]
    )


def _table(variables: FmiVariables) -> list[tuple[int, str]]:
    """The number of elements and the row of each variable: time, parameters, inputs, outputs, clock and states."""
    rows = [(1, _row("time", "FLOAT64, TIME", TIME_REFERENCE))]
    rows += [
        (v.variable.size, _variable_row(v.variable, _ROLES[v.causality, v.variability], v.reference)) for v in variables
    ]
    at = 1 + sum(v.variable.size for v in variables)
    if variables.clock is not None:
        rows.append((1, _row(variables.clock.name, "CLOCK, INPUT_CLOCK", variables.clock.reference)))
        at = variables.clock.reference + 1
    for state in variables.block.states():
        rows.append((state.size, _variable_row(state, "STATE", at)))
        at += state.size
    return rows


def _row(name: str, type_and_role: str, reference: int) -> str:
    return f'{{"{name}", {type_and_role}, {reference}, 1, -INFINITY, INFINITY}}'


def _variable_row(variable: Variable, role: str, reference: int) -> str:
    q = variable.quantity
    low, high = q.min, q.max
    if q.enumeration is not None:
        values = q.enumeration.values.values()
        low, high = min(values), max(values)
    limits = f"{_number(-math.inf if low is None else low)}, {_number(math.inf if high is None else high)}"
    return f'{{"{variable.name}", {_TYPES[q.type]}, {role}, {reference}, {variable.size}, {limits}}}'


def _model(variables: FmiVariables, token: str, n_variables: int) -> str:
    block = variables.block
    output = "{NULL, NULL}" if variables.sampled else "{model_output, model_output_work}"
    return f"""const Model model = {{
    .name = "{block.name}",
    .token = "{token}",
    .sampled = {str(variables.sampled).lower()},
    .interval = {_number(variables.clock.interval if variables.clock else math.inf)},
    .max_step = {_number(block.max_step)},
    .n_p = {_size(variables.parameters)},
    .n_u = {_size(variables.inputs)},
    .n_y = {_size(variables.outputs)},
    .n_x = {sum(v.size for v in block.states())},
    .start = start_values,
    .variables = variables,
    .n_variables = {n_variables},
    .variable_of = variable_of,
    .initial = {{model_start, model_start_work}},
    .output = {output},
    .step = {{model_step, model_step_work}},
}};"""


def _size(variables: Sequence[FmiVariable]) -> int:
    return sum(v.variable.size for v in variables)


def _array(c_type: str, name: str, items: Iterable[str]) -> str:
    """A constant array; C99 has no empty arrays, so that an empty one gets an element, which is never read."""
    lines = "".join(f"    {item},\n" for item in items) or "    0,\n"
    return f"static const {c_type} {name}[] = {{\n{lines}}};\n"


def _number(value: float) -> str:
    if math.isinf(value):
        return "INFINITY" if value > 0 else "-INFINITY"
    return repr(float(value))
