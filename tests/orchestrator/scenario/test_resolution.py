"""Which value each declared parameter gets, where it is from, and all that is wrong, at once."""

from __future__ import annotations

import pytest
from hypothesis import given as examples
from hypothesis import strategies as st

from components.interfaces.quantity import Quantity, Type
from components.interfaces.record import Variable, variables
from orchestrator.scenario.parameters import parameter_set
from orchestrator.scenario.resolution import Setting, resolve
from orchestrator.system.files import Given
from orchestrator.system.scene import Scene

UNITS = {"mass": "kg", "gain": "1", "places": "m", "open": "1"}
DECLARED = [
    Variable("mass", Quantity("kg", "mass", min=1)),
    Variable("gain", Quantity("1", "gain")),
    Variable("places", Quantity("m", "places", shape=(3,))),
    Variable("open", Quantity("1", "whether it is open", Type.BOOLEAN)),
]


def values(source, units=(), **given):
    """Values in the units of measurement that are declared, or in others."""
    units = {**UNITS, **dict(units)}
    return {n: Given(value=v, unit=units.get(n, "1"), source=source) for n, v in given.items()}


def settings(**given):
    """Whole values, as `--set` gives them."""
    return [Setting("car", f"{name}={_text(value)}") for name, value in given.items()]


def _text(value):
    return str(value).lower() if isinstance(value, bool) else str(value)


def element(index, value, name="places"):
    return Setting("car", f"{name}[{index}]={value}")


def messages(*layers, declared=DECLARED):
    return [str(problem) for problem in resolve("car", declared, *layers).problems]


DEFAULTS = values("file", mass=1500.0, gain=1.0, places=[1.0, 2.0, 3.0], open=False)


def test_defaults_lie_under_what_is_given_and_that_under_what_is_set():
    found = resolve("car", DECLARED, DEFAULTS, values("scenario", gain=2.0, open=True), settings(open=False))
    assert found.values == {"mass": 1500.0, "gain": 2.0, "places": [1.0, 2.0, 3.0], "open": False}
    assert found.sources == {
        "car.mass": {"value": 1500.0, "unit": "kg", "source": "file"},
        "car.gain": {"value": 2.0, "unit": "1", "source": "scenario"},
        "car.places": {"value": [1.0, 2.0, 3.0], "unit": "m", "source": "file"},
        "car.open": {"value": False, "unit": "1", "source": "--set"},
    }
    assert found.problems == []


def test_what_nobody_gives_has_no_value():
    found = resolve("car", DECLARED, given=values("scenario", mass=1.0))
    assert found.values == {"mass": 1.0}
    assert [*found.sources] == [found.path("mass")] == ["car.mass"]
    assert resolve("car", []).values == {}


@pytest.mark.parametrize("layer", ["given", "settings"])
def test_a_shorter_array_leaves_the_rest_as_it_was(layer):
    upper = {"given": values("above", places=[7.0]), "settings": settings(places=[7.0])}
    found = resolve("car", DECLARED, DEFAULTS, **{layer: upper[layer]})
    assert found.values["places"] == [7.0, 2.0, 3.0]
    assert found.problems == []
    assert DEFAULTS["places"].value == [1.0, 2.0, 3.0], "the file's own list stays as it is"


def test_values_that_a_shorter_list_keeps_are_told_unless_they_are_alike():
    assert resolve("car", DECLARED, DEFAULTS, {}, settings(places=[7.0])).remarks == [
        "car.places: --set gives the first 1 of 3 values; the others stay as they were: 2.0, 3.0"
    ]
    assert resolve("car", DECLARED, DEFAULTS, {}, settings(places=[7.0, 8.0])).remarks == []
    assert resolve("car", DECLARED, values("file", places=[1.0, 0.0, 0.0]), {}, settings(places=[7.0])).remarks == []


def test_an_array_that_stays_too_short_or_is_too_long_is_told():
    assert messages(None, values("scenario", places=[7.0])) == ["car.places: found shape (1,); valid: shape (3,)"]
    assert messages(DEFAULTS, {}, settings(places=[1.0] * 4)) == ["car.places: found shape (4,); valid: shape (3,)"]


def test_elements_are_set_by_their_index_one_after_the_other():
    found = resolve("car", DECLARED, DEFAULTS, {}, [element(3, 9.0), element(1, 8.0), element(3, 10.0)])
    assert found.values["places"] == [8.0, 2.0, 10.0]
    assert found.sources["car.places"] == {"value": [8.0, 2.0, 10.0], "unit": "m", "source": "--set"}
    assert DEFAULTS["places"].value == [1.0, 2.0, 3.0], "the file's own list stays as it is"


@pytest.mark.parametrize(
    ("setting", "text"),
    [
        (element(0, 1.0), "car.places[0]: found no such element; valid: 1 to 3"),
        (element(4, 1.0), "car.places[4]: found no such element; valid: 1 to 3"),
        (element(1, 1.0, "mass"), "car.mass[1]: found no such element; valid: a scalar parameter"),
        (element(2, "far"), "car.places[2]: found `far` (not a number); valid: finite number [m]"),
    ],
)
def test_an_element_that_is_not_there_or_has_a_wrong_value_is_told(setting, text):
    found = resolve("car", DECLARED, DEFAULTS, {}, [setting])
    assert [str(p) for p in found.problems] == [text]
    assert found.values["places"] == [1.0, 2.0, 3.0]


