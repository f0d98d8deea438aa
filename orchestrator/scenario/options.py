"""The changes that a person makes to a scenario for one run, on the command line or from Python."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final, Literal

from components.interfaces.arguments import check_fields, names_told
from components.interfaces.problem import refuse
from fmus.toolchain.version import Version

Mode = Literal["blocks"] | Version
"""How blocks run: in this process, or as FMUs of a version."""


@names_told
@dataclass(frozen=True)
class Options:
    """The changes that a person makes to a scenario for one run."""

    mode: Mode = Version.FMI3
    replacements: Mapping[str, str | Path] = field(default_factory=dict[str, str | Path])
    """Another unit by socket: the name of a block, or a file (`.fmu`, the `.toml` that maps one, or `.mo`)."""
    settings: Sequence[str] = ()
    """Parameter values, such as `controller.b_3=1e-2`, or `@FILE` with one of them on each line."""
    step: float | None = None
    """Macro step [s]; that of the scenario if not given."""
    stop_time: float | None = None
    """End of the run [s]; that of the scenario if not given."""
    start_time: float | None = None
    """Beginning of the run [s]; that of the scenario if not given."""
    tolerance: float | None = None
    """The relative tolerance that all FMUs are told; that of the scenario, or each FMU's own, if not given."""
    interface: Sequence[str] = ()
    """Interface types of FMUs that have both: `cs` or `me`, or for one unit `plant=me`."""
    record: Sequence[str] = ()
    """Patterns of the signals that are recorded, such as `controller.plan.*:10` for every tenth tick."""
    algorithm: str | None = None
    """Master algorithm: `sequential`, `jacobi` or `clocked`; that of the scenario if not given."""
    solve_loops: bool = False
    """Whether algebraic loops are solved by iteration instead of being refused."""
    end_off_road: bool = False
    """Whether the run ends where the vehicle leaves the surroundings of the road."""
    lenient: bool = False
    """Whether files may be used although they break rules of FMI or SSP."""
    allow_nonfinite: Sequence[str] = ()
    """Patterns of signals that may be infinite or not a number although a unit reads them; all may with `lenient`."""
    input: str | Path | None = None
    """A file with the values of inputs over time (`.csv` or `.parquet`); that of the scenario if not given."""
    input_hold: bool = False
    """Whether values of that file hold until the next row; else floating-point numbers are interpolated linearly."""
    isolate: Sequence[str] = ()
    """Units that run in processes of their own, such as `plant:5`, where a call may take 5 s."""
    in_process: bool | Sequence[str] = False
    """FMUs of other makers that run in this process, by unit; or whether all do that `isolate` does not name."""

    def __post_init__(self) -> None:
        check_fields(self)
        if self.mode == Version.FMI1:
            raise refuse("Options: mode", "Version.FMI1, which is read only", "`blocks`, Version.FMI2 or Version.FMI3")


UNCHANGED: Final = Options()
"""A scenario as it stands."""
