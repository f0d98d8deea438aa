"""How an FMU fits a socket: what is found, what is said about it, and what is refused, with the exact words.

This also shows `relations.py`, `constants.py`, `adapted_interface.py`, `words.py` and `fitting_result.py`.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from components.interfaces.conversion import IDENTITY, Linear
from components.interfaces.items import Enumeration, Item
from components.interfaces.quantity import Quantity, Type
from components.interfaces.record import Variable
from components.interfaces.sockets import SOCKETS
from fmus.unit_interface import Interface
from orchestrator.mapping.fitting import fit
from orchestrator.mapping.mapping_reader import parse_mapping

UNITS = {"x": "m", "y": "m", "psi": "rad", "v_x": "m/s", "v_y": "m/s", "r": "rad/s"}
STATE = {f"state.{leaf}": unit for leaf, unit in UNITS.items()}
ACTUATION = {"actuation.delta_f": "rad", "actuation.T_r": "N.m"}


def variable(name, unit="", kind=Type.FLOAT64, shape=(), items=None):
    return Variable(name, Quantity(unit, name, kind, shape, enumeration=items))


def interface(inputs, outputs, *, undeclared=(), through=False, **starts):
    def made(found):
        return tuple(v if isinstance(v, Variable) else variable(v, found[v]) for v in found)

    ins, outs = made(inputs), made(outputs)
    feedthrough = np.full((len(outs), len(ins)), through)
    return Interface("theirs", ins, outs, (), feedthrough, False, starts, undeclared=frozenset(undeclared))  # noqa: FBT003


def fitted(socket, theirs, content=None):
    mapping = None if content is None else parse_mapping(content, "map.toml", socket, Path())
    return fit({"plant": "plant"}.get(socket, socket), SOCKETS[socket], theirs, "some/theirs.fmu", mapping)


def told(found):
    return [str(problem) for problem in found.problems]


def links(found):
    return {link.signal: link for link in (*found.adaptation.inputs, *found.adaptation.outputs)}


def test_what_fits_to_the_letter_needs_nothing():
    found = fitted("plant", interface(ACTUATION, STATE))
    assert (found.needed, found.problems, found.remarks) == (False, (), ())


def test_units_of_the_same_dimension_are_converted_and_told():
    theirs = interface({**ACTUATION, "actuation.delta_f": "deg"}, {**STATE, "state.v_x": "km/h", "state.r": "deg/s"})
    found = fitted("plant", theirs)
    assert told(found) == []
    assert links(found)["state.v_x"].relation == Linear(pytest.approx(1 / 3.6), 0.0)
    assert links(found)["state.r"].relation == Linear(pytest.approx(math.pi / 180), 0.0)
    assert found.remarks == (
        "plant.actuation.delta_f -> actuation.delta_f, [deg]",
        "plant.state.v_x <- state.v_x, [km/h]",
        "plant.state.r <- state.r, [deg/s]",
    )
    assert {v.name: v.quantity.unit for v in found.interface.outputs} == STATE


def test_a_remark_says_the_signal_that_was_decided_on():
    theirs = interface({**ACTUATION, "gear": ""}, {**STATE, "state.v_x": "km/h", "motion.a_x": "kg"})
    noticed = fitted("plant", theirs).noticed
    assert [(remark.text.split()[0], remark.signal) for remark in noticed] == [
        ("plant.state.v_x", "state.v_x"),
        ("plant.motion.a_x:", ""),
        ("plant:", ""),
    ]


def test_variables_whose_names_are_equally_good_are_told_and_none_is_taken():
    found = fitted("plant", interface({"u_delta_f": "rad"}, {"state_v_x": "m/s", "State.vx": "m/s"}))
    row = next(r for r in found.rows if r.signal.name == "state.v_x")
    assert (row.theirs, row.doubtful, row.note) == ("", ("State.vx", "state_v_x"), "could be `State.vx`, `state_v_x`")


def test_a_unit_that_is_not_declared_is_taken_as_ours_and_told():
    found = fitted("plant", interface(ACTUATION, {**STATE, "state.x": ""}))
    assert found.remarks == ("plant.state.x <- state.x, without a unit, taken as m",)
    assert links(found)["state.x"].relation == IDENTITY


def test_another_spelling_is_told_once_per_signal():
    found = fitted("plant", interface(ACTUATION, {name.replace("state.", "State_"): u for name, u in STATE.items()}))
    assert found.remarks[0] == "plant.state.x <- State_x, by its name"
    assert len(found.remarks) == 6


def test_another_dimension_is_refused():
    found = fitted("plant", interface(ACTUATION, {**STATE, "state.v_x": "kg", "state.y": "rad"}))
    valid = 'If the FMU declares its unit wrongly, say unit = "..." in a mapping file.'
    assert told(found) == [
        f"plant.state.y: found `state.y`: Float64 in `rad`; valid: a unit that converts to `m`. {valid}",
        f"plant.state.v_x: found `state.v_x`: Float64 in `kg`; valid: a unit that converts to `m/s`. {valid}",
    ]


def test_everything_that_is_missing_is_one_problem_with_a_remedy():
    found = fitted("plant", interface({"steer": "rad"}, {"state.x": "m", "state_y": "m", "StateY": "m", "n": "1"}))
    assert told(found) == [
        "plant: theirs.fmu: found no variable for actuation.delta_f (Float64 in `rad`), actuation.T_r (Float64 in "
        "`N.m`), state.y (Float64 in `m`; could be `StateY`, `state_y`), state.psi (Float64 in `rad`), state.v_x "
        "(Float64 in `m/s`), state.v_y (Float64 in `m/s`), state.r (Float64 in `rad/s`); valid: a variable for each "
        "among its inputs steer in rad; its outputs state.x in m, state_y in m, StateY in m, n in 1. `macrostep check "
        "some/theirs.fmu --socket plant --out FILE.toml` writes a mapping to fill in."
    ]


def test_inputs_of_its_own_keep_their_start_values_or_get_constants():
    theirs = interface({**ACTUATION, "gear": "", "grade": "deg"}, STATE)
    assert fitted("plant", theirs).remarks == (
        "plant: nothing drives gear, grade of theirs.fmu; start values are kept",
    )
    content = {"constants": {"gear": 3.0, "grade": {"value": 0.1, "unit": "rad"}}}
    found = fitted("plant", theirs, content)
    assert found.remarks == ()
    assert found.adaptation.held == {"gear": 3.0, "grade": pytest.approx(math.degrees(0.1))}


def test_what_it_shows_beyond_the_socket_stays_visible():
    found = fitted("plant", interface(ACTUATION, {**STATE, "engine.rpm": "rpm", "motion.a_x": "kg"}))
    assert [v.name for v in found.interface.outputs] == [*STATE, "engine.rpm"]
    assert found.remarks == ("plant.motion.a_x: `motion.a_x`: Float64 in `kg` is not used",)


def test_numbers_of_other_types_are_taken_where_values_fit():
    floats = [variable(n, u, Type.FLOAT32) for n, u in STATE.items()]
    found = fitted("plant", interface(ACTUATION, [*floats[:-1], variable("state.r", "", Type.INT32)]))
    assert told(found) == []
    assert found.remarks[0] == "plant.state.x <- state.x, Float32"
    assert found.remarks[-1] == "plant.state.r <- state.r, Int32"


BOXES = {"x": "m", "y": "m", "psi": "rad", "v": "m/s", "length": "m", "width": "m"}


def boxes(n, **others):
    found = {f"obstacles[{i}].{leaf}": unit for i in range(1, n + 1) for leaf, unit in BOXES.items()}
    return {**found, **{f"obstacles[{i}].{leaf}": u for i in range(1, n + 1) for leaf, u in others.items()}}


def test_structures_of_obstacles_fill_the_first_slots_and_are_numbered():
    found = fitted("traffic", interface({}, boxes(3, valid="")))
    assert told(found) == []
    assert links(found)["obstacles.v"].theirs == tuple((f"obstacles[{i}].v", 0) for i in (1, 2, 3))
    assert found.adaptation.constants == {"obstacles.id": [1, 2, 3, 0, 0, 0, 0, 0]}
    assert found.remarks[0] == (
        "traffic.obstacles.valid <- obstacles[1].valid, obstacles[2].valid, obstacles[3].valid, Float64, 3 of 8 slots"
    )
    assert found.remarks[-1] == "traffic.obstacles.id: not shown by theirs.fmu, numbered from 1"
    assert {v.shape for v in found.interface.outputs} == {(8,)}


def test_obstacles_of_which_nothing_says_whether_they_are_there_are_refused():
    (problem,) = told(fitted("traffic", interface({}, boxes(3))))
    assert problem.startswith(
        "traffic: theirs.fmu: found no variable for obstacles.valid (Boolean in `1` of shape (8));"
    )
    found = fitted("traffic", interface({}, boxes(3)), {"obstacles": {"valid": {"constant": [True] * 3 + [False] * 5}}})
    assert told(found) == []


def test_a_controller_that_does_not_see_the_ego_vehicle_is_refused():
    (problem,) = told(fitted("controller", interface({"speed": "m/s"}, ACTUATION)))
    assert problem.startswith("controller: theirs.fmu: found no variable for ego.x (Float64 in `m`), ego.y")
    found = fitted("controller", interface({"ego.v_x": "m/s"}, ACTUATION))
    assert told(found) == []
    assert found.remarks == ("controller: theirs.fmu does not see the obstacles",)
    assert [v.name for v in found.interface.inputs] == ["ego.v_x"]


def test_an_enumeration_with_other_items_is_left_out():
    status = variable(
        "solver.status", "1", Type.ENUMERATION, items=Enumeration("Other", (Item("good", 0), Item("bad", 1)))
    )
    found = fitted("controller", interface({"ego.x": "m"}, [variable(n, u) for n, u in ACTUATION.items()] + [status]))
    assert told(found) == []
    assert found.remarks[0] == "controller.solver.status: the enumeration {'good': 0, 'bad': 1} is not used"


def test_a_plan_has_the_length_that_the_controller_gives_it():
    plan = [variable(f"plan.{leaf}", "m", shape=(20,)) for leaf in ("x", "y")]
    found = fitted("controller", interface({"ego.x": "m"}, [*(variable(n, u) for n, u in ACTUATION.items()), *plan]))
    assert {v.name: v.shape for v in found.interface.outputs if v.shape} == {"plan.x": (20,), "plan.y": (20,)}
    assert found.needed is False


def test_a_constant_has_no_length_that_an_array_of_open_length_could_take():
    theirs = interface({"ego.x": "m"}, ACTUATION)
    found = fitted("controller", theirs, {"plan": {"x": {"constant": {"value": 1.0, "unit": "m"}}}})
    assert told(found) == ["map.toml: plan.x.constant: found shape (); valid: shape (-1,)"]


def test_dependencies_that_are_not_declared_follow_the_socket():
    found = fitted("plant", interface(ACTUATION, STATE, undeclared=STATE, through=True))
    assert found.remarks == (
        "plant: theirs.fmu says not what its outputs depend on; as in the socket `plant`, inputs act through the step",
    )
    assert not found.interface.feedthrough.any()
    assert found.needed
    declared = fitted("plant", interface(ACTUATION, STATE, through=True))
    assert declared.interface.feedthrough.all()
    assert not fitted(
        "plant", interface(ACTUATION, STATE, through=True), {"feedthrough": False}
    ).interface.feedthrough.any()
    controller = fitted("controller", interface({"ego.x": "m"}, ACTUATION, undeclared=ACTUATION, through=True))
    assert controller.interface.feedthrough.all()


THEIRS = interface({"wheel": "deg", "pedal": "", "brake": ""}, {"X": "m", "v": "km/h", "slip": "deg", "a": "m/s2"})


def entry(text_bus, text_leaf, **value):
    return {text_bus: {text_leaf: value}}


def amount(value, unit="1"):
    return {"value": value, "unit": unit}


@pytest.mark.parametrize(
    ("content", "signal", "relation"),
    [
        (entry("state", "x", variable="X", offset=amount(2, "m")), "state.x", Linear(1, 2)),
        (entry("state", "x", variable="X", factor=-2), "state.x", Linear(-2, 0)),
        (entry("state", "x", variable="X", unit="km"), "state.x", Linear(1000, 0)),
        (entry("state", "x", variable="v", factor=amount(10, "s")), "state.x", Linear(10 / 3.6, 0)),
        ({"axes": "y_right", **entry("state", "y", variable="X", offset=amount(3, "m"))}, "state.y", Linear(-1, -3)),
        ({"axes": "y_right", **entry("state", "x", variable="X")}, "state.x", Linear(1, 0)),
        (
            entry("actuation", "delta_f", variable="wheel", **{"as": "steering_wheel_angle", "ratio": 16}),
            "actuation.delta_f",
            Linear(math.pi / 180 / 16, 0),
        ),
        (
            entry("actuation", "T_r", variable="pedal", unit="N.m", **{"as": "axle_torque"}),
            "actuation.T_r",
            Linear(0.5, 0),
        ),
        (
            entry("actuation", "T_r", variable="pedal", unit="kN", **{"as": "wheel_force", "R_w": amount(30, "cm")}),
            "actuation.T_r",
            Linear(300, 0),
        ),
        (
            entry("actuation", "T_r", variable="pedal", **{"as": "force", "R_w": amount(0.3, "m")}),
            "actuation.T_r",
            Linear(0.15, 0),
        ),
        (
            entry(
                "actuation",
                "T_r",
                variable="pedal",
                **{"as": "acceleration", "R_w": amount(0.3, "m"), "m": amount(2, "t")},
            ),
            "actuation.T_r",
            Linear(300, 0),
        ),
        (entry("actuation", "T_r", variable="pedal", factor=amount(0.4, "kN.m")), "actuation.T_r", Linear(400, 0)),
    ],
)
def test_an_entry_means_a_linear_relation(content, signal, relation):
    found = links(fitted("plant", THEIRS, content))[signal].relation
    assert [found.factor, found.offset] == pytest.approx([relation.factor, relation.offset])


def test_one_signal_may_go_to_several_inputs_within_limits():
    both = [
        {"variable": "pedal", "factor": amount(400, "N.m"), "min": amount(0)},
        {"variable": "brake", "factor": amount(-300, "N.m"), "min": amount(0), "max": amount(1)},
    ]
    found = fitted("plant", THEIRS, {"actuation": {"T_r": both}})
    made = [link for link in found.adaptation.inputs if link.signal == "actuation.T_r"]
    assert [(link.theirs[0][0], link.relation.factor, link.low, link.high) for link in made] == [
        ("pedal", 400, 0, math.inf),
        ("brake", -300, 0, 1),
    ]


def problems_of(content, theirs=THEIRS):
    """Without what is missing, which is not the point here."""
    return [text for text in told(fitted("plant", theirs, content)) if "no variable for" not in text]


@pytest.mark.parametrize(
    ("content", "text"),
    [
        (entry("state", "x", variable="x"), "map.toml: state.x: found the unknown variable `x`; valid: X, a, slip, v"),
        (
            entry("state", "psi", variable="slipp"),
            "map.toml: state.psi: found the unknown variable `slipp`; valid: X, a, slip, v. Did you mean `slip`?",
        ),
        (
            entry("state", "x", variable="v"),
            "map.toml: state.x: found `v`: Float64 in `km/h`; valid: a unit that converts to `m`. If the FMU declares "
            'its unit wrongly, say unit = "..." in a mapping file.',
        ),
        (
            entry("state", "x", variable="v", factor=amount(1, "kg")),
            "map.toml: state.x: found `v`: Float64 in `km/h`, times a factor in `kg`; valid: `m`",
        ),
        (
            entry("state", "x", variable="X", offset=amount(1, "s")),
            "map.toml: state.x.offset: found unit `s`; valid: a unit that converts to `m`",
        ),
        (
            entry("state", "x", variable="X", factor=0),
            "map.toml: state.x.factor: found 0; valid: a finite number other than 0",
        ),
        (
            entry("actuation", "T_r", variable="pedal", **{"as": "force", "R_w": amount(0.3, "kg")}),
            "map.toml: actuation.T_r.R_w: found unit `kg`; valid: a unit that converts to `m`",
        ),
        (
            entry("actuation", "T_r", variable="pedal", **{"as": "force", "R_w": amount(-1, "m")}),
            "map.toml: actuation.T_r.R_w: found -1; valid: a positive number",
        ),
        (
            entry("state", "v_y", unused=True),
            "map.toml: state.v_y: found unused; valid: a variable or a constant: the socket `plant` asks for it",
        ),
        (
            entry("state", "v_y", constant=amount(0, "kg")),
            "map.toml: state.v_y.constant: found unit `kg`; valid: a unit that converts to `m/s`",
        ),
        (
            entry("actuation", "T_r", constant=amount(0, "N.m")),
            "map.toml: actuation.T_r.constant: found a constant for a signal that the FMU reads; "
            "valid: { unused = true }",
        ),
        (
            {"constants": {"pedall": 0.0}},
            "map.toml: constants.pedall: found an unknown input; valid: brake, pedal, wheel. Did you mean `pedal`?",
        ),
        (
            {"actuation": {"T_r": "pedal"}, "constants": {"pedal": 0.0}},
            "map.toml: constants.pedal: found a constant for an input that a signal drives; valid: one of the two",
        ),
        (
            {"actuation": {"T_r": ["pedal", "pedal"]}},
            "plant: pedal of theirs.fmu: found two signals that drive it; valid: one",
        ),
        (
            {"state": {"reference": {"point": "rear_axle", "distance": amount(1, "s")}}},
            "map.toml: state.reference.distance: found unit `s`; valid: a unit that converts to `m`",
        ),
        (
            {"state": {"reference": {"point": "rear_axle", "distance": amount("1.4", "m")}}},
            "map.toml: state.reference.distance: found `1.4`; valid: a finite number",
        ),
        (
            {"actuation": {"T_r": {"variable": "pedal", "max": amount(10**400, "N.m")}}},
            f"map.toml: actuation.T_r.max: found {10**400}; valid: a finite number",
        ),
        (
            {"state": {"x": "?", "psi": "?"}},
            "map.toml: found nothing filled in yet for state.x, state.psi; valid: a variable for each among its inputs "
            "wheel in deg, pedal, brake; its outputs X in m, v in km/h, slip in deg, a in m/s2",
        ),
    ],
)
def test_a_wrong_entry_is_told_with_file_and_key(content, text):
    assert problems_of(content) == [text]


def test_all_wrong_entries_are_told_at_once():
    content = {
        "state": {"x": "nope", "psi": {"variable": "a"}, "v_x": {"variable": "v", "offset": amount(1, "m")}},
        "constants": {"nope": 1.0},
    }
    assert len(problems_of(content)) == 4


def test_an_input_may_be_unused_on_purpose():
    found = fitted("plant", interface({"actuation.delta_f": "rad"}, STATE), {"actuation": {"T_r": {"unused": True}}})
    assert told(found) == []
    assert [v.name for v in found.interface.inputs] == ["actuation.delta_f"]


def test_speed_and_slip_angle_take_the_places_of_the_components():
    content = {"axes": "y_right", "state": {"velocity": "speed_and_slip", "v": "v", "beta": "slip"}}
    found = links(fitted("plant", THEIRS, content))
    assert found["state.v_x"].relation.factor == pytest.approx(1 / 3.6)
    assert found["state.v_y"].relation.factor == pytest.approx(-math.pi / 180)


def test_patterns_and_lists_name_the_elements_of_an_array():
    theirs = interface({}, {f"obj[{i}].pos": "m" for i in range(4)} | {"more": "m"})
    for wanted in ("obj[*].pos", [f"obj[{i}].pos" for i in range(4)]):
        found = links(fitted("traffic", theirs, {"obstacles": {"x": wanted}}))["obstacles.x"]
        assert found.theirs == tuple((f"obj[{i}].pos", 0) for i in range(4))
    array = interface({}, [variable("pos", "m", shape=(12,))])
    found = links(fitted("traffic", array, {"obstacles": {"x": [f"pos[{i}]" for i in (3, 1)]}}))["obstacles.x"]
    assert found.theirs == (("pos", 2), ("pos", 0))
    text = told(fitted("traffic", array, {"obstacles": {"x": "pos"}}))[0]
    assert text == "map.toml: obstacles.x: found 12 elements in `pos`; valid: up to 8 elements"
