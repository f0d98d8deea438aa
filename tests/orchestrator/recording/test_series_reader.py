"""Series that are read back from a recording; whole runs are read in `test_comparison` and `test_repair`."""

from __future__ import annotations

import numpy as np

from orchestrator.pictures.screen import Panel, ViewGroup
from orchestrator.pictures.shapes import Page, SeriesValues
from orchestrator.recording.series_reader import read_series
from orchestrator.recording.stream import ShapeBatch, write


def test_series_have_each_tick_once_in_order_from_whatever_batches(tmp_path):
    def batch(ticks, values):
        return ShapeBatch(
            np.array(ticks), 0.1 * np.array(ticks), [SeriesValues(entity="/signals/a", values=np.array(values))]
        )

    layout = ViewGroup("tabs", [Panel("page", "about", "/about")])
    batches = [batch([4, 5], [[4.0, 40.0], [5.0, 50.0]]), batch([0, 2, 4], [[0.0, 0.0], [2.0, 20.0], [4.0, 40.0]])]
    write(tmp_path / "a.rrd", "a", layout, [Page(entity="/about", text="no series")], batches)
    found = read_series(tmp_path / "a.rrd")
    assert list(found) == ["/signals/a"]
    ticks, values = found["/signals/a"]
    assert ticks.tolist() == [0, 2, 4, 5]
    np.testing.assert_array_equal(values, [[0, 0], [2, 20], [4, 40], [5, 50]])
