"""A sweep in the viewer: what it serves, and what the real viewer shows of it.

Shows `sweep_view.py`, `recording/catalog.py` and what `show_command.py` does with the folder of a sweep.
"""

from __future__ import annotations

import io
import json
import shutil
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pandas as pd
import pytest
from PIL import Image
from rerun.catalog import CatalogClient
from rerun.experimental import ViewerClient

from components.interfaces.problem import RequestError
from orchestrator.pictures import palette
from orchestrator.scenario.options import Options
from orchestrator.sweeping import sweep_folder
from orchestrator.sweeping.sweep import sweep
from orchestrator.sweeping.sweep_view import _catalog, show_sweep
from orchestrator.viewing.photograph import Look, headless_viewer
from tests.waiting import wait_until

TABLE = "metrics"


@pytest.fixture(scope="module")
def swept(built_fmus, tmp_path_factory):
    out = tmp_path_factory.mktemp("view") / "static-sweep-1"
    asked = {"samples": "lhs:8", "options": Options(stop_time=4.0), "keep": ["worst:2"]}
    sweep("static", {"plant.m": "1500:2500"}, **asked, out=out, executor=ThreadPoolExecutor(2))
    return out


def served(folder, scratch):
    scratch.mkdir(exist_ok=True)
    return _catalog(folder, sweep_folder.asked(folder), sweep_folder.read_results(folder), [], scratch, lambda _: None)


def test_the_catalog_has_all_variants_the_worst_first_with_links_to_the_runs_that_are_kept(swept, tmp_path):
    with served(swept, tmp_path) as url:
        client = CatalogClient(url.partition("/entry/")[0])
        assert sorted(client.dataset_names()) == ["all variants", "kept runs", "kept runs together"]
        table = client.get_table(TABLE).reader().to_pandas()
        segments = client.get_dataset("kept runs").segment_ids()
    kept = list(sweep_folder.kept_runs(swept, sweep_folder.asked(swept)))
    assert sorted(table["variant"]) == list(range(8))
    assert list(table["variant"][:2]) == kept
    assert all(link.startswith("rerun+http://127.0.0.1:") for link in table["recording"][:2])
    assert table["recording"][2:].isna().all()
    assert [link.partition("segment_id=")[2].rpartition("-")[0] for link in table["recording"][:2]] == [
        f"variant-{number}" for number in kept
    ]
    assert sorted(segment.rpartition("-")[0] for segment in segments) == sorted(f"variant-{n}" for n in kept)
    assert {"plant/m", "gap_edge", "no_contact", "fault"} <= set(table.columns)
    known = sweep_folder.read_results(swept).set_index("variant")
    for row in table.to_dict("records"):
        assert row["gap_edge"] == known["gap_edge"][row["variant"]]


@pytest.mark.viewer
@pytest.mark.slow
def test_the_viewer_opens_the_table_and_a_link_opens_a_run_in_its_own_layout(swept, graphics, tmp_path):
    with served(swept, tmp_path) as url, headless_viewer() as (viewer_url, _):
        client = CatalogClient(url.partition("/entry/")[0])
        table = client.get_table(TABLE).reader().to_pandas()
        viewer = wait_until(lambda: connected(viewer_url))
        viewer.open(url)
        wait_until(lambda: viewer.get_state().location == url)
        viewer.open(table["recording"][0])
        wait_until(lambda: len(viewer.get_state().views) > 20)  # the viewer's own choice has about a dozen


def connected(url):
    try:
        return ViewerClient.connect(url)
    except (RuntimeError, OSError):
        return None


@pytest.mark.viewer
@pytest.mark.slow
def test_its_pictures_show_the_table_the_bands_and_the_runs(swept, graphics, macrostep, tmp_path):
    pictures = {}
    for tab in ("metrics", "bands", "runs"):
        file = tmp_path / f"{tab}.png"
        assert macrostep("show", str(swept), "--picture", str(file), "--tab", tab)[0] == 0
        pictures[tab] = np.asarray(Image.open(io.BytesIO(file.read_bytes())).convert("RGB")).astype(int)
    colours = {"bands": palette.SERIES[:2], "runs": palette.RUNS[:2]}
    for tab, wanted in colours.items():
        for colour in wanted:
            assert (np.abs(pictures[tab] - colour).max(axis=-1) < 12).sum() > 200, (tab, colour)
            assert (np.abs(pictures["metrics"] - colour).max(axis=-1) < 12).sum() < 200, colour
    assert (pictures["metrics"].max(axis=-1) > 150).sum() > 5000, "no text"


def test_a_sweep_that_has_not_ended_is_refused(swept, tmp_path):
    folder = tmp_path / "stopped"
    folder.mkdir()
    for name in ("manifest.json", "sweep.json"):
        (folder / name).write_bytes((swept / name).read_bytes())
    with pytest.raises(RequestError, match="a sweep that was stopped; valid: a sweep that has ended"):
        show_sweep(folder, [], print, picture=tmp_path / "a.png")


@pytest.mark.parametrize(
    ("name", "content", "told"),
    [
        ("metrics.parquet", pd.DataFrame({"variant": [1]}), "metrics.parquet: found a damaged file (without"),
        ("bands.parquet", pd.DataFrame({"signal": ["a"]}), "bands.parquet: found a damaged file (without"),
        ("sweep.json", {"kept": {"x": "variant-0"}}, "sweep.json: found a file that says not what was asked ("),
        ("sweep.json", {"kept": []}, "sweep.json: found a file that says not what was asked ("),
    ],
)  # fmt: skip
def test_files_with_another_content_are_refused(swept, tmp_path, name, content, told):
    folder = tmp_path / "other"
    shutil.copytree(swept, folder)
    if isinstance(content, dict):
        known = json.loads((folder / name).read_text())
        (folder / name).write_text(json.dumps({**known, **content}))
    else:
        content.to_parquet(folder / name)
    with pytest.raises(RequestError) as error:
        show_sweep(folder, [], print, picture=tmp_path / "a.png", look=Look(tab="bands"))
    assert told in str(error.value)


def test_what_cannot_be_shown_so_is_refused(swept, macrostep, tmp_path):
    picture = ("--picture", str(tmp_path / "a.png"))
    _, _, said = macrostep("show", str(swept), *picture, "--tab", "metrics", "--at", "1")
    assert "--at: found it beside --tab metrics; valid: --tab bands, or a tab of the runs that are kept" in said
    _, _, said = macrostep("show", str(swept), str(swept), *picture)
    assert "found a sweep beside something else; valid: runs, or one sweep" in said


def test_a_sweep_without_run_folders_has_a_table_and_no_picture_of_runs(swept, tmp_path):
    folder = tmp_path / "bare"
    folder.mkdir()
    for name in ("manifest.json", "metrics.parquet", "bands.parquet"):
        (folder / name).write_bytes((swept / name).read_bytes())
    content = json.loads((swept / "sweep.json").read_text())
    (folder / "sweep.json").write_text(json.dumps({**content, "kept": {}}))
    with served(folder, tmp_path / "scratch") as url:
        client = CatalogClient(url.partition("/entry/")[0])
        assert client.dataset_names() == ["all variants"]
        assert client.get_table(TABLE).reader().to_pandas()["recording"].isna().all()
    with pytest.raises(RequestError, match="a sweep without run folders"):
        show_sweep(folder, [], print, picture=tmp_path / "a.png", times=[1.0])
