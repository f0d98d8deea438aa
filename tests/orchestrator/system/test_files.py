"""Files that people write: read, checked, and refused with everything that is wrong."""

from __future__ import annotations

import pytest
from pydantic import BaseModel, ConfigDict

from components.interfaces.problem import RequestError
from orchestrator.system.files import Given, checked, read_toml


def test_text_that_is_no_toml_is_told_with_its_line(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text("title = 'x'\n[experiment\n")
    with pytest.raises(RequestError, match=r"mine.toml: found text that is no TOML \(.*line 2.*\); valid: a TOML file"):
        read_toml(path)


def test_a_file_that_cannot_be_read_is_told(tmp_path):
    with pytest.raises(RequestError, match=r"mine.toml: found no such file; valid: a TOML file"):
        read_toml(tmp_path / "mine.toml")


class Wheel(BaseModel):
    """A table."""

    model_config = ConfigDict(extra="forbid", strict=True)

    size: Given
    parameters: dict[str, Given] = {}


class Car(BaseModel):
    """A file of tables."""

    model_config = ConfigDict(extra="forbid", strict=True)

    title: str
    wheels: dict[str, Wheel] = {}


SIZE = {"value": 0.3, "unit": "m", "source": "test"}
FORM = 'Write NAME = { value = ..., unit = "...", source = "..." }.'


def messages(**content):
    with pytest.raises(RequestError) as error:
        checked(Car, content, "car.toml")
    return str(error.value).splitlines()


def test_what_fits_becomes_the_model():
    found = checked(Car, {"title": "t", "wheels": {"left": {"size": SIZE}}}, "car.toml")
    assert found.wheels["left"].size == Given(value=0.3, unit="m", source="test")
    assert Given(value=1, source="test").unit == "1"


def test_everything_that_does_not_fit_is_told_at_once_with_its_place():
    assert messages(wheels={"left": {"size": {"unit": "m"}}}, titel="t") == [
        "car.toml: title: found nothing; valid: an entry of this name",
        f"car.toml: wheels.left.size.value: found nothing; valid: an entry of this name. {FORM}",
        "car.toml: titel: found an unknown entry; valid: title, wheels. Did you mean `title`?",
    ]


def test_the_names_that_are_valid_are_those_of_the_table():
    assert messages(title="t", wheels={"left": {"size": SIZE, "siz": SIZE}}) == [
        "car.toml: wheels.left.siz: found an unknown entry; valid: parameters, size. Did you mean `size`?"
    ]
    assert messages(title="t", wheels={"left": {"size": {**SIZE, "valeu": 1}}}) == [
        "car.toml: wheels.left.size.valeu: found an unknown entry; valid: source, unit, value. Did you mean `value`?"
    ]


def test_a_wrong_kind_of_value_is_told():
    assert messages(title=3) == ["car.toml: title: found `3`; valid: a valid string"]
    (text,) = messages(title="t", wheels={"left": {"size": SIZE, "parameters": {"k": 1.0}}})
    assert text == 'car.toml: wheels.left.parameters.k: found `1.0`; valid: { value = 1.0, unit = "..." }'
