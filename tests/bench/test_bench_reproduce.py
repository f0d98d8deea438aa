"""The whole reproduction (budget 90 s), and 200 variations with the native controllers (60 s), on two quiet cores."""

from __future__ import annotations

import pytest

from orchestrator import SILENT
from orchestrator.reproduction.paper import experiments
from orchestrator.reproduction.reproduce import new_folder, reproduce
from orchestrator.reproduction.varied import variations, varied_set


@pytest.mark.slow
def test_reproduce(benchmark, built_fmus, tmp_path):
    wanted = experiments.load()
    folder = new_folder(tmp_path / "report")
    benchmark.pedantic(reproduce, args=(wanted, folder, SILENT), rounds=1)


@pytest.mark.slow
def test_200_variations(benchmark, built_fmus):
    request = variations.request(200, seed=1)
    benchmark.pedantic(varied_set.run, args=(request, lambda: None), rounds=1)
