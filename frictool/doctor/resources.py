"""Checks of cores, memory, temporary folder and terminal."""

from __future__ import annotations

import locale
import os
import platform
import shutil
import sys
import tempfile
from pathlib import Path

from frictool.doctor.installation_finding import InstallationFinding

LEAST_MEMORY = 2e9  # bytes: a gridded synthesis takes about 1 GB


def check_machine() -> InstallationFinding:
    """Check the number of cores and the memory that this process may use."""
    cores = (
        len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    )
    memory = _memory()
    facts = {
        "cores": cores,
        "memory_bytes": memory,
        "system": platform.system(),
        "machine": platform.machine(),
    }
    description = (
        f"{cores} core{'s' * (cores > 1)}, "
        f"{'memory unknown' if memory is None else f'{memory / 1e9:.1f} GB of memory'}"
    )
    shown = f"{description}, {platform.system()} {platform.machine()}"
    if memory is not None and memory < LEAST_MEMORY:
        return InstallationFinding(
            "machine", "note", shown, "a large synthesis takes more than 1 GB", facts
        )
    return InstallationFinding("machine", "ok", shown, facts=facts)


def _memory() -> int | None:
    """Return the memory of the machine or of its container in bytes, whichever is smaller.

    Return None if the memory is unknown.
    """
    try:
        whole = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, ValueError, OSError):
        return None
    try:
        limit = int(Path("/sys/fs/cgroup/memory.max").read_text())
    except (OSError, ValueError):
        limit = whole
    return min(whole, limit)


def check_temporary() -> InstallationFinding:
    """Check that the temporary folder can be written."""
    try:
        folder = tempfile.gettempdir()
        tempfile.TemporaryFile(dir=folder).close()
        free = shutil.disk_usage(folder).free
    except OSError as error:
        return InstallationFinding(
            "temporary",
            "wrong",
            f"no temporary folder can be written: {error.strerror or error}",
            "set TMPDIR",
        )
    return InstallationFinding(
        "temporary",
        "ok",
        f"{folder}: {free / 1e9:.1f} GB free",
        facts={"folder": folder, "free_bytes": free},
    )


def check_terminal() -> InstallationFinding:
    """Check that the terminal's encoding can show the characters that frictool prints."""
    encoding = (
        (getattr(sys.stdout, "encoding", None) or locale.getpreferredencoding(False))
        .lower()
        .replace("_", "-")
    )
    is_terminal = sys.stdout is not None and sys.stdout.isatty()
    facts = {
        "encoding": encoding,
        "is_terminal": is_terminal,
        "no_colour": bool(os.environ.get("NO_COLOR")),
    }
    description = (
        f"{encoding}, {'a terminal' if is_terminal else 'not a terminal: no colours, no progress'}"
    )
    if encoding not in ("utf-8", "utf8"):
        return InstallationFinding(
            "terminal",
            "note",
            description,
            "set LANG=C.UTF-8, to show names that are not ASCII",
            facts,
        )
    return InstallationFinding("terminal", "ok", description, facts=facts)
