"""What a person changes of a scenario for one run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

from fmus.toolchain.version import Version

Mode = Literal["blocks"] | Version
"""How blocks run: in this process, or as FMUs of a version."""


@dataclass(frozen=True)
class Options:
    """What a person changes of a scenario for one run."""

    mode: Mode = Version.FMI3
    replacements: Mapping[str, str] = field(default_factory=dict[str, str])
    """Block name or FMU file by socket"""
    settings: Sequence[str] = ()
    """`controller.b_3=1e-2`"""
    step: float | None = None
    stop_time: float | None = None
    record: Sequence[str] = ()
    """`controller.plan.*:10`"""
    algorithm: str | None = None
    solve_loops: bool = False
    lenient: bool = False
    """Whether FMUs run though they break rules"""
    isolate: Sequence[str] = ()
    """`plant:5`: units in processes of their own, and for how long [s] a call may take"""
