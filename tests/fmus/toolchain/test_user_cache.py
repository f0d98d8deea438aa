"""The cache belongs to one user, what is in it is complete, and it does not grow without bound."""

from __future__ import annotations

import errno
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from fmus.toolchain import user_cache
from fmus.toolchain.user_cache import UnusableCacheError, UserCache

SOUND = "sound"
KILLED = """
import sys, time
from fmus.toolchain.user_cache import UserCache
def fill(folder):
    (folder / "part").touch()
    print(folder, flush=True)
    time.sleep(60)
UserCache("things", 100, 3).folder("a", 10, lambda _: True, fill)
"""


@pytest.fixture(autouse=True)
def place(tmp_path, monkeypatch):
    """Where the cache of a test is."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    return tmp_path / "macrostep" / "things"


def cached(key, size=10, content=SOUND):
    cache = UserCache("things", largest=100, most=3)
    return cache.folder(
        key,
        size,
        lambda path: (path / "file").read_text() == SOUND,
        lambda path: (path / "file").write_text(content),
    )


def kept(place):
    return sorted(path.name for path in place.iterdir() if path.name != ".lock")


def refusal():
    with pytest.raises(UnusableCacheError) as error:
        cached("a")
    return str(error.value)


def test_a_folder_is_made_once_and_nobody_else_can_read_it(place):
    path, was_damaged = cached("a")
    assert (path, was_damaged) == (place / "a-10", False)
    assert place.stat().st_mode & 0o777 == 0o700
    before = (path / "file").stat()
    assert cached("a", content="made again") == (path, False)
    assert (path / "file").stat().st_mtime_ns == before.st_mtime_ns
    assert kept(place) == ["a-10"]


def test_one_that_has_changed_is_made_again(place):
    path, _ = cached("a")
    (path / "file").write_text("changed")
    assert cached("a") == (path, True)
    assert (path / "file").read_text() == SOUND
    assert kept(place) == ["a-10"]


@pytest.mark.parametrize(("sizes", "left"), [([10] * 4, "bcd"), ([60, 30, 40], "bc"), ([10, 95], "b")])
def test_those_that_were_used_longest_ago_go_first(place, sizes, left):
    for number, (key, size) in enumerate(zip("abcd", sizes, strict=False)):
        path, _ = cached(key, size)
        os.utime(path, (number, number))
    assert [name[0] for name in kept(place)] == list(left)


def test_one_that_is_used_stays(place):
    for number, key in enumerate("abc"):
        os.utime(cached(key).path, (number, number))
    cached("a")
    cached("d")
    assert kept(place) == ["a-10", "c-10", "d-10"]


def test_what_a_killed_process_was_making_is_swept_by_the_next(place):
    with subprocess.Popen([sys.executable, "-c", KILLED], stdout=subprocess.PIPE, text=True) as killed:
        partial = Path(killed.stdout.readline().strip())
        killed.send_signal(signal.SIGKILL)
    assert (partial / "part").is_file()
    cached("b")
    assert kept(place) == ["b-10"]


def test_a_process_waits_for_another_one_for_some_time(place, monkeypatch):
    monkeypatch.setattr(user_cache, "_PATIENCE", 0.2)
    with subprocess.Popen([sys.executable, "-c", KILLED], stdout=subprocess.PIPE, text=True) as other:
        other.stdout.readline()
        assert refusal() == f"{place}: another process has been changing it for 0.2 s"
        other.kill()


def test_a_cache_that_is_not_ours_is_not_used(place, monkeypatch):
    cached("a")
    monkeypatch.setattr(os, "geteuid", lambda: 12345)
    assert refusal() == f"{place.parent}: it belongs to another user"


@pytest.mark.parametrize("mode", [0o720, 0o702])
def test_one_that_others_can_write_to_is_not_used(place, mode):
    cached("a")
    place.chmod(mode)
    assert refusal() == f"{place}: other users can write to it"
    place.chmod(0o755)
    cached("a")
    assert place.stat().st_mode & 0o777 == 0o700


def test_what_others_can_do_in_the_folder_around_it_is_taken_from_them(place):
    cached("a")
    place.parent.chmod(0o775)
    cached("a")
    assert place.parent.stat().st_mode & 0o777 == 0o755


@pytest.mark.parametrize("link", [False, True])
def test_what_stands_in_the_place_of_a_folder_is_replaced(place, tmp_path, link):
    path, _ = cached("a")
    path.rename(tmp_path / "elsewhere")
    if link:
        path.symlink_to(tmp_path / "elsewhere")
    else:
        path.touch()
    assert cached("a") == (path, True)
    assert not path.is_symlink()
    assert (tmp_path / "elsewhere" / "file").is_file()


def test_one_behind_a_link_is_not_used(place, tmp_path):
    cached("a")
    place.rename(tmp_path / "elsewhere")
    place.symlink_to(tmp_path / "elsewhere")
    assert refusal() == f"{place}: it is no folder"


def test_a_file_in_its_place_is_told(place):
    place.parent.write_text("")
    assert refusal() == f"{place}: File exists"


def test_a_disk_that_is_full_or_cannot_be_written_to_is_told(place, monkeypatch):
    path, _ = cached("a")

    def full(*_, **__):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    def read_only(*_, **__):
        raise OSError(errno.EROFS, os.strerror(errno.EROFS))

    monkeypatch.setattr(user_cache.tempfile, "mkdtemp", full)
    monkeypatch.setattr(user_cache.os, "utime", read_only)
    assert cached("a") == (path, False)  # what is there can be read
    (path / "file").write_text("changed")
    assert refusal() == f"{place}: No space left on device"
