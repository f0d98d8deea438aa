"""All that is used of rumoca, which compiles Modelica files in a process of its own (`fmus.modelica.rumoca_process`).

We take rumoca's syntax tree of the flat model rather than the base-modelica text that is printed from it: the text
leaves out `when` and `algorithm`, gives a parameter without a value the value 0, and has no line numbers.

rumoca reports errors as text for a terminal; what is needed of them is read out of the text here.
"""
# pyright: basic
# rumoca carries no types; everything that leaves this file is annotated.

from __future__ import annotations

import json
import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from components.interfaces.problem import RequestError, refuse
from fmus.toolchain.child_death import ChildDiedError, ChildSilentError, death_in_words
from fmus.toolchain.child_process import ChildProcess
from fmus.toolchain.door import reading
from fmus.toolchain.limits import FLATTENING_TIME, LARGEST_MODELICA
from fmus.toolchain.typed_messages import UnreadableMessageError


@dataclass(frozen=True)
class CompiledModel:
    """A model that rumoca has compiled."""

    name: str
    """Its full name."""
    flat: Mapping[str, Any]
    """The syntax tree of the flat model."""
    sources: list[tuple[int, str, str]]
    """Number, file and text of everything that it was compiled from."""


def compiled_model(path: Path, model: str | None, libraries: Sequence[Path]) -> CompiledModel:
    """Compile a Modelica model.

    A file that lies in a package of several files is compiled with these; any other by itself.

    Args:
        path: The file.
        model: The model's name; None for the only model of the file.
        libraries: Modelica packages that the file may use.

    Raises:
        RequestError: rumoca is not installed, or does not compile the model within the limits.
    """
    if find_spec("rumoca") is None:
        remedy = "Install macrostep[modelica]."
        raise refuse(str(path), "a Modelica file, and no rumoca to read it", "rumoca", remedy)
    whole = path.name != "package.mo" and (path.parent / "package.mo").is_file()
    request: dict[str, Any] = {
        "text": _text(path),
        "name": path.name,
        "model": model,
        "libraries": [str(library.absolute()) for library in libraries],
        "path": str(path.absolute()) if whole else None,
    }
    answer = _answer(path, request)
    if "report" not in answer:
        names: dict[str, str] = {path.name: str(path), str(path.absolute()): str(path)}
        sources: list[tuple[int, str, str]] = [
            (n, names.get(str(name), str(name)), text) for n, name, text in answer["sources"]
        ]
        return CompiledModel(answer["name"], answer["flat"], sources)
    report = answer["report"].replace(path.name, str(path)) if not whole else answer["report"]
    if answer["syntax"]:
        raise _no_modelica(path, answer["syntax"][0])
    raise _not_compiled(path, model, report)


def _text(path: Path) -> str:
    """The text of a Modelica file. Raises `RequestError`."""
    with reading(str(path), "a Modelica file in UTF-8"):
        if (size := path.stat().st_size) > LARGEST_MODELICA:
            found = f"{size / 2**20:.0f} MiB of Modelica"
            raise refuse(str(path), found, f"at most {LARGEST_MODELICA / 2**20:.0f} MiB in one file")
        content = path.read_bytes()
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content[: error.start].count(b"\n") + 1
        found = f"a byte that is no UTF-8 (0x{content[error.start]:02x})"
        raise refuse(f"{path}:{line}", found, "a Modelica file in UTF-8", "Save it again in that encoding.") from error


def _answer(path: Path, request: Mapping[str, Any]) -> Any:
    """What the process of rumoca answers. Raises `RequestError` where it does not."""
    valid = "a Modelica model that rumoca can flatten"
    with Path(os.devnull).open("wb") as nowhere:  # what it prints when it dies
        child = ChildProcess("fmus.modelica.rumoca_process", str, errors=nowhere)
    try:
        answer = child.ask(json.dumps(request), FLATTENING_TIME)
    except ChildSilentError as error:
        found = f"a model that rumoca does not flatten within {FLATTENING_TIME:g} s"
        raise refuse(str(path), found, valid) from error
    except ChildDiedError as error:
        found = f"a model with which rumoca ends ({death_in_words(error.death)})"
        raise refuse(str(path), found, valid, "Write it in a simpler way.") from error
    except UnreadableMessageError as error:
        raise refuse(str(path), f"a model of which rumoca makes no text ({error})", valid) from error
    finally:
        child.kill()
        child.close()
    with reading(str(path), valid):
        return json.loads(answer)


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
