"""Start values and limits, as texts of a model description, as values of their types."""
# pyright: basic
# lxml carries few types for the elements of a document; everything that leaves this file is annotated.

from __future__ import annotations

from typing import Any

import numpy as np

from components.interfaces.quantity import DTYPES, TRUTHS, Quantity, Type
from components.interfaces.record import Variable
from fmus.toolchain.file_names import shown_name


class ReadingError(ValueError):
    """A variable with a value that cannot be read; the message is a part of ours.

    Args:
        text: What is found.
        line: The line of the description; None where it is not known.
    """

    def __init__(self, text: str, line: int | None = None) -> None:
        self.line = line
        super().__init__(text)


def start_texts(root: Any) -> dict[str, list[str]]:
    """The elements `Start` of String and Binary variables, of which FMPy reads the first only, by their names."""
    found: dict[str, list[str]] = {}
    for start in root.iterfind("ModelVariables/*/Start"):
        found.setdefault(start.getparent().get("name"), []).append(start.get("value"))
    return found


def read_value(text: str, value_type: Type, name: str, what: str) -> Any:
    """The value of a text; `what` names the attribute of the variable in messages, such as `start value`."""
    try:
        if value_type is Type.BOOLEAN:
            return TRUTHS[text.lower()]
        if value_type is Type.STRING:
            return text
        if value_type is Type.BINARY:
            return bytes.fromhex(text)
        # numpy refuses integers that do not fit the width of the type
        return float(text) if value_type.is_float else DTYPES[value_type](text).item()
    except (ValueError, LookupError, OverflowError) as error:
        raise ReadingError(f"`{name}` with the {what} `{shown_name(text)}`") from error


def shaped(start: list[Any], quantity: Quantity) -> Any:
    """Start values in the shape of their variable; a single one is the start value of all elements."""
    if not quantity.shape:
        return start[0]
    return np.resize(np.array(start, dtype=DTYPES[quantity.type]), Variable("", quantity).shape)
