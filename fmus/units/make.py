"""The running unit of an FMU, by its version, interface type and capabilities."""

from __future__ import annotations

from fmus.reading.archive import Archive
from fmus.toolchain.version import Version
from fmus.units.clocked_unit import ClockedUnit
from fmus.units.co_simulation import Fmu2Unit, Fmu3Unit
from fmus.units.fmi1_unit import Fmu1Unit
from fmus.units.fmu_unit import FmuUnit


def fmu_unit(name: str, archive: Archive) -> FmuUnit:
    """The FMU in `archive` as a unit.

    Args:
        name: Name of the unit.
        archive: The FMU file, opened.

    Raises:
        RequestError: The library of the FMU cannot be used.
    """
    if archive.is_model_exchange:
        from fmus.units.fmi1_model import Model1Unit  # noqa: PLC0415 - it loads SUNDIALS
        from fmus.units.model_exchange import Model2Unit, Model3Unit  # noqa: PLC0415

        models = {Version.FMI1: Model1Unit, Version.FMI2: Model2Unit, Version.FMI3: Model3Unit}
        return models[archive.version](name, archive)
    if archive.interface.event_mode:
        return ClockedUnit(name, archive)
    return {Version.FMI1: Fmu1Unit, Version.FMI2: Fmu2Unit, Version.FMI3: Fmu3Unit}[archive.version](name, archive)
