"""documentation/index.html: the block's docstring, the table of its variables, and when a sampled block acts."""

from __future__ import annotations

import inspect
from html import escape

from fmus.export.fmi_variables import FmiVariable, FmiVariables, SampleClock
from fmus.toolchain.version import Version

_STYLE = (
    "body{font-family:sans-serif;max-width:60em;margin:2em auto}"
    "table{border-collapse:collapse}"
    "td,th{border:1px solid #ccc;padding:.2em .6em;text-align:left}"
)

_SAMPLED = """<h2>When it acts</h2>
<p>The block is sampled: it computes its outputs from the inputs of one instant, and they hold until it acts again.</p>
"""
_AT_STEPS = "<p>It acts once in each <code>fmi2DoStep</code>, on the inputs set before it.</p>"
_AT_TICKS = """<p>With event mode (<code>eventModeUsed</code>) it acts at the ticks of its clock <code>{name}</code>, a
fixed periodic input clock without shift: at the start time, and then every {interval:g} s, or whatever
<code>fmi3SetIntervalDecimal</code> has set in Initialization Mode. At a tick, in Event Mode:
<code>fmi3SetClock</code>, set the inputs, get the outputs, <code>fmi3UpdateDiscreteStates</code>,
<code>fmi3EnterStepMode</code>. The outputs show the new inputs at once; <code>fmi3DoStep</code> only lets time
pass.</p>
<p>Without event mode, or when the importer steps before the clock has ticked, it acts once in each
<code>fmi3DoStep</code>, on the inputs set before it.</p>"""


def documentation(variables: FmiVariables, version: Version) -> bytes:
    """The page, in HTML."""
    block = variables.block
    rows = "\n".join(_row(v) for v in variables)
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
{_sampling(variables.clock, version)}
</body>
</html>
"""
    return page.encode()


def _sampling(clock: SampleClock | None, version: Version) -> str:
    """When a sampled block acts; empty for other blocks."""
    if clock is None:
        return ""
    if version is Version.FMI2:
        return _SAMPLED + _AT_STEPS
    return _SAMPLED + _AT_TICKS.format(name=escape(clock.name), interval=clock.interval)


def _row(v: FmiVariable) -> str:
    q = v.variable.quantity
    shape = "".join(f"[{n}]" for n in q.shape)
    start = ", ".join(f"{value:g}" for value in v.start)
    cells = (v.name, f"{v.causality}, {v.variability}", f"{q.type}{shape}", q.unit, q.range, start, q.description)
    return "<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in cells) + "</tr>"
