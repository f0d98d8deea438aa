"""An SSP file run by another tool, in a process of its own: `peers.py TOOL FILE.ssp TICKS ROWS.parquet`.

Row k holds all outputs at t_k = k h, under our names; what a tool does not show is NaN.
"""

from __future__ import annotations

import ctypes
import sys
import zipfile
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from lxml import etree

NS = {"ssd": "http://ssp-standard.org/SSP1/SystemStructureDescription"}


class Exported:
    """What the runs need to know of an SSP file of ours."""

    def __init__(self, path: str) -> None:
        with zipfile.ZipFile(path) as archive:
            root = etree.fromstring(archive.read("SystemStructure.ssd"))
        self.path = path
        self.name = root.get("name")
        self.h = float(root.xpath("//@baseStepSize")[0])
        self.units = [c.get("name") for c in root.iterfind(".//ssd:Component", NS)]
        self.outputs = [
            (c.get("name"), o.get("name"), etree.QName(o[0]).localname)
            for c in root.iterfind(".//ssd:Component", NS)
            for o in c.iterfind("ssd:Connectors/ssd:Connector[@kind='output']", NS)
        ]


def fmpy(ssp: Exported, ticks: int) -> pd.DataFrame:
    """FMPy applies no parameter set of the file: it takes one with the components' names, and all texts are true."""
    from fmpy.ssp.simulation import simulate_ssp  # noqa: PLC0415
    from fmpy.ssp.ssd import ParameterSet, read_ssv  # noqa: PLC0415

    given = ParameterSet()
    for unit in ssp.units:
        for parameter in read_ssv(ssp.path, f"resources/{unit}.ssv").parameters:
            parameter.name = f"{unit}.{parameter.name}"
            if parameter.type == "Boolean":
                parameter.value = float(parameter.value == "true")
            given.parameters.append(parameter)
    # it stops at the first sum of steps that is not below the stop time, and its rows are those after each step
    found = simulate_ssp(ssp.path, stop_time=(ticks - 0.5) * ssp.h, step_size=ssp.h, parameter_set=given)
    rows = {f"{unit}.{name}": [np.nan, *found[f"{unit}.{name}"]] for unit, name, _ in ssp.outputs}
    return pd.DataFrame(rows).astype(float)


def load_tbb() -> None:
    """Load what Ecos needs and comes as a package of its own, where the dynamic linker does not look."""
    tbb = next(file for file in metadata.files("tbb") or [] if file.name == "libtbb.so.12")
    ctypes.CDLL(str(tbb.locate()), ctypes.RTLD_GLOBAL)


def ecos(ssp: Exported, ticks: int) -> pd.DataFrame:
    """Ecos applies the parameter set that it is asked for by name."""
    load_tbb()
    from ecospy import EcosSimulation  # noqa: PLC0415

    rows: list[dict[str, float]] = []
    with EcosSimulation(ssp_path=ssp.path, step_size=ssp.h) as simulation:
        get = {"Real": simulation.get_real, "Integer": simulation.get_integer, "Boolean": simulation.get_bool}
        assert simulation.init(parameter_set=ssp.name)
        for tick in range(ticks + 1):
            if tick > 0:
                simulation.step()
            rows.append({f"{unit}.{name}": float(get[kind](f"{unit}::{name}")) for unit, name, kind in ssp.outputs})
    return pd.DataFrame(rows)


def libcosim(ssp: Exported, ticks: int) -> pd.DataFrame:
    """libcosim shows the values before the first step in time series only, which it has for no Booleans."""
    from libcosimpy.CosimEnums import CosimVariableType  # noqa: PLC0415
    from libcosimpy.CosimExecution import CosimExecution  # noqa: PLC0415
    from libcosimpy.CosimLogging import CosimLogLevel, log_output_level  # noqa: PLC0415
    from libcosimpy.CosimObserver import CosimObserver  # noqa: PLC0415

    log_output_level(CosimLogLevel.ERROR)
    execution = CosimExecution.from_ssp_file(ssp.path)
    index = {slave.name.decode(): slave.index for slave in execution.slave_infos()}
    references = {u: {v.name.decode(): v.reference for v in execution.slave_variables(i)} for u, i in index.items()}
    series, last = CosimObserver.create_time_series(), CosimObserver.create_last_value()
    execution.add_observer(series)
    execution.add_observer(last)
    first: dict[str, Any] = {"Real": series.time_series_real_samples, "Integer": series.time_series_integer_samples}
    now = {"Real": last.last_real_values, "Integer": last.last_integer_values, "Boolean": last.last_boolean_values}
    outputs = [(f"{u}.{n}", index[u], references[u][n], kind) for u, n, kind in ssp.outputs]
    for _, unit, reference, kind in outputs:
        if kind in first:
            assert series.start_time_series(unit, reference, CosimVariableType[kind.upper()])
    assert execution.step()
    start = {n: first[k](u, r, 0, 2)[2][0] if k in first else np.nan for n, u, r, k in outputs}
    rows = [start]
    for tick in range(1, ticks + 1):
        if tick > 1:
            assert execution.step()
        rows.append({name: float(now[kind](unit, [reference])[0]) for name, unit, reference, kind in outputs})
    return pd.DataFrame(rows)


if __name__ == "__main__":
    tool, path, length, target = sys.argv[1:]
    {"fmpy": fmpy, "ecos": ecos, "libcosim": libcosim}[tool](Exported(path), int(length)).to_parquet(Path(target))
