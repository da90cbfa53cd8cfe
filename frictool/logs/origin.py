"""Which actuator a log is of, and of when: from its metadata, or from what its file is called.

unit    record `log`, key `unit` (`frictool ingest --unit`); else what a pattern finds in the file's
        name; else the folder it is in, if any
date    record `log`, key `date`; else what the clock of a recording showed; else what a pattern
        finds in the file's name
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime

from frictool.logs.canonical.mcap_layout import DATE, EPOCH_KEY, KIND, NS, TIME, UNIT
from frictool.logs.log import Log

EARLIEST = (
    946_684_800 * NS
)  # the year 2000: a clock that shows less counts from when it was switched on
DIGITS = {8: "%Y%m%d", 10: "%Y%m%d%H", 12: "%Y%m%d%H%M", 14: "%Y%m%d%H%M%S"}


@dataclass(frozen=True)
class NamePatterns:
    """Regular expressions for the file's name with its folders; what counts are its groups, joined
    by -, or all of the match."""

    unit: str | None = None
    date: str | None = None


@dataclass(frozen=True)
class LogOrigin:
    """unit: as it is called. date: ISO 8601, UTC where a clock told it. None: nothing tells it."""

    unit: str | None
    date: str | None


@dataclass(frozen=True)
class LogName:
    """What a log's file is called, with its folders, and the last of those that are below a folder
    that was given, or nothing."""

    file: str
    folder: str = ""


def origin_of(
    noted: Mapping[str, str],
    clock_ns: int | None,
    first: float,
    name: LogName,
    patterns: NamePatterns,
) -> LogOrigin:
    """Of a log that has been read. noted: its metadata record `log`. clock_ns: the clocks' time at
    its 0. first: its first sample, s."""
    called = origin_by_name(name, patterns)
    return LogOrigin(
        noted.get(UNIT) or called.unit, noted.get(DATE) or _of_clock(clock_ns, first) or called.date
    )


def origin_of_log(log: Log, name: LogName, patterns: NamePatterns) -> LogOrigin:
    """The same of a log in memory."""
    clock = log.metadata.get(TIME, {}).get(EPOCH_KEY)
    first = float(log.main.time[0]) if log.main.time.size else 0.0
    return origin_of(
        log.metadata.get(KIND, {}), None if clock is None else int(clock), first, name, patterns
    )


def origin_by_name(name: LogName, patterns: NamePatterns) -> LogOrigin:
    """The same by what the file is called alone."""
    unit = _found(patterns.unit, name.file) or name.folder
    return LogOrigin(unit or None, as_date(_found(patterns.date, name.file) or ""))


def unmatched_patterns(patterns: NamePatterns, names: Sequence[LogName]) -> list[str]:
    """Of a pattern that tells nothing of any of the logs, which its option may have been misspelt
    for: why, for people."""
    told = []
    for option, pattern in (("--unit", patterns.unit), ("--date", patterns.date)):
        found = [
            (name.file, text) for name in names if pattern and (text := _found(pattern, name.file))
        ]
        if pattern and not found:
            told.append(
                f"{option} {pattern!r} finds nothing in the name of any log, such as {names[0].file}"
            )
        elif option == "--date" and found and not any(as_date(text) for _, text in found):
            file, text = found[0]
            told.append(
                f"--date {pattern!r} finds {text!r} in {file}, which is no date: year, month, day, and hour, minute, second"
            )
    return told


def _of_clock(clock_ns: int | None, first: float) -> str | None:
    """When the first sample was, by what dates the log."""
    if clock_ns is None or clock_ns < EARLIEST:
        return None
    return datetime.fromtimestamp(clock_ns // NS + round(first), UTC).strftime("%Y-%m-%dT%H:%M:%SZ")


def as_date(text: str) -> str | None:
    """ISO 8601 from year, month, day, and hour, minute, second where they are there, with anything
    between them; None where it is no date.

    >>> as_date("2026-01-03_08h15")
    '2026-01-03T08:15:00'
    """
    digits = "".join(re.findall(r"[0-9]+", text))
    if len(digits) not in DIGITS:
        return None
    try:
        found = datetime.strptime(digits, DIGITS[len(digits)])
    except ValueError:
        return None
    return found.strftime("%Y-%m-%d" if len(digits) == 8 else "%Y-%m-%dT%H:%M:%S")


def _found(pattern: str | None, name: str) -> str | None:
    match = re.search(pattern, name) if pattern else None
    if match is None:
        return None
    return "-".join(group for group in match.groups() if group) or match.group()
