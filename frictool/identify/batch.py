"""Identification of many logs in one run: one model per log, or one per folder of logs.

    logs -> groups() -> LogGroup, ... -> identify_groups(), on several cores -> BatchResult, ...

Each BatchResult is one row of the batch's table. If it has a model, the model is written to a file.
"""

from __future__ import annotations

import functools
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath
from typing import Any, cast

from frictool import __version__
from frictool.documents.bench import Bench
from frictool.documents.document_reader import DocumentReader
from frictool.documents.document_text import compose
from frictool.documents.provenance import Input, Provenance, digest
from frictool.documents.writing import to_yaml
from frictool.errors import EXIT_DONE, EXIT_INPUT, FrictoolError, LogError
from frictool.identify.fit_result import Interval, SlidingFit, UnusableLogs
from frictool.identify.from_logs import identify
from frictool.identify.json_view import as_view
from frictool.identify.methods import IdentificationRequest
from frictool.logs.fleet import FleetLog
from frictool.logs.log import Log
from frictool.logs.log_reader import read_log
from frictool.logs.origin import LogOrigin, NamePatterns, origin_by_name, origin_of_log
from frictool.workers.file_transfer import Paths, share_files

# least size of all logs together, in bytes, at which more processes save time
WORTH_SHARING = 10_000_000


@dataclass(frozen=True)
class LogGroup:
    """Logs from which one model is identified.

    - name: name of the model file, without its suffix
    - words: command line that identifies this group alone
    """

    name: str
    members: tuple[FleetLog, ...]
    words: str = ""

    @property
    def files(self) -> str:
        """Return the file names of the logs, separated by semicolons."""
        return "; ".join(member.name.file for member in self.members)


@dataclass(frozen=True)
class BatchModel:
    """Identified model of one group.

    - identified: interval of each identified parameter, SI units
    - fit: fit of the sliding logs, or None
    - text: model as YAML
    - view: output of `identify --json` for this model
    """

    identified: Mapping[str, Interval]
    method: str
    fit: SlidingFit | None
    text: str
    view: dict[str, Any]
    warnings: tuple[str, ...]


@dataclass(frozen=True)
class BatchResult:
    """Model of a group of logs, or the reason why the group has no model.

    - reason: reason why the group has no model; empty if it has one
    - code: exit code for the reason; 0 if the group has a model
    """

    group: LogGroup
    origin: LogOrigin
    model: BatchModel | None
    reason: str = ""
    code: int = EXIT_DONE

    @property
    def lost(self) -> bool:
        """Return True if a log of the group could not be used."""
        return self.code == EXIT_INPUT


def groups(members: Sequence[FleetLog], each: str) -> list[LogGroup]:
    """Return groups of logs with unique names.

    `each` is "log" for one group per log, or "folder" for one group per folder.
    """
    together: dict[Path, list[FleetLog]] = {}
    for member in members:
        together.setdefault(member.path if each == "log" else member.path.parent, []).append(member)
    grouped = list(together.values())
    return [
        LogGroup(name, tuple(members_of_group))
        for name, members_of_group in zip(
            _names(
                _relative_paths([_called(members_of_group, each) for members_of_group in grouped])
            ),
            grouped,
            strict=True,
        )
    ]


def _called(members: list[FleetLog], each: str) -> PurePosixPath:
    log = PurePosixPath(members[0].name.file)
    if each == "log":
        return log
    return log.parent if log.parent.name else PurePosixPath(members[0].path.absolute().parent.name)


def _relative_paths(called: list[PurePosixPath]) -> list[PurePosixPath]:
    """Return paths without `..`, and absolute paths relative to their common parent."""
    rooted = [one for one in called if one.is_absolute()]
    top = (
        PurePosixPath(os.path.commonpath([one.parent for one in rooted]))
        if rooted
        else PurePosixPath()
    )
    below = [one.relative_to(top) if one.is_absolute() else one for one in called]
    return [PurePosixPath(*(part for part in one.parts if part != "..")) for one in below]


def _names(called: list[PurePosixPath]) -> list[str]:
    plain = [one.with_suffix("").as_posix() for one in called]
    whole = [
        short if plain.count(short) == 1 else one.as_posix()
        for short, one in zip(plain, called, strict=True)
    ]
    seen: dict[str, int] = {}
    names = []
    for name in whole:
        seen[name] = seen.get(name, 0) + 1
        names.append(name if whole.count(name) == 1 else f"{name}-{seen[name]}")
    return names


