"""A drive of `static` with an FMU as the plant, beside the scenario's own; this also shows `pictures/tracks.py`."""

from __future__ import annotations

import io

import numpy as np
import pytest
from PIL import Image

from orchestrator.exchange.passport import drive
from orchestrator.exchange.passport.drive import BESIDE_USUAL, FINISHES
from orchestrator.pictures.tracks import line_styles
from tests.orchestrator import foreign
from tests.orchestrator.exchange.passport.measured_fmus import told


def test_our_own_plant_drives_as_itself(built_fmus):
    lines, images = drive.lines(built_fmus / "fmi3" / "bicycle.fmu", None, lenient=False)
    found = told(lines)
    assert found[FINISHES.key] == ("passes", "11.3 s")
    assert found[BESIDE_USUAL.key][0] == "passes"
    assert found[BESIDE_USUAL.key][1].startswith(
        "from `bicycle` it is up to 0 m aside, and 0 m away at the same instant; "
    )
    pictures = [np.asarray(Image.open(io.BytesIO(image)).convert("RGB")) for image in images]
    assert len(pictures) == 2
    assert all(picture.shape[1] == 1080 and picture.std() > 10 for picture in pictures)


def test_a_plant_with_saturated_tyres_stays_beside_it(built_fmus):
    lines, _ = drive.lines(built_fmus / "fmi2" / "bicycle_saturated.fmu", None, lenient=False)
    assert [str(line.mark) for line in lines] == ["passes", "passes"]
    assert 0.05 < lines[1].figures["offset"].value < 1


def test_a_plant_that_steers_too_little_does_not(tmp_path):
    path = foreign.right_handed_mapping(tmp_path)
    lines, _ = drive.lines(path, None, lenient=False)
    assert [str(line.mark) for line in lines] == ["passes", "passes"]
    path.write_text(path.read_text().replace("ratio = { value = 16,", "ratio = { value = 4,"))
    lines, images = drive.lines(path, None, lenient=False)
    assert str(lines[1].mark) == "fails"
    assert len(images) == 2


def test_a_plant_that_ends_the_run_fails_and_its_rows_are_drawn(tmp_path):
    path = foreign.made(foreign.RateCar, tmp_path)
    lines, images = drive.lines(path, None, lenient=False)
    assert str(lines[0].mark) == "fails"
    assert images == []


@pytest.mark.parametrize("why", ["it does not fit the socket plant", "it does not run here"])
def test_where_there_is_no_drive_the_lines_say_why(tmp_path, why):
    lines, images = drive.lines(tmp_path / "m.fmu", why, lenient=False)
    assert set(told(lines).values()) == {("does not apply", why)}
    assert images == []


def test_both_drives_have_a_style_of_their_own():
    mine, usual = line_styles(["this FMU", "the scenario's plant"])
    assert mine != usual
