"""Feedthrough is honest: an input that is said not to reach an output does not move it by a single bit.

Shows `fmus/lowering.py`.
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from components import BLOCKS
from components.interfaces.record import pack
from fmus.lowering import lower


def element_names(variables) -> list[str]:
    return [name for v in variables for name in v.elements]


@pytest.mark.parametrize("kind", BLOCKS.values(), ids=BLOCKS)
@given(data=st.data())
def test_an_undeclared_input_does_not_move_an_output(kind, columns, instance, data):
    found = lower(kind)
    if not found.feedthrough.size or found.feedthrough.all():
        assert found.sampled  # a sampled block declares everything, so there is nothing to break
        return
    p, x = pack(instance(kind)), data.draw(columns(kind.states()))
    u, other = data.draw(columns(kind.inputs())), data.draw(columns(kind.inputs()))
    j = data.draw(st.integers(0, len(u) - 1))
    changed = u.copy()
    changed[j] = other[j]
    y, moved = (np.asarray(found.output(x, column, p)).ravel() for column in (u, changed))
    still = ~found.feedthrough[:, j]
    assert y[still].tobytes() == moved[still].tobytes()


def test_the_bicycle_declares_what_its_equations_say():
    kind = BLOCKS["bicycle"]
    reach = lower(kind).feedthrough
    inputs = element_names(kind.inputs())
    declared = {
        name: {inputs[j] for j in np.flatnonzero(row)}
        for name, row in zip(element_names(kind.outputs()), reach, strict=True)
    }
    delta_f, T_r = "actuation.delta_f", "actuation.T_r"
    assert declared == {
        **{f"state.{n}": set() for n in ("x", "y", "psi", "v_x", "v_y", "r")},
        "tyre.alpha_f": {delta_f},
        "tyre.alpha_r": set(),
        "tyre.F_cf": {delta_f},
        "tyre.F_cr": set(),
        "tyre.mu_f": {delta_f},
        "tyre.mu_r": {T_r},
        "motion.a_x": {delta_f, T_r},
        "motion.a_y": {delta_f},
        "motion.r_dot": {delta_f},
    }


@pytest.mark.parametrize("name", ["ramp_traffic", "empty_road", "stationary"])
def test_blocks_that_ignore_their_inputs_declare_none(name):
    assert not lower(BLOCKS[name]).feedthrough.any()


def test_the_traffic_that_shows_the_nearest_declares_the_place_of_the_ego_vehicle():
    kind = BLOCKS["dense_traffic"]
    reach = lower(kind).feedthrough
    assert reach.all(axis=0).tolist() == reach.any(axis=0).tolist()
    assert [n for n, through in zip(element_names(kind.inputs()), reach.T, strict=True) if through.all()] == [
        "ego.x",
        "ego.y",
    ]


@pytest.mark.parametrize("name", ["mpc", "coast"])
def test_sampled_blocks_declare_all_of_it(name):
    assert lower(BLOCKS[name]).feedthrough.all()


def test_what_is_declared_for_the_bicycle_does_move(instance):
    kind = BLOCKS["bicycle"]
    found, p = lower(kind), pack(instance(kind))
    x, u = np.array([0.0, 0.0, 0.1, 9.0, 0.3, 0.2]), np.array([0.1, 50.0])
    y = np.asarray(found.output(x, u, p)).ravel()
    for j in range(2):
        moved = np.asarray(found.output(x, u + 0.05 * np.eye(2)[j], p)).ravel()
        assert (moved != y).tolist() == found.feedthrough[:, j].tolist()
