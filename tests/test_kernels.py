"""Where compiled kernels are kept: a folder for each state of the sources, and none where nothing can be written."""

from __future__ import annotations

import shutil
from pathlib import Path

import numba
import pytest

from frictool import kernel_cache, kernels, waiting

PACKAGE = Path(kernels.__file__).parent


@pytest.fixture
def package(tmp_path: Path) -> Path:
    """A copy of the sources of all kernels."""
    for room in kernels.ROOMS:
        shutil.copytree(PACKAGE / room, tmp_path / room, ignore=shutil.ignore_patterns("__pycache__"), dirs_exist_ok=True)
    return tmp_path


def folder(package: Path, toolchain: str = "numba 1") -> str:
    return kernel_cache.folder_name(package, kernels.ROOMS, toolchain)


@pytest.mark.parametrize("room", kernels.ROOMS)
def test_a_change_in_any_room_is_another_folder(package: Path, room: str) -> None:
    before = folder(package)
    assert folder(package) == before
    source = sorted((package / room).glob("*.py"))[-1]
    source.write_text(source.read_text() + "\n# changed\n")
    assert folder(package) != before


def test_another_compiler_or_processor_is_another_folder(package: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert folder(package, "numba 1") != folder(package, "numba 2")
    here = kernels.toolchain()
    assert numba.__version__ in here
    monkeypatch.setattr(kernels.settings, "CPU_NAME", "generic")
    assert kernels.toolchain() != here


def test_every_kernel_lies_in_a_room_that_the_digest_covers() -> None:
    users = [path for path in PACKAGE.rglob("*.py") if "kernel\ndef " in path.read_text()]
    assert users
    assert {path.parent.relative_to(PACKAGE).as_posix() for path in users} <= set(kernels.ROOMS)


def test_a_folder_that_cannot_be_made_is_not_usable(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    assert not kernels._usable(tmp_path / "file" / "folder")
    assert kernels._usable(tmp_path / "folder")


def test_the_user_folder_stands_in_for_a_read_only_installation(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(kernels.settings, "CACHE_DIR", "")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    usable = kernels._usable
    monkeypatch.setattr(kernels, "_usable", lambda folder: PACKAGE not in folder.parents and usable(folder))
    folder = kernels._cache_folder()
    assert folder is not None
    assert folder.parent == tmp_path / "frictool"
    monkeypatch.setattr(kernels, "_usable", lambda folder: False)
    assert kernels._cache_folder() is None


def test_where_numba_is_told_to_keep_things_versions_have_folders_of_their_own_too(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(kernels.settings, "CACHE_DIR", str(tmp_path))
    kept = kernels._cache_folder()
    assert kept is not None
    assert kept.parent == tmp_path
    assert kept.name.startswith(kernel_cache.PREFIX)


def test_what_others_compile_is_kept_where_they_want_it() -> None:
    assert kernels.FOLDER is None or str(kernels.FOLDER) != kernels.settings.CACHE_DIR


def test_compiled_kernels_are_found_by_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(kernels, "FOLDER", tmp_path)
    (tmp_path / "engine").mkdir()
    (tmp_path / "engine" / "closed_loop.run-47.py311.nbi").write_bytes(b"")
    assert kernels.is_compiled("closed_loop", "run")
    assert not kernels.is_compiled("closed_loop", "measure")


def test_who_waits_for_the_compiler_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(kernels, "FOLDER", None)
    told: list[None] = []
    monkeypatch.setattr(waiting, "compiling", lambda: told.append(None))

    @kernels.kernel
    def twice(x: float) -> float:
        return x + x

    assert not told
    assert twice(2.0) == 4.0
    assert len(told) == 1
    assert twice(3.0) == 6.0
    assert len(told) == 1


def test_a_kernel_inherits_nothing_from_an_inner_kernel_that_calls_it_first(monkeypatch: pytest.MonkeyPatch) -> None:
    """Else all that an inner kernel calls would be copied into each of its callers, and compiled anew at every level."""
    monkeypatch.setattr(kernels, "FOLDER", None)  # what comes from disk cannot be looked into

    @kernels.kernel
    def called(x: float) -> float:
        return x + 1.0

    @kernels.inner_kernel
    def caller(x: float) -> float:
        return called(x)

    @kernels.kernel
    def outermost(x: float) -> float:
        return caller(x)

    assert outermost(1.0) == 2.0
    for function, copied in ((called, False), (caller, True)):
        assert ("alwaysinline" in next(iter(function.inspect_llvm().values()))) == copied


def test_a_relative_place_is_that_of_the_start(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(kernels.settings, "CACHE_DIR", "kept")
    assert kernels.places()[0] == tmp_path / "kept"


def test_kernels_are_plain_functions_where_numba_is_told_not_to_compile(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(kernels.settings, "DISABLE_JIT", 1)

    @kernels.kernel
    def twice(x: float) -> float:
        return x + x

    assert twice(2) == 4
    assert not hasattr(twice, "py_func")
