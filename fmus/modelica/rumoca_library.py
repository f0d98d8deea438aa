"""All that is used of rumoca, which compiles Modelica files; no other file imports it.

We take rumoca's syntax tree of the flat model rather than the base-modelica text that is printed from it: the text
leaves out `when` and `algorithm`, gives a parameter without a value the value 0, and has no line numbers.

rumoca reports errors as text for a terminal; what is needed of them is read out of the text here.
"""
# pyright: basic
# rumoca carries no types; everything that leaves this file is annotated.

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from components.interfaces.problem import RequestError, refuse


@dataclass(frozen=True)
class CompiledModel:
    """A model that rumoca has compiled."""

    name: str
    """Its full name."""
    flat: Mapping[str, Any]
    """The syntax tree of the flat model."""
    sources: list[tuple[int, str, str]]
    """Number, file and text of everything that it was compiled from."""


def compiled_model(path: Path, model: str | None, library: Path) -> CompiledModel:
    """Compile a Modelica model.

    No object of rumoca leaves this function: only the thread that made it may release it, and an exception could carry
    it into another one.

    Args:
        path: The file.
        model: The model's name; None for the only model of the file.
        library: A Modelica package that the file may use.

    Raises:
        RequestError: rumoca is not installed, or does not compile the model.
    """
    try:
        import rumoca  # noqa: PLC0415 - an extra, and large
    except ImportError as error:
        remedy = "Install macrostep[modelica]."
        raise refuse(str(path), "a Modelica file, and no rumoca to read it", "rumoca", remedy) from error
    try:
        compiled = rumoca.Session([str(library)]).load(str(path), model=model)
        sources = compiled.to_dict("dae")["source_map"]["files"]
        return CompiledModel(compiled.name, compiled.to_dict("flat"), sources)
    except rumoca.RumocaError as error:
        reports = [d.message for d in rumoca.validate(str(path)) if d.rule == "syntax-error"]
        if reports:
            raise _no_modelica(path, reports[0]) from error
        raise _not_compiled(path, model, str(error)) from error


def _no_modelica(path: Path, report: str) -> RequestError:
    what, line = _syntax_error(report)
    return refuse(
        str(path) if line is None else f"{path}:{line}", f"text that is no Modelica ({what})", "a Modelica class"
    )


def _not_compiled(path: Path, model: str | None, report: str) -> RequestError:
    candidates = _candidates(report)
    if candidates is not None:
        return refuse(str(path), "several models", f"one of {candidates}", f"Name it: {path}:MODEL.")
    of_model = f" of `{model}`" if model else ""
    found = f"what rumoca cannot compile{of_model}: {_first_failure(report)}"
    return refuse(str(path), found, "a complete, balanced model")


def _syntax_error(report: str) -> tuple[str, str | None]:
    """What rumoca's report on a syntax error finds, and its line; the whole report where it has another form."""
    match = re.search(r"\u00d7 (?P<what>.+?)\n\s*\u256d\u2500\[(?P<file>.+):(?P<line>\d+):\d+\]", report)
    return (report, None) if match is None else (match["what"], match["line"])


def _first_failure(report: str) -> str:
    """The first of the failures in a report, in one line."""
    return re.sub(r"\s+", " ", report.partition("Related failures")[0]).strip()


def _candidates(report: str) -> str | None:
    """The models of which one has to be named; None for a report on something else."""
    failure = _first_failure(report)
    return failure.partition("Candidates: ")[2].rstrip(".") if "Unable to infer model" in failure else None