def test_an_unknown_name_is_told_unless_it_is_a_default_of_others():
    valid = "gain, mass, open, places"
    assert messages(values("file", width=1.0)) == []
    assert messages({}, values("scenario", gian=1.0)) == [
        f"car.gian: found an unknown parameter; valid: {valid}. Did you mean `gain`?"
    ]
    assert messages({}, {}, [*settings(mas=1.0), element(1, 0.0, "place")]) == [
        f"car.mas: found an unknown parameter; valid: {valid}. Did you mean `mass`?",
        f"car.place[1]: found an unknown parameter; valid: {valid}. Did you mean `places`?",
    ]


@pytest.mark.parametrize("layer", [0, 1])
def test_a_wrong_unit_of_measurement_is_told_in_either_file(layer):
    layers = [{}, {}]
    layers[layer] = values("file", {"mass": "m"}, mass=1.5)
    assert messages(*layers) == ["car.mass: found unit `m`; valid: unit `kg`"]
    assert resolve("car", DECLARED, *layers).values == {}


def test_another_unit_of_the_same_dimension_is_converted_and_what_was_written_is_kept():
    given = values("mine.toml", {"mass": "t", "places": "cm"}, mass=1.5, places=[100, 250.0, 3])
    found = resolve("car", DECLARED, DEFAULTS, given)
    assert found.problems == []
    assert found.values == {**found.values, "mass": 1500.0, "places": [1.0, 2.5, 0.03]}
    assert found.sources["car.mass"] == {"value": 1500.0, "unit": "kg", "source": "mine.toml: 1.5 t"}
    assert resolve("car", DECLARED, {}, values("", {"mass": "t"}, mass=1.5)).sources["car.mass"]["source"] == "1.5 t"
    no_numbers = values("file", {"mass": "t", "open": "m"}, mass="heavy", open=True)
    assert messages({}, no_numbers) == [
        "car.mass: found unit `t`; valid: unit `kg`",
        "car.open: found unit `m`; valid: unit `1`",
    ]


def test_what_is_set_is_in_the_parameter_s_own_unit():
    found = resolve("car", DECLARED, {}, {}, settings(mass=1200.0))
    assert found.sources == {"car.mass": {"value": 1200.0, "unit": "kg", "source": "--set"}}


def test_only_the_value_that_wins_is_checked():
    assert messages(values("file", mass=-1.0), values("scenario", mass=2.0)) == []
    assert messages(values("file", mass=2.0), values("scenario", mass=-1.0)) == [
        "car.mass: found -1.0; valid: 1 <= finite number [kg]"
    ]


def test_all_problems_come_at_once():
    given = values("scenario", {"gain": "m"}, gain=1.0, colour=1.0, open=3.0)
    assert messages(DEFAULTS, given, [*settings(mass="heavy", wheels=4), element(9, 0.0)]) == [
        "car.gain: found unit `m`; valid: unit `1`",
        "car.colour: found an unknown parameter; valid: gain, mass, open, places",
        "car.wheels: found an unknown parameter; valid: gain, mass, open, places",
        "car.places[9]: found no such element; valid: 1 to 3",
        "car.mass: found `heavy` (not a number); valid: 1 <= finite number [kg]",
        "car.open: found `3.0` (number); valid: true or false",
    ]


numbers = st.floats(1, 1e6)
layers = st.fixed_dictionaries(
    {}, optional={"mass": numbers, "gain": numbers, "places": st.lists(numbers, min_size=1, max_size=4)}
)


@examples(default=layers, given=layers, chosen=layers, elements=st.dictionaries(st.integers(1, 3), numbers))
def test_the_uppermost_layer_wins_and_every_value_has_a_source(default, given, chosen, elements):
    if max(len(layer.get("places", ())) for layer in (default, given, chosen)) < 3:
        elements = {}  # there is no whole array whose elements could be set
    setting = [*settings(**chosen), *(element(i, value) for i, value in elements.items())]
    found = resolve("car", DECLARED, values("file", **default), values("scenario", **given), setting)

    expected, origins = {}, {}
    for source, layer in (("file", default), ("scenario", given), ("--set", chosen)):
        for name, value in layer.items():
            below = expected.get(name)
            expected[name] = [*value, *(below or [])[len(value) :]] if name == "places" else value
            origins[name] = source
    for index, value in elements.items():
        expected["places"][index - 1] = value
        origins["places"] = "--set"
    assert found.values == expected
    assert {path: told["source"] for path, told in found.sources.items()} == {
        f"car.{name}": source for name, source in origins.items()
    }
    assert {path: told["value"] for path, told in found.sources.items()} == {
        f"car.{name}": value for name, value in expected.items()
    }
    assert all(told["unit"] == UNITS[path.removeprefix("car.")] for path, told in found.sources.items())
    whole = len(expected.get("places", [0.0] * 3)) == 3
    assert [problem.where for problem in found.problems] == ([] if whole else ["car.places"])


def test_a_unit_that_differs_is_told():
    given = {"ego_length": Given(value=460.0, unit="kg", source="test")}
    problems = resolve("scene", variables(Scene), parameter_set("scene"), given).problems
    assert [str(p) for p in problems] == ["scene.ego_length: found unit `kg`; valid: unit `m`"]


def test_an_unknown_name_is_told_once_also_where_a_file_holds_it_for_others():
    both = values("file", wings=2.0)
    assert messages(both, both) == ["car.wings: found an unknown parameter; valid: gain, mass, open, places"]


@pytest.mark.parametrize("before", [[], [[1.0, 2.0]], [3.0]], ids=["nothing", "too few", "one number"])
def test_an_element_of_an_array_without_values_is_refused(before):
    set_before = [Setting("car", f"places={value}") for value in before]
    found = resolve("car", DECLARED, settings=[*set_before, element(3, 5.0)])
    assert str(found.problems[0]) == (
        "car.places[3]: found an element of an array whose others have no values; valid: 3 values. "
        "Give all of them first: --set car.places=[...]."
    )
