"""Declaration of kernels, and the place in which compiled ones are kept."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numba
import numpy as np
import pytest

from frictool.runtime import kernel_folders, kernels, notifications
from frictool.runtime.machine_code_store import KernelStore

PACKAGE = Path(kernels.__file__).parents[1]


def test_another_compiler_or_processor_is_another_folder(monkeypatch: pytest.MonkeyPatch) -> None:
    assert kernel_folders.folder_name("numba 1") != kernel_folders.folder_name("numba 2")
    here = kernels.toolchain()
    assert numba.__version__ in here
    assert np.__version__ in here
    monkeypatch.setattr(kernels.settings, "CPU_NAME", "generic")
    assert kernels.toolchain() != here


def test_a_folder_that_cannot_be_made_is_not_usable(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    assert not kernels._usable(tmp_path / "file" / "folder")
    assert kernels._usable(tmp_path / "folder")


def test_the_user_folder_stands_in_for_a_read_only_installation(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(kernels.settings, "CACHE_DIR", "")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    usable = kernels._usable
    monkeypatch.setattr(
        kernels, "_usable", lambda folder: PACKAGE not in folder.parents and usable(folder)
    )
    folder = kernels._cache_folder()
    assert folder is not None
    assert folder.parent == tmp_path / "frictool"
    monkeypatch.setattr(kernels, "_usable", lambda folder: False)
    assert kernels._cache_folder() is None


def test_where_numba_is_told_to_keep_things_versions_have_folders_of_their_own_too(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(kernels.settings, "CACHE_DIR", str(tmp_path))
    kept = kernels._cache_folder()
    assert kept is not None
    assert kept.parent == tmp_path
    assert kept.name.startswith(kernel_folders.PREFIX)


def test_what_others_compile_is_kept_where_they_want_it() -> None:
    assert kernels.FOLDER is None or str(kernels.FOLDER) != kernels.settings.CACHE_DIR


def test_a_kernel_is_compiled_once_it_was_called(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(kernels, "FOLDER", tmp_path)

    @kernels.kernel
    def twice(x: float) -> float:
        return x + x

    assert not kernels.is_compiled(twice)
    assert twice(2.0) == 4.0
    assert kernels.is_compiled(twice)
    assert not kernels.is_compiled(len)


def test_a_kernel_that_fails_to_compile_leaves_no_lock(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(kernels, "FOLDER", tmp_path)

    @kernels.kernel
    def wrong(x: Any) -> Any:
        return x.nothing

    store = wrong._cache  # type: ignore[attr-defined]  # a private field of numba
    assert isinstance(store, KernelStore)
    with pytest.raises(Exception, match="nothing"):
        wrong(1.0)
    assert store._claims == {}


def test_who_waits_for_the_compiler_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(kernels, "FOLDER", None)
    told: list[None] = []

    @kernels.kernel
    def twice(x: float) -> float:
        return x + x

    with notifications.receiving(compiling=lambda: told.append(None)):
        assert not told
        assert twice(2.0) == 4.0
        assert len(told) == 1
        assert twice(3.0) == 6.0
        assert len(told) == 1


def test_a_kernel_inherits_nothing_from_an_inner_kernel_that_calls_it_first(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Else all that an inner kernel calls would be copied into each of its callers, and compiled
    anew at every level."""
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
        callee: Any = function.callee  # type: ignore[attr-defined]  # added by the decorator
        assert ("alwaysinline" in next(iter(callee.dispatcher.inspect_llvm().values()))) == copied


def test_a_relative_place_is_that_of_the_start(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(kernels.settings, "CACHE_DIR", "kept")
    assert kernels.cache_places()[0] == tmp_path / "kept"


def test_kernels_are_plain_functions_where_numba_is_told_not_to_compile(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(kernels.settings, "DISABLE_JIT", 1)

    @kernels.kernel
    def twice(x: float) -> float:
        return x + x

    assert twice(2) == 4
    assert not hasattr(twice, "py_func")


def test_constants_of_a_caller_share_one_compilation() -> None:
    @kernels.kernel
    def shifted(value: float, count: int, is_up: bool) -> float:
        return value + count if is_up else value - count

    @kernels.kernel
    def both(value: float) -> float:
        return float(shifted(value, 1, True) + shifted(value, 2, False))

    assert both(3.0) == 5.0
    compiled: Any = shifted
    assert compiled.callee.dispatcher.signatures == [(numba.float64, numba.int64, numba.boolean)]


def test_a_kernel_that_only_kernels_call_is_linked_into_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(kernels, "FOLDER", tmp_path)

    @kernels.bare_kernel
    def square(x: float) -> float:
        return x * x

    @kernels.part_kernel
    def fourth(x: float) -> float:
        return float(square(square(x)))

    @kernels.kernel
    def eighth(x: float) -> float:
        return float(fourth(x) ** 2)

    assert eighth(2.0) == 256.0
    for function in (square, fourth):
        compiled: Any = function
        assert compiled.signatures == []  # no form for Python
        (form,) = compiled.callee.dispatcher.overloads.values()
        assert form.library.get_pointer_to_function(form.fndesc.llvm_cpython_wrapper_name) == 0
    # functions with other kernels in their closures are not kept
    assert [path.name.count("-linked.") for path in tmp_path.rglob("*.nbc")] == [1]
    assert square(3.0) == 9.0  # a kernel that kernels call, called from Python
