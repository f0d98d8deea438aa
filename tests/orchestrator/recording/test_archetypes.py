"""Shapes and styles as archetypes; what they hold is shown in `test_stream`, from recordings that are read back."""

from __future__ import annotations

import numpy as np
import pytest

from orchestrator.pictures import shapes
from orchestrator.recording import archetypes


class Sent(list):
    """Takes what would be sent."""

    def send_columns(self, entity, times, columns):
        self.append((entity, [len(list(time.as_arrow_array())) for time in times]))

    def log(self, entity, archetype, *, static):
        self.append((entity, static))


def test_a_shape_is_sent_at_its_own_rows_and_one_without_rows_not_at_all():
    sent, ticks = Sent(), np.arange(4)
    some, none = np.array([True, False, True, False]), np.zeros(4, dtype=bool)
    drawn = [
        shapes.SeriesValues(entity="/all", values=np.zeros(4)),
        shapes.SeriesValues(entity="/some", rows=some, values=np.zeros(2)),
        shapes.SeriesValues(entity="/none", rows=none, values=np.zeros(0)),
        shapes.Page(entity="/page", text="a"),
    ]
    archetypes.send_shapes(sent, ticks, 0.1 * ticks, drawn)
    assert sent == [("/all", [4, 4]), ("/some", [2, 2]), ("/page", True)]


def test_an_unknown_shape_or_style_is_an_error():
    with pytest.raises(TypeError, match="Shape"):
        archetypes.send_shapes(Sent(), np.arange(1), np.zeros(1), [shapes.Shape(entity="/a")])
    with pytest.raises(TypeError, match="Style"):
        archetypes.send_style(Sent(), shapes.Style(entity="/a"))
