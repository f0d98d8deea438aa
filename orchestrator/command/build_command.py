"""The command `macrostep build`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from fmus.toolchain.version import WRITTEN_VERSIONS
from orchestrator.command.console import out, working
from orchestrator.command.shared_options import Fmi


def build(
    models: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[FILE.mo]...", help="Modelica files to build instead; FILE.mo:MODEL for one of several."
        ),
    ] = None,
    fmi: Annotated[Fmi | None, typer.Option(help="Only this version of FMI; both if not given.")] = None,
    folder: Annotated[Path | None, typer.Option("--out", help="Where to write fmi2/ and fmi3/.")] = None,
) -> None:
    """Build the FMUs of all blocks, or those of Modelica files (into fmi2/ and fmi3/ here), where out of date."""
    from components import BLOCKS  # noqa: PLC0415
    from orchestrator.scenario import catalogue  # noqa: PLC0415

    versions = [fmi.version] if fmi else WRITTEN_VERSIONS
    target = folder or catalogue.built_folder()
    with working() as progress:
        if models:
            for path in catalogue.build_models(models, versions, folder or Path(), progress):
                out.print(str(path))
            return
        files = catalogue.ensure_built([b for b in BLOCKS.values() if b.native], versions, target, progress)
    out.print(f"{len(files)} FMUs in {target}/")
