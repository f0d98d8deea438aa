"""documentation/index.html: what the block is, and the table of its variables."""

from __future__ import annotations

import inspect
from html import escape

from fmus.interface import FmiVariable, Interface

_STYLE = (
    "body{font-family:sans-serif;max-width:60em;margin:2em auto}"
    "table{border-collapse:collapse}"
    "td,th{border:1px solid #ccc;padding:.2em .6em;text-align:left}"
)


def documentation(interface: Interface) -> bytes:
    """The page."""
    block = interface.block
    rows = "\n".join(_row(v) for v in interface)
    page = f"""<!DOCTYPE html>
<html lang="en">
<head><meta charset="utf-8"><title>{escape(block.name)}</title><style>{_STYLE}</style></head>
<body>
<h1>{escape(block.name)}</h1>
<pre>{escape(inspect.getdoc(block) or block.summary)}</pre>
<p>Axes after ISO 8855: x forward, y left; yaw and steering positive to the left. All values in SI units.</p>
<table>
<tr><th>variable</th><th>causality</th><th>type</th><th>unit</th><th>valid</th><th>start</th><th>meaning</th></tr>
{rows}
</table>
</body>
</html>
"""
    return page.encode()


def _row(v: FmiVariable) -> str:
    q = v.variable.quantity
    shape = "".join(f"[{n}]" for n in q.shape)
    start = ", ".join(f"{value:g}" for value in v.start)
    cells = (v.name, f"{v.causality}, {v.variability}", f"{q.type}{shape}", q.unit, q.range, start, q.description)
    return "<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in cells) + "</tr>"
