"""The variables of an FMU that are no outputs, and can be read all the same: FMI lets an importer read every variable.

They are read on request only: models have 100 000 of them.
"""
# pyright: basic
# FMPy carries few types; everything that leaves this file is annotated.

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

from components.interfaces.problem import refuse
from fmus.reading.archive import Archive
from fmus.reading.declared_variables import observed_variables
from fmus.reading.start_values import ReadingError
from fmus.toolchain.archives import MODEL_DESCRIPTION

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
    except (ValueError, LookupError, TypeError, AttributeError) as error:  # caused by content that the schema forbids
        said = "a variable that cannot be understood" + (f" ({error})" if isinstance(error, ReadingError) else "")
        raise refuse(f"{archive.path}, {MODEL_DESCRIPTION}", said, "what FMI allows") from error
    clocks = {v.variable.name: frozenset(v.clocks) for v in found if v.clocks}
    return replace(
        archive,
        interface=replace(archive.interface, observed=tuple(v.variable for v in found)),
        references=archive.references | {v.variable.name: v.references for v in found},
        negated=archive.negated | {v.variable.name for v in found if v.negated},
        clocks_of={**archive.clocks_of, **clocks},
    )
