"""File of completed trials, from which an interrupted campaign is continued.

The file has one JSON value per line. The first value is the header, which identifies the campaign.
A trial is [draw, metric values, met], or [draw, reason] if it could not be simulated. A completed
search is an object with the key "worst". Trials that were not written completely are simulated
again.
"""

from __future__ import annotations

import contextlib
import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any, TextIO

from frictool.campaign.trials.differential_evolution import SearchResult
from frictool.campaign.trials.stored_trials import StoredTrials
from frictool.campaign.trials.trials import TrialResult
from frictool.errors import FrictoolError, InputFileError, OutputError

FORMAT = "campaign-trials/2"
NO_TRIALS = "contains no stored trials; choose another file, or remove this file"
Header = Mapping[str, Any]
# metric, largest number of plants to try, number of draws
SearchKey = tuple[str, int, int]


class TrialStore:
    """Stored trials and worst-case searches of one campaign.

    `path`: file of the trials; None to keep them in memory only.
    `header`: JSON values that identify the campaign.
    `trials`: result of each trial, by the index of the draw.
    `worst`: result of each search, by the key of the search.

    Raises InputFileError if the file belongs to another campaign or is damaged, and OutputError if
    the file cannot be written.
    """

    def __init__(self, path: Path | None, header: Header) -> None:
        self.path = path
        self.trials = StoredTrials()
        self.worst = dict[SearchKey, SearchResult]()
        self._file: TextIO | None = None
        if path is None:
            return
        if path.is_dir():
            raise InputFileError(path, "is a directory; name a file for the trials")
        try:
            self._file = path.open("a", encoding="utf-8")
            _lock(self._file, path)  # before reading, because another campaign may be writing
            self._read(path, header)
        except OSError as error:
            self.close()
            raise OutputError(f"{path}: cannot be written: {error.strerror or error}") from None
        except FrictoolError:
            self.close()
            raise

    def add(self, trials: Sequence[TrialResult]) -> None:
        """Append completed trials to the file."""
        for trial in trials:
            self.trials[trial.draw] = trial
        self._write(*(_row(trial) for trial in trials))

    def add_worst(self, key: SearchKey, worst: SearchResult) -> None:
        """Append the result of a worst-case search to the file."""
        self.worst[key] = worst
        self._write(
            {
                "worst": list(key),
                "value": _number(worst.value),
                "drawn": _number(worst.drawn),
                "unit": list(worst.unit),
                "noise": worst.noise,
                "evaluations": worst.evaluations,
                "unplayed": worst.unplayed,
            }
        )

    def remove(self) -> None:
        """Close and delete the file of a completed campaign."""
        self.close()
        if self.path is not None:
            self.path.unlink(missing_ok=True)

    def close(self) -> None:
        """Close the file."""
        if self._file is not None:
            self._file.close()
            self._file = None

    def __enter__(self) -> TrialStore:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        # an empty file is deleted, so that it does not block another campaign
        if error is not None and not self.trials and not self.worst:
            self.remove()
        self.close()

    def _write(self, *rows: Any) -> None:
        if self._file is None or not rows:
            return
        try:
            self._file.write(
                "".join(
                    json.dumps(row, separators=(",", ":"), allow_nan=False) + "\n" for row in rows
                )
            )
            self._file.flush()
        except OSError as error:
            raise OutputError(
                f"{self.path}: cannot be written: {error.strerror or error}"
            ) from None

    def _read(self, path: Path, header: Header) -> None:
        assert self._file is not None
        data = path.read_bytes()
        lines = data.split(b"\n")[:-1]
        if not lines and data and not data.startswith(b'{"format"'[: len(data)]):
            raise InputFileError(path, NO_TRIALS)
        for number, line in enumerate(lines, start=1):
            try:
                self._take(path, number, json.loads(line), header)
            except (ValueError, KeyError, TypeError, IndexError):
                message = "is not a line of stored trials; choose another file, or remove this file"
                raise InputFileError(path, message, line=number) from None
        self._file.truncate(sum(len(line) + 1 for line in lines))
        if not lines:
            self._write({"format": FORMAT, **header})

    def _take(self, path: Path, number: int, row: Any, header: Header) -> None:
        if number == 1:
            _same_campaign(path, row, header)
        elif isinstance(row, dict):
            name, most, draws = row["worst"]
            self.worst[str(name), int(most), int(draws)] = _worst(row)
        else:
            trial = _trial(row)
            self.trials[trial.draw] = trial


def _same_campaign(path: Path, stored: Any, header: Header) -> None:
    if not isinstance(stored, dict) or stored.get("format") != FORMAT:
        raise InputFileError(path, NO_TRIALS)
    ours = json.loads(json.dumps(header))
    for key in ours:
        if stored.get(key) != ours[key]:
            there, here = (json.dumps(one) for one in (stored.get(key), ours[key]))
            seen = f": found {there}, here {here}" if max(len(there), len(here)) <= 40 else ""
            raise InputFileError(
                path,
                f"belongs to another campaign, whose {key} is different{seen}; name another file, "
                "or remove this file",
            )


def _row(trial: TrialResult) -> list[Any]:
    if trial.failed:
        return [trial.draw, trial.failed]
    return [trial.draw, [_number(value) for value in trial.metric_values], list(trial.met)]


def _trial(row: Any) -> TrialResult:
    if len(row) == 2:
        draw, failed = row
        return TrialResult(int(draw), (), (), str(failed))
    draw, values, met = row
    return TrialResult(int(draw), tuple(map(_float, values)), tuple(map(int, met)))


def _worst(row: Mapping[str, Any]) -> SearchResult:
    numbers = int(row["noise"]), int(row["evaluations"]), int(row["unplayed"])
    return SearchResult(
        str(row["worst"][0]),
        _float(row["value"]),
        _float(row["drawn"]),
        tuple(map(float, row["unit"])),
        *numbers,
    )


def _number(value: float) -> float | str | None:
    return value if math.isfinite(value) else None if math.isnan(value) else repr(value)


def _float(value: Any) -> float:
    return math.nan if value is None else float(value)


def _lock(file: TextIO, path: Path) -> None:
    with contextlib.suppress(ImportError):
        import fcntl

        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise OutputError(
                f"{path}: another campaign is writing to this file; wait, or name another file"
            ) from None
        except OSError:  # the file system has no locks
            return
