"""How a wrong request reads."""

from __future__ import annotations

import pickle

import pytest

from components.interfaces.problem import Gathered, Problem, RequestError, choices, did_you_mean, raise_if_any, refuse


def test_a_problem_says_where_what_what_would_be_valid_and_what_to_do():
    assert str(Problem("plant.m", "-1", "0 <= finite number")) == "plant.m: found -1; valid: 0 <= finite number"
    assert str(Problem("plant", "`car`", "bicycle", "Did you mean `bicycle`?")) == (
        "plant: found `car`; valid: bicycle. Did you mean `bicycle`?"
    )


def test_all_problems_are_raised_at_once_and_kept_as_data():
    problems = [Problem("a", "1", "2"), Problem("b", "3", "4")]
    with pytest.raises(RequestError) as caught:
        raise_if_any(iter(problems))
    assert str(caught.value) == "a: found 1; valid: 2\nb: found 3; valid: 4"
    assert caught.value.problems == tuple(problems)


def test_no_problem_raises_nothing():
    raise_if_any([])


def test_a_single_problem_is_an_error_to_raise():
    assert str(refuse("a", "1", "2", "Do it.")) == "a: found 1; valid: 2. Do it."


def test_choices_are_sorted_and_never_empty():
    assert choices(["b", "a"]) == "a, b"
    assert choices([]) == "nothing"


def test_the_closest_name_is_offered_and_nothing_far_off():
    assert did_you_mean("bycicle", ["bicycle", "stationary"]) == "Did you mean `bicycle`?"
    assert did_you_mean("zeppelin", ["bicycle", "stationary"]) == ""


@pytest.mark.parametrize("name", ["", "  "])
def test_a_thing_with_an_empty_name_is_quoted(name):
    assert str(refuse(name, "a value", "none")) == f'"{name}": found a value; valid: none'


def test_what_does_not_depend_on_each_other_is_gathered():
    def fail() -> int:
        raise refuse("a", "1", "2")

    wrong = Gathered()
    assert (wrong.attempt(lambda: 3, 0), wrong.attempt(fail, 0), wrong.attempt(fail, None)) == (3, 0, None)
    assert [str(problem) for problem in wrong.problems] == ["a: found 1; valid: 2"] * 2


def test_an_error_from_another_process_has_its_problems_and_its_words():
    error = RequestError([Problem("a", "b", "c", "d"), Problem("e", "f", "g")])
    there = pickle.loads(pickle.dumps(error))  # noqa: S301 - our own
    assert (there.problems, str(there)) == (error.problems, str(error))
