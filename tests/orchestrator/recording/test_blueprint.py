"""Views of a screen as views of the viewer; what a recording's layout holds is shown in `test_comparison`."""

from __future__ import annotations

import pytest
import rerun.blueprint as rrb

from orchestrator.pictures import screen
from orchestrator.recording import blueprint

PAGE = screen.Panel("page", "About this run", "/about")


@pytest.mark.parametrize(
    ("kind", "container"),
    [("row", rrb.Horizontal), ("column", rrb.Vertical), ("grid", rrb.Grid), ("tabs", rrb.Tabs)],
)
def test_each_group_has_its_container(kind, container):
    assert type(blueprint._view(screen.ViewGroup(kind, [PAGE]), {})) is container


@pytest.mark.parametrize(
    ("view", "kind"),
    [
        (screen.Series("a", ["/signals/a"]), rrb.TimeSeriesView),
        (screen.Scenery("a", "/world", (0, 0, 1), (0, 0, 0), (0, 1, 0), [], ["/trail"]), rrb.Spatial3DView),
        (screen.Plane("a", "/friction", 1.0, 1.0, ["/past"], 2.0), rrb.Spatial2DView),
        (screen.Panel("states", "a", "/states"), rrb.StateTimelineView),
        (screen.Panel("log", "a", "/events"), rrb.TextLogView),
        (PAGE, rrb.TextDocumentView),
    ],
)
def test_each_view_has_its_view(view, kind):
    assert type(blueprint._view(view, {})) is kind


def test_an_axis_has_the_range_of_all_that_its_plot_shows():
    view = screen.Series("r [rad/s]", ["/signals/a", "/limits/a", "/signals/unknown"])
    seen = blueprint._view(view, {"/signals/a": (-0.6, 0.5), "/limits/a": (0.7, 0.7), "/signals/b": (0.0, 9.0)})
    low, high = seen.properties["ScalarAxis"].range.as_arrow_array().to_pylist()[0]
    assert -0.8 < low < -0.6
    assert 1.0 < high < 1.2
    assert "ScalarAxis" not in blueprint._view(view, {}).properties
