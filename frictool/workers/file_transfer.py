"""Transfer of the files of a job to workers that cannot read them from a local disk.

    (paths, job) ──▶ worker: same size and SHA-256 at the paths? ──yes──▶ function(paths, job)
                         └─no──▶ bytes are requested and sent ──▶ function(copies, job)

If the worker finds the same files in a shared file system, no bytes are sent. Copies are deleted
after the job.
"""

from __future__ import annotations

import hashlib
import os
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Generic, TypeVar

from frictool.workers.job_sharing import share

Job = TypeVar("Job")
Result = TypeVar("Result")
Paths = tuple[Path, ...]
# largest size of a job's files in bytes: a task passes through the memory of the scheduler
LARGEST_SENT = 256_000_000
JOURNAL = "-wal"  # suffix of the journal of a database, a file in the database's folder


@dataclass(frozen=True)
class FileDescription:
    """File, or folder of files, on this machine.

    path: absolute path of the file or folder.
    parts: (name, SHA-256) of each file; names are relative to the folder that contains `path`.
    size: total size in bytes.
    content: bytes of each file; empty if only the description is sent.
    """

    path: Path
    parts: tuple[tuple[str, str], ...]
    size: int
    content: tuple[bytes, ...] = ()


@dataclass(frozen=True)
class FilesMissing:
    """Value that a worker returns instead of a result if it lacks the files of the job."""


@dataclass(frozen=True)
class _RemoteFunction(Generic[Job, Result]):
    function: Callable[[Paths, Job], Result]

    def __call__(self, job: tuple[tuple[FileDescription, ...], Job]) -> Result | FilesMissing:
        sent, request = job
        if any(one.content for one in sent):
            with _copies(sent) as paths:
                return self.function(paths, request)
        if not all(is_here(one) for one in sent):
            return FilesMissing()
        return self.function(tuple(one.path for one in sent), request)


@dataclass(frozen=True)
class _LocalFunction(Generic[Job, Result]):
    function: Callable[[Paths, Job], Result]

    def __call__(self, job: tuple[Paths, Job]) -> Result:
        return self.function(*job)


def share_files(
    function: Callable[[Paths, Job], Result],
    jobs: Sequence[tuple[Paths, Job]],
    instead: Callable[[Job, str], Result],
    *,
    cores: int | None = None,
    cluster: str | None = None,
) -> Iterator[tuple[int, Result]]:
    """Distribute jobs that read files; yield (index, result) of each job.

    function: function(paths, job) that returns the result of a job.
    jobs: pairs (paths of the files that the job reads, job).
    instead: function(job, reason) that returns a substitute for the result of a job. It is called
        if several processes died during the job, or if the files could not be transferred.
    cores, cluster: as in `share` (job_sharing.py).

    Raises ClusterError if the cluster cannot be used. Raises OSError if a file cannot be read.
    """
    if cluster is None:
        yield from share(
            _LocalFunction(function),
            jobs,
            cores=cores,
            instead=lambda job, why: instead(job[1], why),
        )
        return
    yield from _by_description(function, jobs, instead, cluster)


def _by_description(
    function: Callable[[Paths, Job], Result],
    jobs: Sequence[tuple[Paths, Job]],
    instead: Callable[[Job, str], Result],
    cluster: str,
) -> Iterator[tuple[int, Result]]:
    """Send descriptions of the files first, then the bytes of the files that a worker lacks."""
    indices: list[int] = []
    described: list[tuple[FileDescription, ...]] = []

    def offered() -> Iterator[tuple[tuple[FileDescription, ...], Job]]:
        for index, (paths, job) in enumerate(jobs):
            if all(os.access(path, os.R_OK) for path in paths):
                indices.append(index)
                described.append(tuple(described_file(path) for path in paths))
                yield described[-1], job

    def lost(job: tuple[tuple[FileDescription, ...], Job], why: str) -> Result | FilesMissing:
        return instead(job[1], why)

    missing: list[int] = []
    for number, result in share(
        _RemoteFunction(function), offered(), cluster=cluster, instead=lost
    ):
        if isinstance(result, FilesMissing):
            missing.append(number)
        else:
            yield indices[number], result
    sendable = [number for number in sorted(missing) if _size(described[number]) <= LARGEST_SENT]
    if sendable:
        sent = (
            (tuple(map(with_content, described[number])), jobs[indices[number]][1])
            for number in sendable
        )
        for turn, result in share(_RemoteFunction(function), sent, cluster=cluster, instead=lost):
            assert not isinstance(result, FilesMissing)
            yield indices[sendable[turn]], result
    for number in sorted(set(missing) - set(sendable)):
        yield (
            indices[number],
            instead(jobs[indices[number]][1], _too_large(_size(described[number]))),
        )
    # the function raises the most specific error about an unreadable file
    for index in sorted(set(range(len(jobs))) - set(indices)):
        yield index, function(*jobs[index])


def _size(sent: tuple[FileDescription, ...]) -> int:
    return sum(one.size for one in sent)


def _too_large(size: int) -> str:
    return (
        f"is missing on the worker, and its {size / 1e6:.0f} MB are too large to be sent (allowed: "
        f"{LARGEST_SENT / 1e6:.0f} MB); put it into a folder with the same path on all workers"
    )


def described_file(path: Path) -> FileDescription:
    """Return the description of a file or folder; raise OSError if it cannot be read."""
    at = path.absolute()
    names = _names(at)
    parts = tuple((name, _digest(at.parent / name)) for name in names)
    return FileDescription(at, parts, sum((at.parent / name).stat().st_size for name in names))


def with_content(sent: FileDescription) -> FileDescription:
    """Return the description with the bytes of the files."""
    return FileDescription(
        sent.path,
        sent.parts,
        sent.size,
        tuple((sent.path.parent / name).read_bytes() for name, _ in sent.parts),
    )


def is_here(sent: FileDescription) -> bool:
    """Return True if this machine has files of the same size and SHA-256 at the same path."""
    try:
        return described_file(sent.path) == sent
    except OSError:
        return False


def _names(path: Path) -> list[str]:
    if path.is_dir():
        return sorted(
            one.relative_to(path.parent).as_posix() for one in path.rglob("*") if one.is_file()
        )
    return [one.name for one in (path, path.with_name(f"{path.name}{JOURNAL}")) if one.is_file()]


def _digest(path: Path) -> str:
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


@contextmanager
def _copies(sent: tuple[FileDescription, ...]) -> Iterator[Paths]:
    with tempfile.TemporaryDirectory(prefix="frictool-") as folder:
        for number, one in enumerate(sent):
            for (name, _), content in zip(one.parts, one.content, strict=True):
                target = Path(folder, str(number), name)
                target.parent.mkdir(parents=True, exist_ok=True)
                target.write_bytes(content)
        yield tuple(Path(folder, str(number), one.path.name) for number, one in enumerate(sent))
