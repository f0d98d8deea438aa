"""What SSP has no word for, as an annotation of ours says it: how the run is run, and what its units are to it."""

from __future__ import annotations

import json
from fractions import Fraction
from typing import Annotated, Any, Final, Literal

from pydantic import BaseModel, ConfigDict, Field

from components.interfaces.problem import refuse
from orchestrator.ssp.archive import Document
from orchestrator.ssp.writer import OURS
from orchestrator.system.experiment import EVERYTHING, STEP, Algorithm
from orchestrator.system.files import checked

_Seconds = Annotated[float, Field(gt=0, allow_inf_nan=False)]


class Notes(BaseModel):
    """The annotation that `writer` writes; what is missing is as where nothing is said."""

    model_config = ConfigDict(extra="forbid")

    step: _Seconds
    sockets: dict[str, Literal["plant", "traffic", "controller"]]
    scene: dict[str, Any] | None = None
    held: dict[str, Any] = {}
    """By input; bytes are hexadecimal digits"""
    algorithm: str = Algorithm.SEQUENTIAL
    solve_loops: bool = False
    record: dict[str, Annotated[int, Field(ge=0)]] = dict(EVERYTHING)
    steps: dict[str, Fraction] = {}
    isolated: dict[str, _Seconds] = {}
    sources: dict[str, dict[str, Any]] = {}
    """Of the scene and the experiment; those of parameters stand beside them"""


NOTHING: Final = Notes(step=STEP, sockets={})
"""What a system of another maker says"""


def read_notes(document: Document) -> Notes | None:
    """What our annotation says; None in a system of another maker. Raises `RequestError`."""
    node = document.root.find(f".//{{{OURS}}}Scenario")
    if node is None or not node.text:
        return None
    valid = "what macrostep wrote"
    try:
        notes: Any = json.loads(node.text)
    except ValueError as error:
        raise refuse(document.at(node), f"an annotation that is no JSON ({error})", valid) from error
    if not isinstance(notes, dict) or not {"step", "sockets"} <= notes.keys():
        raise refuse(document.at(node), "an annotation without a step or sockets", valid)
    return checked(Notes, notes, document.at(node))  # type: ignore[unknown]
