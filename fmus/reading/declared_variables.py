"""The inputs, outputs and parameters that a model description declares: type, unit, shape, range and start value.

An array is one variable in both versions of FMI: FMI 2.0's elements ``name[1]``, ``name[2]``, ... (also ``name[1,2]``,
``name[1][2]``, and counted from 0) are joined where they fill their shape. A dot in a name is structure, also where the
file declares its names as `flat`.
"""
# pyright: basic
# FMPy carries few types; everything that leaves this file is annotated.

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, replace
from math import isfinite, prod
from typing import Any

from components.interfaces.items import Enumeration, Item
from components.interfaces.quantity import TRUTHS, Quantity, Type
from components.interfaces.record import Variable
from components.interfaces.units_of_measurement import BASE_UNITS, BaseUnit, base_unit
from fmus.reading.joined_arrays import joined_arrays, settable_arrays
from fmus.reading.start_values import ReadingError, read_value, shaped, start_texts
from fmus.toolchain.door import exception_in_words
from fmus.toolchain.file_names import shown_name
from fmus.toolchain.fmi1_description import negated_names
from fmus.toolchain.fmpy_library import ModelDescription
from fmus.toolchain.limits import LARGEST_ARRAY, MOST_DIMENSIONS, MOST_ELEMENTS
from fmus.toolchain.version import Version

_FMI2_TYPES = {"Real": Type.FLOAT64, "Integer": Type.INT32}
_CAUSALITIES = {"input": "input", "output": "output", "parameter": "parameter", "structuralParameter": "parameter"}


@dataclass(frozen=True)
class DeclaredVariable:
    """One input, output or parameter of an FMU."""

    variable: Variable
    causality: str
    """`input`, `output`, `parameter` (structural ones too), or `initial` for a start value that may be set."""
    start: Any
    """The start value in the shape of the variable; None where there is none."""
    references: list[int]
    """Value references: one per element in FMI 2.0, one in all in FMI 3.0."""
    variability: str = ""
    """FMI's variability; empty where the file gives none."""
    structural: bool = False
    """Whether it is a structural parameter."""
    clocks: tuple[int, ...] = ()
    """Value references of the clocks that the variable belongs to."""
    negated: bool = False
    """Whether its value is the negative one of that of the library, as FMI 1.0 allows."""


def declared_variables(
    root: Any, model: ModelDescription, version: Version, values: Mapping[str, Any]
) -> list[DeclaredVariable]:
    """All inputs, outputs and parameters, and the other variables whose start value may be set.

    Args:
        root: The root element of the model description.
        model: The model description.
        version: The version of FMI.
        values: The values of parameters that are given; those of structural ones are lengths of arrays.

    Raises:
        ReadingError: A start value or a limit is no value of its type, or an array is too large.
        Exception: The description breaks the schema in a way that is not known.
    """
    facts = _facts(root, model, version, values)
    visible = [
        _declared(v, facts)
        for v in model.modelVariables
        if v.causality in _CAUSALITIES
        and v.type != "Clock"
        and not _is_second_name(v)
        and not (v.variability == "constant" and v.causality != "output")  # what cannot change cannot be set either
    ]
    settable = [replace(_declared(v, facts), causality="initial") for v in _settable(model)]
    if version != Version.FMI3:
        visible = list(joined_arrays(visible))
        outputs = {v.variable.name: v.references for v in visible if v.causality == "output"}
        settable = list(settable_arrays(settable, outputs))
    _refuse_too_many(visible + settable)
    known = {v.variable.name for v in visible if v.causality != "output"}
    return visible + [v for v in settable if v.variable.name not in known]


def observed_variables(
    root: Any, model: ModelDescription, version: Version, names: Collection[str], values: Mapping[str, Any]
) -> list[DeclaredVariable]:
    """Variables of any causality, by `names`; elements of arrays stay scalar. Otherwise as `declared_variables`."""
    if not names:
        return []
    facts = _facts(root, model, version, values)
    return [_declared(v, facts) for v in model.modelVariables if v.name in names]


