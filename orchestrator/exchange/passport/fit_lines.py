"""Which sockets an FMU fits."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from components.interfaces.sockets import SOCKETS
from fmus.reading.archive import Archive
from orchestrator.exchange.check import fit_in_words
from orchestrator.exchange.passport.passport_line import Line, Topic
from orchestrator.mapping.fitting import fit
from orchestrator.mapping.fitting_result import Fitting
from orchestrator.mapping.mapping_file import MappingFile

FITS: Final = Topic("fit.sockets", "It fits a socket")


def fittings(archive: Archive, mapping: MappingFile | None) -> dict[str, Fitting]:
    """How it fits each socket, or that of its mapping file."""
    names = [mapping.socket] if mapping is not None and mapping.socket is not None else list(SOCKETS)
    return {n: fit(n, SOCKETS[n], archive.interface, archive.path.name, mapping) for n in names}


def line(fitted: Mapping[str, Fitting]) -> Line:
    """The line about sockets; most FMUs are made for none."""
    texts = {name: fit_in_words(fitting).replace("below", "that check lists") for name, fitting in fitted.items()}
    fitting = [f"{name}: {texts[name]}" for name, one in fitted.items() if not one.problems]
    if fitting:
        return FITS.passes("; ".join(fitting))
    return FITS.does_not_apply("; ".join(f"{name}: {text}" for name, text in texts.items()))
