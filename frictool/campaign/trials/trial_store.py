"""File of trials, appended while a campaign runs: a killed campaign loses one batch at most, and
the same command continues it.

JSON, a line each: the header, which identifies the campaign; a trial [draw, found, met] or [draw,
why it could not be simulated]; {"worst": ..} of a search that has ended. A trial whose line was cut
off is played again.
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
from frictool.campaign.trials.trials import TrialResult
from frictool.errors import FrictoolError, InputFileError, OutputError

FORMAT = "campaign-trials/2"
NO_TRIALS = "holds no kept trials; name another file, or remove this one"
Header = Mapping[str, Any]
SearchKey = tuple[
    str, int, int
]  # of a search: metric, how many plants it may try, how many draws it knew


class TrialStore:
    """The file at `path`, or none where it is None: what is there of this campaign, and what is
    added.

    header: what makes a campaign another one; values as JSON has them. trials: by draw; worst: of
    searches, by what was asked. Raises InputFileError where the file is of another campaign or
    damaged, OutputError where it cannot be written.
    """

    def __init__(self, path: Path | None, header: Header) -> None:
        self.path, self.trials, self.worst = (
            path,
            dict[int, TrialResult](),
            dict[SearchKey, SearchResult](),
        )
        self._file: TextIO | None = None
        if path is None:
            return
        if path.is_dir():
            raise InputFileError(path, "is a directory; name a file in which trials are kept")
        try:
            self._file = path.open("a", encoding="utf-8")
            _lock(
                self._file, path
            )  # before it is read: another campaign's last line may be half written
            self._read(path, header)
        except OSError as error:
            self.close()
            raise OutputError(f"{path}: cannot be written: {error.strerror or error}") from None
        except FrictoolError:
            self.close()
            raise

    def add(self, trials: Sequence[TrialResult]) -> None:
        """Appends trials that have been played."""
        for trial in trials:
            self.trials[trial.draw] = trial
        self._write(*(_row(trial) for trial in trials))

    def add_worst(self, asked: SearchKey, worst: SearchResult) -> None:
        """Appends the result of a search."""
        self.worst[asked] = worst
        self._write(
            {
                "worst": list(asked),
                "value": _number(worst.value),
                "drawn": _number(worst.drawn),
                "unit": list(worst.unit),
                "noise": worst.noise,
                "evaluations": worst.evaluations,
                "unplayed": worst.unplayed,
            }
        )

    def remove(self) -> None:
        """Closes and deletes the file, whose campaign is done."""
        self.close()
        if self.path is not None:
            self.path.unlink(missing_ok=True)

    def close(self) -> None:
        """Closes the file."""
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
        if (
            error is not None and not self.trials and not self.worst
        ):  # nothing is lost, and no other campaign is in its way
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
        """What is there, without what a kill has left of a line; a new file begins with the
        header."""
        assert self._file is not None
        data = path.read_bytes()
        lines = data.split(b"\n")[:-1]
        if not lines and data and not data.startswith(b'{"format"'[: len(data)]):
            raise InputFileError(path, NO_TRIALS)
        for number, line in enumerate(lines, start=1):
            try:
                self._take(path, number, json.loads(line), header)
            except (ValueError, KeyError, TypeError, IndexError):
                message = (
                    "is no line of kept trials; name another file, or remove this one to begin anew"
                )
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


def _same_campaign(path: Path, found: Any, header: Header) -> None:
    """Raises InputFileError with the first thing in which the file's campaign is another one."""
    if not isinstance(found, dict) or found.get("format") != FORMAT:
        raise InputFileError(path, NO_TRIALS)
    ours = json.loads(json.dumps(header))
    for key in ours:
        if found.get(key) != ours[key]:
            there, here = (json.dumps(one) for one in (found.get(key), ours[key]))
            seen = f": found {there}, here {here}" if max(len(there), len(here)) <= 40 else ""
            raise InputFileError(
                path,
                f"is of another campaign, with another {key}{seen}; name another file, or remove this one",
            )


def _row(trial: TrialResult) -> list[Any]:
    if trial.failed:
        return [trial.draw, trial.failed]
    return [trial.draw, [_number(value) for value in trial.found], list(trial.met)]


def _trial(row: Any) -> TrialResult:
    if len(row) == 2:
        draw, failed = row
        return TrialResult(int(draw), (), (), str(failed))
    draw, found, met = row
    return TrialResult(int(draw), tuple(map(_float, found)), tuple(map(int, met)))


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
    """JSON has neither nan nor infinities."""
    return value if math.isfinite(value) else None if math.isnan(value) else repr(value)


def _float(value: Any) -> float:
    return math.nan if value is None else float(value)


def _lock(file: TextIO, path: Path) -> None:
    """Raises OutputError where another campaign writes the file; where a system has no such locks
    nothing is known."""
    with contextlib.suppress(ImportError):
        import fcntl

        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise OutputError(
                f"{path}: another campaign writes it now; wait for it, or name another file"
            ) from None
        except OSError:  # a file system without locks
            return