def _refuse_too_many(variables: Sequence[DeclaredVariable]) -> None:
    """Refuse arrays that together have too many elements."""
    number = sum(v.variable.size for v in variables)
    if number > MOST_ELEMENTS:
        raise ReadingError(f"variables with {number} elements in all, more than {MOST_ELEMENTS}")


def _relative(root: Any) -> dict[str, bool]:
    """Whether variables that say so themselves are differences, by name; FMPy reads it of types only."""
    said = root.xpath("ModelVariables//*[@relativeQuantity]")
    return {e.get("name") or e.getparent().get("name"): TRUTHS[e.get("relativeQuantity")] for e in said}


@dataclass(frozen=True)
class _Lengths:
    """The lengths of arrays that are values of variables, by the value references of these."""

    values: Mapping[int, int]
    changed: AbstractSet[int]
    """The value references of those that are not what the file says, for which its start values are."""


def _lengths(model: ModelDescription, values: Mapping[str, Any]) -> _Lengths:
    references = {d.valueReference for v in model.modelVariables for d in v.dimensions}
    deciding = [v for v in model.modelVariables if v.valueReference in references and v.start is not None]
    lengths = {v.valueReference: _length(values.get(v.name), v) for v in deciding}
    changed = {v.valueReference for v in deciding if lengths[v.valueReference] != _length(None, v)}
    return _Lengths(lengths, changed)


def _settable(model: ModelDescription) -> Iterator[Any]:
    """Outputs and local variables whose start value may be set before the initialisation."""
    for v in model.modelVariables:
        hidden = v.causality in ("output", "local", "calculatedParameter", None) and v.initial in ("exact", "approx")
        if hidden and v.variability != "constant" and v.type != "Clock" and v.alias is None:
            yield v


def _is_second_name(variable: Any) -> bool:
    """Whether it is an alias of a variable that is set, which can be set only once; outputs can be read by any name."""
    return variable.alias is not None and variable.causality != "output"


def aliases(model: ModelDescription, negated: Collection[str] = ()) -> dict[str, str]:
    """The variable for which each alias is another name; `negated` ones have another value."""
    return {v.name: v.alias.name for v in model.modelVariables if v.alias is not None and v.name not in negated}


def _length(given: Any, variable: Any) -> int:
    """The length of arrays that a variable is; a given value that is none is reported with the other parameters."""
    if isinstance(given, int) and given >= 0 and variable.causality == "structuralParameter":
        return given
    return read_value(variable.start, Type.UINT64, variable.name, "start value")


def _base(name: str, unit: Any) -> BaseUnit:
    """The definition of a unit of measurement."""
    exponents = {base: int(n) for base in BASE_UNITS if (n := getattr(unit, base))}
    factor, offset = float(unit.factor), float(unit.offset)
    if not (isfinite(factor) and isfinite(offset)):
        raise ReadingError(f"the unit `{name}` with the factor {unit.factor} and the offset {unit.offset}")
    return BaseUnit(exponents, factor, offset)


@dataclass(frozen=True)
class _Facts:
    """What a description says of its variables elsewhere than at FMPy's objects for them."""

    units: Mapping[str, BaseUnit]
    """The unit definitions."""
    lengths: _Lengths
    relative: Mapping[str, bool]
    """Whether values are differences, for the variables that say so themselves."""
    starts: Mapping[str, list[str]]
    """The start values of Strings and Binaries, by the names of the variables."""
    negated: Collection[str]
    """The names of variables whose values are the negative ones of those of the library."""


def _facts(root: Any, model: ModelDescription, version: Version, values: Mapping[str, Any]) -> _Facts:
    return _Facts(
        units={
            str(unit.name): _base(str(unit.name), unit.baseUnit)
            for unit in model.unitDefinitions
            if unit.baseUnit is not None
        },
        lengths=_lengths(model, values),
        relative=_relative(root),
        starts=start_texts(root) if version == Version.FMI3 else {},
        negated=negated_names(root) if version == Version.FMI1 else frozenset(),
    )