@dataclass(frozen=True)
class IdentifyJob:
    """Callable that identifies one group of logs, in this process or in a worker process.

    - bench: text of bench.yaml, which is copied into the model; unlike a `Bench` object, the text
      shows which fields are left out
    - bench_input: entry of the bench in the model's provenance
    - patterns: patterns that extract unit and date from the file name of a log
    """

    bench: str
    bench_input: Input
    request: IdentificationRequest
    patterns: NamePatterns = field(default_factory=NamePatterns)

    def __call__(self, paths: Paths, group: LogGroup) -> BatchResult:
        """Return the model of the group, or the reason why the group has no model."""
        try:
            return self._identified(paths, group)
        except UnusableLogs as error:
            return self._without(group, _named(str(error), paths, group), error.exit_code)
        except FrictoolError as error:
            return self._without(group, _named(str(error), paths, group), EXIT_INPUT)
        except MemoryError:
            return self._without(group, "needs more memory than this machine has", EXIT_INPUT)
        except OSError as error:
            return self._without(group, f"cannot be read: {error.strerror or error}", EXIT_INPUT)
        except Exception as error:  # a programming error with one log must not stop the other logs
            reason = (
                f"could not be identified ({type(error).__name__}: {error}); identify this log "
                "alone for details"
            )
            return self._without(group, _named(reason, paths, group), EXIT_INPUT)

    def _identified(self, paths: Paths, group: LogGroup) -> BatchResult:
        bench = _bench(self.bench)
        logs = [read_log(path, bench) for path in paths]
        origin = self._origin(logs, group)
        inputs = [Input(path.name, digest(path)) for path in paths if path.is_file()]
        provenance = Provenance(group.words, __version__, (*inputs, self.bench_input))
        warnings: list[str] = []
        model = identify(logs, bench, self.request, provenance=provenance, tell=warnings.append)
        result = model.result
        entry = BatchModel(
            result.identified,
            result.method,
            result.fit,
            to_yaml(model.model),
            as_view(result, bench, model.model),
            tuple(_named(text, paths, group) for text in (*warnings, *result.warnings)),
        )
        return BatchResult(group, origin, entry)

    def _origin(self, logs: Sequence[Log], group: LogGroup) -> LogOrigin:
        origins = [
            origin_of_log(log, member.name, self.patterns)
            for log, member in zip(logs, group.members, strict=True)
        ]
        units = list(dict.fromkeys(one.unit for one in origins if one.unit is not None))
        if len(units) > 1:
            raise LogError(
                group.name,
                (
                    f"contains logs of several actuators (--unit: {', '.join(units)}), but a model "
                    "describes one actuator; use --each log"
                ),
            )
        dates = sorted(one.date for one in origins if one.date is not None)
        return LogOrigin(units[0] if units else None, dates[0] if dates else None)

    def gone(self, group: LogGroup, reason: str) -> BatchResult:
        """Return the result for a group that no worker could process; `reason` says why."""
        return self._without(group, reason, EXIT_INPUT)

    def _without(self, group: LogGroup, reason: str, code: int) -> BatchResult:
        return BatchResult(
            group, origin_by_name(group.members[0].name, self.patterns), None, reason, code
        )


@functools.lru_cache(maxsize=4)
def _bench(text: str) -> Bench:
    path = Path("bench.yaml")
    return cast(Bench, DocumentReader(path).read(compose(text, path), Bench, ""))


def _named(text: str, paths: Paths, group: LogGroup) -> str:
    """Replace the paths of the logs by their file names in a message."""
    for path, member in zip(paths, group.members, strict=True):
        name = "" if len(paths) == 1 else f"{member.name.file}: "
        for prefix in (f"{path}: ", f"{path.name}: "):
            if text.startswith(prefix):
                text = f"{name}{text.removeprefix(prefix)}"
        text = text.replace(str(path), member.name.file)
    return text


def identify_groups(
    identify_one: IdentifyJob,
    requested: Sequence[LogGroup],
    *,
    cores: int | None = None,
    cluster: str | None = None,
    tick: Callable[[float], None] = lambda part: None,
) -> Iterator[tuple[int, BatchResult]]:
    """Yield the index and the result of each group, in the order of completion.

    If all logs together have less than WORTH_SHARING bytes and `cores` is None, this process
    identifies all groups.

    - cores: number of processes; None lets the program choose
    - cluster: address of a Dask cluster, used in place of local processes
    - tick: callback that takes the completed fraction, 0 to 1
    """
    jobs = [(tuple(member.path for member in group.members), group) for group in requested]
    few = (
        sum(path.stat().st_size for paths, _ in jobs for path in paths if path.is_file())
        < WORTH_SHARING
    )
    alone = 1 if few else None
    for done, (index, one) in enumerate(
        share_files(identify_one, jobs, identify_one.gone, cores=cores or alone, cluster=cluster), 1
    ):
        tick(done / len(requested))
        yield index, one
