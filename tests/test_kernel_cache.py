"""Folders of compiled kernels: whose they are, when they go, and what happens when several
processes write or a disk was full."""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import pytest
from numba.core.caching import IndexDataCacheFile

from frictool.runtime import kernel_folders, kernels
from frictool.runtime.kernel_folders import KEPT, USED, folders, mark_used, prune, remove, writing

DAY = 86400.0
HOLDER = (
    "import sys, pathlib; from frictool.runtime import kernel_folders as c; "
    "c.mark_used(pathlib.Path(sys.argv[1])); print('held', flush=True); input()"
)


def left_over(place: Path, name: str, age: float, locked: bool = True) -> Path:
    """A folder that was used `age` seconds ago."""
    folder = place / f"kernels-{name}"
    folder.mkdir()
    kept = folder / "machine.read-1.py311.1.nbc"
    kept.write_bytes(b"x" * 1000)
    when = time.time() - age
    if locked:
        (folder / USED).write_bytes(b"")
        os.utime(folder / USED, (when, when))
    for path in (kept, folder):
        os.utime(path, (when, when))
    return folder


def test_what_was_unused_for_a_fortnight_goes(tmp_path: Path) -> None:
    current, old, recent = (
        left_over(tmp_path, name, age)
        for name, age in (("new", 0.0), ("old", 30 * DAY), ("recent", 2 * DAY))
    )
    assert prune(tmp_path, current) == [old]
    assert [folder.path for folder in folders(tmp_path)] == [current, recent]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["kernels-new", "kernels-recent"]


def test_of_many_the_last_ones_stay_and_the_current_one_always(tmp_path: Path) -> None:
    current = left_over(tmp_path, "current", 100 * DAY)
    others = [
        left_over(tmp_path, str(day), (1 + day) * 0.5 * DAY, locked=day % 2 == 0)
        for day in range(KEPT + 4)
    ]
    assert sorted(prune(tmp_path, current)) == sorted(others[KEPT:])
    assert current.exists()
    assert all(folder.exists() for folder in others[:KEPT])


def test_what_was_used_within_the_hour_stays(tmp_path: Path) -> None:
    """An older frictool that holds no lock may still run with it."""
    folder = left_over(tmp_path, "young", 600.0, locked=False)
    assert not remove(folder)
    assert remove(folder, time.time() + 2 * 3600.0)
    assert not folder.exists()