def _declared(variable: Any, facts: _Facts) -> DeclaredVariable:
    """A variable, as FMPy reads it; errors know its line."""
    try:
        return _declared_variable(variable, facts)
    except ReadingError as error:
        raise ReadingError(str(error), variable.sourceline) from error
    except Exception as error:  # content that the schema forbids: the kinds of exceptions have no end
        text = f"`{shown_name(str(variable.name))}`: {exception_in_words(error)}"
        raise ReadingError(text, variable.sourceline) from error


def _declared_variable(variable: Any, facts: _Facts) -> DeclaredVariable:
    """A variable, as FMPy reads it, with its shape and start value."""
    shape: tuple[int, ...] = ()
    if variable.dimensions:  # there may be very many scalars
        dimensions, lengths = variable.dimensions, facts.lengths.values
        shape = tuple(int(d.start) if d.start is not None else lengths[d.valueReference] for d in dimensions)
        if len(shape) > MOST_DIMENSIONS or min(shape) < 0:
            text = f"`{variable.name}` with {len(shape)} dimensions, the smallest of {min(shape)}"
            raise ReadingError(f"{text}; valid are up to {MOST_DIMENSIONS}, none negative")
        if prod(shape) > LARGEST_ARRAY:
            raise ReadingError(f"`{variable.name}` with {prod(shape)} elements, more than {LARGEST_ARRAY}")
    of_type = variable.declaredType is not None and bool(variable.declaredType.relativeQuantity)
    quantity = _quantity(variable, shape, facts.units, relative=facts.relative.get(variable.name, of_type))
    given = facts.starts.get(variable.name) or ([] if variable.start is None else [str(variable.start)])
    if quantity.type.is_number:
        given = " ".join(given).split()
    if len(given) != 1 and variable.dimensions and _is_changed(variable, facts.lengths):
        given = []  # which values the elements of an array of another shape have only the FMU knows
    start = [read_value(text, quantity.type, variable.name, "start value") for text in given]
    return DeclaredVariable(
        Variable(variable.name, quantity),
        _CAUSALITIES.get(variable.causality, ""),
        shaped(start, quantity) if start else None,
        [variable.valueReference],
        variability=variable.variability or "",
        structural=variable.causality == "structuralParameter",
        clocks=tuple(clock.valueReference for clock in variable.clocks or ()),
        negated=variable.name in facts.negated and quantity.type is not Type.BOOLEAN,
    )


def _is_changed(variable: Any, lengths: _Lengths) -> bool:
    """Whether an array has another length than the file says."""
    return any(d.valueReference in lengths.changed for d in variable.dimensions)


def _quantity(variable: Any, shape: tuple[int, ...], units: Mapping[str, BaseUnit], *, relative: bool) -> Quantity:
    """The quantity of a variable; of differences, which are `relative`, the offset of the unit does not count."""
    declared = variable.declaredType
    value_type = _FMI2_TYPES.get(variable.type) or Type(variable.type)
    unit = (variable.unit or (declared.unit if declared else None) or "") if value_type.is_float else "1"
    limits = [getattr(variable, n) or (getattr(declared, n) if declared else None) for n in ("min", "max")]
    low, high = (
        None if b is None or value_type is Type.ENUMERATION else read_value(b, Type.FLOAT64, variable.name, "limit")
        for b in limits
    )
    return Quantity(
        unit,
        variable.description or variable.name,
        value_type,
        shape,
        low,
        high,
        _enumeration(declared) if declared and declared.items else None,
        _without_offset(units.get(unit) or base_unit(unit)) if relative else units.get(unit),
    )


def _without_offset(base: BaseUnit | None) -> BaseUnit | None:
    return None if base is None else replace(base, offset=0.0)


def _enumeration(declared: Any) -> Enumeration:
    return Enumeration(str(declared.name), tuple(Item(str(i.name), int(i.value)) for i in declared.items))
