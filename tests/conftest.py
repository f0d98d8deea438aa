from __future__ import annotations

import json
import os
import signal
import sys
from contextlib import nullcontext

import pytest
from hypothesis import settings

from components import BLOCKS
from components.interfaces.progress import SILENT
from fmus.toolchain.version import WRITTEN_VERSIONS
from orchestrator.command import main
from orchestrator.scenario import catalogue

# a shell starts what runs in the background with Ctrl-C ignored, and so would be all processes that tests start
signal.signal(signal.SIGINT, signal.default_int_handler)

# tests start hundreds of processes, which would compile every module anew where an environment forbids to keep them
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

# machines are shared and noisy: a slow example is no fault; examples are the same in every run of the same files
# (Hypothesis tries the constants of all our modules that are loaded: another choice of tests gets other examples)
settings.register_profile("macrostep", deadline=None, derandomize=True)
settings.load_profile("macrostep")


class NoRecording(nullcontext):
    """Takes what a run would record."""

    def __enter__(self):
        return self

    def begin(self, request, _):
        if not isinstance(request.sink, str):
            request.sink.touch()  # a recording that is gone would be made once more

    def wait_until_open(self):
        pass

    def end(self, *_):
        pass

    def wait(self):
        return ""


@pytest.fixture(scope="session", autouse=True)
def no_usage_data(tmp_path_factory):
    """Rerun sends no usage data from tests, and they do not depend on whether it has been used on this machine."""
    folder = tmp_path_factory.mktemp("config")
    file = folder / "rerun" / "analytics.json"
    file.parent.mkdir()
    places = {"config_file_path": str(file), "data_dir_path": str(folder / "data")}
    file.write_text(json.dumps({"analytics_enabled": False, "analytics_id": "0" * 32, "metadata": {}, **places}))
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CONFIG_HOME", str(folder))
        yield


@pytest.fixture(autouse=True)
def made_here(request, monkeypatch):
    """The FMUs of tests count as builds of ours: a process for each would take most of the time of all tests.

    Tests marked `foreign` see FMUs of other makers as a person does: in processes of their own.
    """
    if request.node.get_closest_marker("foreign") is None:
        monkeypatch.setattr("orchestrator.system.source.is_own_build", lambda *_: True)


@pytest.fixture
def without_pictures(monkeypatch):
    """Recording and figures have tests of their own."""
    monkeypatch.setattr("orchestrator.recording.process.RecordingProcess", NoRecording)
    monkeypatch.setattr("orchestrator.pictures.figures.draw", lambda *_: [])


@pytest.fixture
def in_tmp_path(tmp_path, monkeypatch):
    """The working folder of a command that writes runs/."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def macrostep(in_tmp_path, monkeypatch, capsys):
    """Types `macrostep ...` in a new folder; gives the exit code and what stands on stdout and on stderr."""

    monkeypatch.setattr("orchestrator.command.console.TELLS_EVERY", 1e6)  # on a loaded machine there would be lines

    def call(*arguments):
        monkeypatch.setattr(sys, "argv", ["macrostep", *map(str, arguments)])
        with pytest.raises(SystemExit) as end:
            main.main()
        said = capsys.readouterr()
        return end.value.code or 0, said.out, said.err

    return call


@pytest.fixture(scope="session")
def built_fmus():
    """The folder with all FMUs of both versions, built where `macrostep build` puts them."""
    folder = catalogue.built_folder()
    catalogue.ensure_built([b for b in BLOCKS.values() if b.native], WRITTEN_VERSIONS, folder, SILENT)
    return folder
