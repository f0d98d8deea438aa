"""The process in which rumoca flattens a Modelica file: a hostile file may end it, or make it run or grow for ever.

The request and the answer are texts in JSON, so that nothing but plain data comes back.
"""
# pyright: basic
# rumoca carries no types; everything that leaves this file is annotated.

from __future__ import annotations

import json
import os
from contextlib import suppress
from typing import Any

from fmus.toolchain.child_process import ParentProcess
from fmus.toolchain.limits import FLATTENING_MEMORY
from fmus.toolchain.memory_limit import memory_limit
from fmus.toolchain.scratch import scratch_folder


def main() -> None:
    """Answer requests until the parent has ended."""
    parent = ParentProcess()
    parent.end_with_parent()
    memory_limit(FLATTENING_MEMORY)()
    with scratch_folder("modelica") as folder:
        os.chdir(folder)  # rumoca reads all Modelica files beside the one that it is given
        with suppress(EOFError):
            while True:
                parent.answer(json.dumps(flattened(json.loads(parent.request()))))


def flattened(request: dict[str, Any]) -> dict[str, Any]:
    """Flatten a model.

    Args:
        request: The `text` of a file, its `name` in messages, the `model` or None, the `libraries` that it may use, and
            its `path` where it is a part of a package of several files, which are read with it.

    Returns:
        `name`, `flat` and `sources`, or `report` and the reports on syntax in `syntax`.
    """
    import rumoca  # noqa: PLC0415 - an extra, and large

    text, name = request["text"], request["name"]
    try:
        session = rumoca.Session(request["libraries"])
        if request["path"] is None:
            compiled = session.loads(text, model=request["model"], filename=name)
        else:
            compiled = session.load(request["path"], model=request["model"])
        sources = compiled.to_dict("dae")["source_map"]["files"]
        return {"name": compiled.name, "flat": compiled.to_dict("flat"), "sources": sources}
    except rumoca.RumocaError as error:
        diagnostics = rumoca.validate_source(text, filename=name)
        return {"report": str(error), "syntax": [d.message for d in diagnostics if d.rule == "syntax-error"]}
    except Exception as error:  # noqa: BLE001 - whatever it is, the parent tells it
        return {"report": f"{type(error).__name__}: {error}", "syntax": []}


if __name__ == "__main__":
    main()