def test_what_a_process_holds_stays_until_it_ends(tmp_path: Path) -> None:
    folder = left_over(tmp_path, "old", 30 * DAY)
    child = subprocess.Popen(
        [sys.executable, "-c", HOLDER, str(folder)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert child.stdout is not None
    assert child.stdout.readline() == "held\n"
    later = time.time() + 60 * DAY
    assert folders(tmp_path)[0].busy
    assert not remove(folder, later)
    child.communicate("\n")
    assert not folders(tmp_path)[0].busy
    assert remove(folder, later)


def test_who_begins_while_a_folder_is_removed_makes_it_anew(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = left_over(tmp_path, "old", 30 * DAY)
    original, seen = os.open, []

    def opens(path: Any, flags: int, mode: int = 0o777, **options: Any) -> int:
        handle = original(path, flags, mode, **options)
        if not seen:  # the lock is open, and not yet taken
            seen.append(path)
            assert remove(folder)
        return handle

    monkeypatch.setattr(os, "open", opens)
    mark_used(folder)
    monkeypatch.undo()
    assert seen
    assert folders(tmp_path)[0].busy


def test_half_removed_folders_go_with_the_next(tmp_path: Path) -> None:
    (tmp_path / ".removed-kernels-1-2").mkdir()
    prune(tmp_path, tmp_path / "kernels-new")
    assert list(tmp_path.iterdir()) == []


def test_one_writes_at_a_time(tmp_path: Path) -> None:
    """Else, of two processes that read one index, each adds its own entry, and one is lost or names
    the other's code."""
    index: list[int] = []

    def keep(number: int) -> None:
        with writing(tmp_path) as mine:
            assert mine
            read = [*index, number]
            time.sleep(0.02)
            index[:] = read

    threads = [threading.Thread(target=keep, args=(number,)) for number in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sorted(index) == [0, 1, 2, 3]


def test_who_cannot_have_the_lock_keeps_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(kernel_folders, "PATIENCE_S", 0.05)
    with writing(tmp_path) as first, writing(tmp_path) as second:
        assert (first, second) == (True, False)
    with writing(tmp_path / "missing") as mine:
        assert not mine


MODULE = """
from frictool.runtime.kernels import kernel

@kernel
def twice(x):
    return x + x
"""


def declared(source: Path) -> Any:
    """The kernel of a module, declared anew as by another process."""
    spec = importlib.util.spec_from_file_location(source.stem, source)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.twice


@pytest.fixture
def source(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(kernels, "FOLDER", tmp_path / "kernels-here")
    (tmp_path / "kernels-here").mkdir()
    path = tmp_path / "doubling.py"
    path.write_text(MODULE)
    return path


def hits(function: Any) -> int:
    return sum(function.stats.cache_hits.values())


@pytest.mark.parametrize("suffix", [".nbi", ".nbc"])
@pytest.mark.parametrize("left", [0, 40])
def test_what_is_damaged_is_compiled_again(source: Path, suffix: str, left: int) -> None:
    assert declared(source)(2.0) == 4.0
    again = declared(source)
    assert again(2.0) == 4.0
    assert hits(again) == 1
    (kept,) = source.parent.rglob(f"*{suffix}")
    kept.write_bytes(kept.read_bytes()[:left])  # as after a power cut
    mended = declared(source)
    assert mended(2.0) == 4.0
    assert hits(mended) == 0
    last = declared(source)
    assert last(2.0) == 4.0
    assert hits(last) == 1


def test_a_full_disk_keeps_nothing_and_stops_nothing(
    source: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(IndexDataCacheFile, "_save_index", full)
    assert declared(source)(2.0) == 4.0
    assert not list(source.parent.rglob("*.nb?"))


POSIX = pytest.mark.skipif(not hasattr(os, "geteuid"), reason="owners and modes of POSIX")
ASK = (
    "from frictool.runtime import kernels; print(kernels.FOLDER); "
    "print(*kernels.UNTRUSTED.values())"
)


def place_of_kernels(place: Path, user: Path) -> tuple[str, str]:
    """The folder that a new process uses where NUMBA_CACHE_DIR says `place`, and why another is not
    loaded."""
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(place), "XDG_CACHE_HOME": str(user)}
    done = subprocess.run(
        [sys.executable, "-c", ASK], capture_output=True, text=True, env=environment, check=True
    )
    folder, reason = done.stdout.splitlines()
    return folder, reason


@POSIX
@pytest.mark.parametrize(
    "damage",
    ["folder", *(pytest.param(one, marks=pytest.mark.accept) for one in ("inside", "place"))],
)
def test_kernels_that_others_can_write_are_not_loaded(damage: str, tmp_path: Path) -> None:
    place, user = tmp_path / "place", tmp_path / "user"
    first, reason = place_of_kernels(place, user)
    folder = Path(first)
    assert (folder.parent, reason) == (place, "")
    (folder / "engine_0123").mkdir(mode=0o755)
    assert place_of_kernels(place, user) == (first, "")
    {"folder": folder, "inside": folder / "engine_0123", "place": place}[damage].chmod(0o777)
    used, reason = place_of_kernels(place, user)
    assert Path(used).parent == user / "frictool"
    assert "can write in" in reason


@POSIX
def test_kernels_of_another_user_are_not_loaded_and_doctor_says_so(tmp_path: Path) -> None:
    if os.geteuid() != 0:
        pytest.skip("only root can give a folder away")
    place, user = tmp_path / "place", tmp_path / "user"
    folder = Path(place_of_kernels(place, user)[0])
    os.chown(folder, 4321, -1)
    assert place_of_kernels(place, user) == (
        str(user / "frictool" / folder.name),
        f"{folder} belongs to user 4321",
    )
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(place), "XDG_CACHE_HOME": str(user)}
    done = subprocess.run(
        [sys.executable, "-m", "frictool", "doctor"],
        capture_output=True,
        text=True,
        env=environment,
        check=False,
    )
    (line,) = (line for line in done.stdout.splitlines() if line.startswith("note  kernels"))
    assert f"{folder} is not loaded: {folder} belongs to user 4321" in line
    assert str(user) in line


@POSIX
def test_the_owner_of_the_sources_is_trusted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder, sources = tmp_path / "kernels-1", tmp_path / "kernels.py"
    folder.mkdir(mode=0o755)
    sources.touch()
    assert kernel_folders.untrusted_reason(folder, sources) == ""
    monkeypatch.setattr(os, "geteuid", lambda: 4321)
    assert kernel_folders.untrusted_reason(folder, sources) == ""


@POSIX
def test_a_folder_that_another_process_removes_meanwhile_is_no_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    inside = tmp_path / "folder" / "inside"
    inside.mkdir(parents=True)
    lstat = Path.lstat

    def removed(path: Path) -> os.stat_result:
        if path == inside:
            inside.rmdir()
        return lstat(path)

    monkeypatch.setattr(Path, "lstat", removed)
    assert kernel_folders.untrusted_reason(inside.parent, tmp_path) == ""
    assert not inside.exists()


@POSIX
def test_what_is_kept_is_writable_by_its_owner_alone_whatever_the_umask(tmp_path: Path) -> None:
    before = os.umask(0)
    try:
        folder, _ = place_of_kernels(tmp_path / "place", tmp_path / "user")
        assert place_of_kernels(tmp_path / "place", tmp_path / "user") == (folder, "")
        assert Path(folder).stat().st_mode & 0o022 == 0
    finally:
        os.umask(before)
