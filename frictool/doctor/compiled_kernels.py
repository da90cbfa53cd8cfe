"""Checks of compiled kernels: a kernel is compiled and run, and the kernels on disk are counted."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from frictool.doctor.installation_finding import InstallationFinding
from frictool.runtime import kernel_folders, kernels
from frictool.runtime.kernel_folders import KernelFolder
from frictool.runtime.kernel_sources import PACKAGE, Sources, UnknownSourcesError


@dataclass(frozen=True)
class OldKernelFolder:
    """Cache folder with kernels that this installation no longer uses.

    kept_by: reason why the folder cannot be removed; "" if it can be removed.
    """

    folder: KernelFolder
    kept_by: str


def check_compiling() -> InstallationFinding:
    """Compile a small kernel and check the value that it returns."""
    start = time.perf_counter()
    value = kernels.compiler(_polynomial)(1.5, 4)
    took = time.perf_counter() - start
    facts = {"toolchain": kernels.toolchain(), "seconds": round(took, 3)}
    if value != _polynomial(1.5, 4):
        return InstallationFinding(
            "compiling",
            "wrong",
            f"a kernel gave {value}, not {_polynomial(1.5, 4)}",
            "reinstall numba and llvmlite",
            facts,
        )
    return InstallationFinding(
        "compiling",
        "ok",
        f"a kernel was compiled and run in {took:.2f} s; {kernels.toolchain()}",
        facts=facts,
    )


def _polynomial(x: float, order: int) -> float:
    total = 1.0
    for _ in range(order):
        total = 1.0 + x * total
    return total


def check_kernel_folder() -> InstallationFinding:
    """Check the folder of kernels that this installation uses."""
    folder = kernels.FOLDER
    if kernels.UNTRUSTED:
        return _distrusted(folder)
    if folder is None:
        tried = " nor ".join(str(place) for place in kernels.cache_places())
        return InstallationFinding(
            "kernels",
            "note",
            f"compiled code is not kept: neither {tried} can be written; every command compiles",
            "set NUMBA_CACHE_DIR",
            {},
        )
    folder_state = next(
        (one for one in kernel_folders.folders(folder.parent) if one.path == folder), None
    )
    size = 0 if folder_state is None else folder_state.size
    count = sum(1 for _ in folder.rglob("*.nbi"))
    facts = {"folder": str(folder), "bytes": size, "functions": count}
    description = f"{folder}: {count} functions, {_megabytes(size)}"
    return InstallationFinding(
        "kernels",
        "ok",
        description
        if count
        else f"{folder}: no kernels yet; each is compiled and kept at its first use",
        facts=facts,
    )


def _distrusted(folder: Path | None) -> InstallationFinding:
    refused = "; ".join(
        f"{one} is not loaded: {reason}" for one, reason in kernels.UNTRUSTED.items()
    )
    used = f"kept in {folder}" if folder is not None else "not kept: every command compiles"
    facts = {
        "folder": None if folder is None else str(folder),
        "not_loaded": [str(one) for one in kernels.UNTRUSTED],
    }
    return InstallationFinding(
        "kernels",
        "note",
        f"{used}; {refused}",
        "remove it, or set NUMBA_CACHE_DIR to another folder",
        facts,
    )


def old_kernel_folders() -> list[OldKernelFolder]:
    """Return the cache folders with kernels that this installation does not use."""
    old = [
        folder
        for place in kernels.cache_places()
        for folder in kernel_folders.folders(place)
        if folder.path != kernels.FOLDER
    ]
    if kernels.FOLDER is not None:
        sources = Sources(PACKAGE.parent, kernels.FOLDER, only=PACKAGE.name)
        old += [
            kernel_folders.sized(state)
            for state in kernel_folders.states(kernels.FOLDER)
            if not _is_current(state.path, sources)
        ]
    now = time.time()
    young = {
        folder.path: "used within the last hour"
        for folder in old
        if now - folder.used <= kernel_folders.REST_S
    }
    return [
        OldKernelFolder(folder, "in use" if folder.busy else young.get(folder.path, ""))
        for folder in old
    ]


def _is_current(state: Path, sources: Sources) -> bool:
    module = f"{PACKAGE.name}.{kernel_folders.module_of(state)}"
    try:
        return sources.holds(module) and state.name.endswith(f"-{sources.state([module]).digest}")
    except UnknownSourcesError:
        return True


def check_old_kernels(left: list[OldKernelFolder]) -> InstallationFinding:
    """Return a finding with the number and the total size of the older kernel folders `left`."""
    size = sum(one.folder.size for one in left)
    facts: dict[str, Any] = {
        "folders": [
            {
                "folder": str(one.folder.path),
                "bytes": one.folder.size,
                "kept_by": one.kept_by or None,
            }
            for one in left
        ],
        "bytes": size,
    }
    if not left:
        return InstallationFinding("left over", "ok", "no kernels of former versions", facts=facts)
    several = "s" if len(left) > 1 else ""
    free = sum(1 for one in left if not one.kept_by)
    remedy = "frictool doctor --clean" if free else ""
    return InstallationFinding(
        "left over",
        "ok",
        f"kernels of {len(left)} former version{several}, {_megabytes(size)}",
        remedy,
        facts,
    )


def remove_old_kernels() -> tuple[list[Path], list[OldKernelFolder]]:
    """Remove folders of older kernels with an empty `kept_by`; return (removed, remaining)."""
    gone, kept = [], []
    for one in old_kernel_folders():
        is_state = one.folder.path.parent == kernels.FOLDER
        remove = kernel_folders.remove_state if is_state else kernel_folders.remove
        if not one.kept_by and remove(one.folder.path):
            gone.append(one.folder.path)
        else:
            kept.append(one)
    return gone, kept


def _megabytes(size: int) -> str:
    return f"{size / 1e6:.1f} MB"
