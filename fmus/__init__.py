"""From a block to an FMU, and from an FMU to a running unit.

The public names are imported when they are first used: `import fmus` itself loads nothing else.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from components.interfaces.facade import facade

if TYPE_CHECKING:
    from fmus.export.build import Built, build, build_all
    from fmus.modelica.build_modelica import build_modelica
    from fmus.reading.archive import Archive
    from fmus.reading.opening import open_fmu
    from fmus.toolchain.compiler import BuildError
    from fmus.toolchain.version import Version
    from fmus.units.block_unit import BlockUnit
    from fmus.units.make import fmu_unit
    from fmus.units.unit import Unit, UnitError

__all__ = [
    "Archive",
    "BlockUnit",
    "BuildError",
    "Built",
    "Unit",
    "UnitError",
    "Version",
    "build",
    "build_all",
    "build_modelica",
    "fmu_unit",
    "open_fmu",
]

__getattr__, __dir__ = facade(
    __name__,
    {
        "fmus.export.build": ("Built", "build", "build_all"),
        "fmus.modelica.build_modelica": ("build_modelica",),
        "fmus.reading.archive": ("Archive",),
        "fmus.reading.opening": ("open_fmu",),
        "fmus.toolchain.compiler": ("BuildError",),
        "fmus.toolchain.version": ("Version",),
        "fmus.units.block_unit": ("BlockUnit",),
        "fmus.units.make": ("fmu_unit",),
        "fmus.units.unit": ("Unit", "UnitError"),
    },
)
