"""The rules of FMI, by three readers: our own, FMPy's validator, and the FMU manipulation toolbox (`fmutool`)."""

from __future__ import annotations

import logging
import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from components.interfaces.problem import Problem
from fmus.toolchain.description_breach import as_phrase
from fmus.toolchain.fmpy_library import validate_fmu
from orchestrator.exchange.container import logged_errors
from orchestrator.exchange.passport.passport_line import Line, Topic

OPENS: Final = Topic("rules.macrostep", "It opens here without --lenient")
FMPY: Final = Topic("rules.fmpy", "FMPy's validator finds no problem")
FMUTOOL: Final = Topic("rules.fmutool", "The checks of fmutool have no remark")

_VERDICT: Final = "This FMU does not validate with FMI standard."
"""What fmutool adds to the problems of the schema."""


def lines(path: Path, broken: Sequence[Problem]) -> list[Line]:
    """The lines about the rules of FMI.

    Args:
        path: The file.
        broken: What our own reader finds.
    """
    return [
        OPENS.judged([f"{problem.where}: {problem.found}".replace(str(path), path.name) for problem in broken], "yes"),
        FMPY.judged([as_phrase(text) for text in fmpy_problems(path)], "0 problems"),
        FMUTOOL.judged(fmutool_remarks(path), "0 remarks"),
    ]


def fmpy_problems(path: Path) -> list[str]:
    """All problems that FMPy's validator finds, in its words."""
    try:
        return [str(problem) for problem in validate_fmu(str(path))]
    except (zipfile.BadZipFile, OSError) as error:
        return [str(error)]


def fmutool_remarks(path: Path) -> list[str]:
    """The warnings and errors of fmutool."""
    from fmu_manipulation_toolbox.checker import (  # noqa: PLC0415 - slow to import
        get_checkers,  # pyright: ignore[reportUnknownVariableType]
    )
    from fmu_manipulation_toolbox.operations import FMU  # noqa: PLC0415

    with logged_errors(logging.WARNING) as remarks:
        try:
            with FMU(str(path)) as fmu:
                for checker in get_checkers():  # pyright: ignore[reportUnknownVariableType]
                    fmu.apply_operation(checker())  # pyright: ignore[reportUnknownMemberType]
        except Exception as error:  # noqa: BLE001 - whatever it raises on a file that it does not expect
            remarks.append(f"it gives up: {type(error).__name__}: {error}")
    return [as_phrase(text).replace(str(path), path.name) for text in dict.fromkeys(remarks) if text != _VERDICT]
