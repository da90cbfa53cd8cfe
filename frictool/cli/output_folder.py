"""Output of several files into a folder; either all files are written or none."""

from __future__ import annotations

import io
import sys
import tarfile
from collections.abc import Mapping
from pathlib import Path

from frictool.cli.output_files import STDOUT, refuse_inputs, require_folder
from frictool.errors import OutputError
from frictool.runtime.part_files import part_folder


def save_folder(
    target: Path,
    files: Mapping[str, str | bytes],
    inputs: list[Path],
    *,
    overwrite: bool,
    parents: bool = False,
) -> None:
    """Write `files` (contents by relative name) into `target`; other files there do not change.

    `-` writes a tar archive to stdout. `target` is created if necessary; `parents`: True to create
    the folders above `target` as well. Raises OutputError, before anything is changed, if a file is
    an input, cannot be written, or exists and `overwrite` is false.
    """
    if target == STDOUT:
        sys.stdout.buffer.write(archive(files))
        sys.stdout.buffer.flush()
        return
    if not parents:
        require_folder(target)
    _refuse(target, [target / name for name in files], inputs, overwrite)
    try:
        target.parent.mkdir(parents=parents, exist_ok=True)
        with part_folder(target) as temporary:
            staged = temporary / "files"
            for name, text in files.items():
                (staged / name).parent.mkdir(parents=True, exist_ok=True)
                (staged / name).write_bytes(_bytes(text))
            if not target.exists():
                staged.rename(target)
                return
            for name in files:
                (target / name).parent.mkdir(parents=True, exist_ok=True)
                (staged / name).replace(target / name)
    except OSError as error:
        raise OutputError(f"{target}: cannot be written: {error.strerror or error}") from None


def _refuse(target: Path, paths: list[Path], inputs: list[Path], overwrite: bool) -> None:
    if target.exists() and not target.is_dir():
        raise OutputError(f"{target}: is a file; name a folder")
    present = [path for path in paths if path.exists() or path.is_symlink()]
    if present and not overwrite:
        names = ", ".join(str(path.relative_to(target)) for path in present)
        raise OutputError(
            f"{target}: already contains {names}; nothing is overwritten; choose another folder "
            "or move these files"
        )
    for path in present:
        if path.is_dir():
            raise OutputError(
                f"{path}: is a folder, but a file of this name must be written; choose another "
                "folder"
            )
        refuse_inputs(path, inputs)


def _bytes(content: str | bytes) -> bytes:
    return content if isinstance(content, bytes) else content.encode()


def archive(files: Mapping[str, str | bytes]) -> bytes:
    """Return an uncompressed tar archive of the files (contents by name).

    The archive contains neither owners nor times, so that the same files give the same bytes.
    """
    buffer = io.BytesIO()
    with tarfile.open(fileobj=buffer, mode="w", format=tarfile.USTAR_FORMAT) as tar:
        for name, text in files.items():
            data = _bytes(text)
            entry = tarfile.TarInfo(name)
            entry.size = len(data)
            tar.addfile(entry, io.BytesIO(data))
    return buffer.getvalue()
