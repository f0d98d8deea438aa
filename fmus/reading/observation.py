"""The variables of an FMU that are no outputs, and can be read all the same: FMI lets an importer read every variable.

They are read on request only: models have 100 000 of them.
"""
# pyright: basic
# FMPy carries few types; everything that leaves this file is annotated.

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

from fmus.reading.archive import Archive
from fmus.reading.declared_variables import observed_variables
from fmus.reading.description import not_understood

LOCAL: Final = "local"
"""FMI's causality of local variables, which is that of variables without one, too."""
_OBSERVABLE: Final = (LOCAL, "parameter", "calculatedParameter", "structuralParameter")


def observable(archive: Archive) -> dict[str, str]:
    """The names of all variables that can be recorded besides the outputs, each with its causality."""
    return {
        str(v.name): causality
        for v in archive.description.modelVariables
        if (causality := v.causality or LOCAL) in _OBSERVABLE and v.type != "Clock"
    }


def observing(archive: Archive, names: Sequence[str], values: Mapping[str, Any]) -> Archive:
    """The same FMU, whose interface shows variables besides the outputs, in place of those that it showed before.

    Args:
        archive: The FMU.
        names: Names that `observable` gives.
        values: The values of its parameters that are given; those of structural ones determine the lengths of arrays.

    Raises:
        RequestError: The description of a variable cannot be understood.
    """
    try:
        found = observed_variables(archive.root, archive.description, archive.version, frozenset(names), values)
    except Exception as error:  # caused by content that the schema forbids
        raise not_understood(error, archive.where) from error
    clocks = {v.variable.name: frozenset(v.clocks) for v in found if v.clocks}
    return replace(
        archive,
        interface=replace(archive.interface, observed=tuple(v.variable for v in found)),
        references=archive.references | {v.variable.name: v.references for v in found},
        negated=archive.negated | {v.variable.name for v in found if v.negated},
        clocks_of={**archive.clocks_of, **clocks},
    )
