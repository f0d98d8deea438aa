"""The FMUs that a scenario, a person or a mapping file asks for: files, and Modelica models, which become files."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from components.interfaces.progress import SILENT, Progress
from fmus.modelica.build_modelica import build_modelica, is_modelica
from fmus.toolchain.version import Version
from orchestrator.scenario.catalogue import built_folder
from orchestrator.scenario.options import UNCHANGED, Mode
from orchestrator.system.source import Fmu


@dataclass(frozen=True)
class RequestedFmus:
    """The FMUs by what was asked for, of which each Modelica model is built once.

    Args:
        mode: How blocks run, which gives the version of FMI of the FMUs that are built.
        progress: Receives a report before each build.
        lenient: Whether the files may be used although they break rules of FMI.
    """

    mode: Mode = UNCHANGED.mode
    progress: Progress = SILENT
    lenient: bool = False
    built: dict[str, Path] = field(default_factory=dict[str, Path], init=False)

    def fmu(self, request: str) -> Fmu:
        """The FMU of a request, which messages name as the request does.

        Args:
            request: The path of an FMU, or `FILE.mo` or `FILE.mo:MODEL`.

        Raises:
            RequestError: The model cannot become a block, or has parameters without a value.
            BuildError: The C compiler fails.
        """
        if not is_modelica(request):
            return Fmu(Path(request), lenient=self.lenient)
        if request not in self.built:
            self.progress.now(f"building {request}")
            version = Version.FMI3 if self.mode == "blocks" else self.mode
            self.built[request] = build_modelica(request, version, built_folder() / "modelica").path
        return Fmu(self.built[request], lenient=self.lenient, where=request)
