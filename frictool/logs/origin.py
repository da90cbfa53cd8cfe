"""Actuator and date of a log, taken from the log's metadata or from its path.

The following sources are tried in this order:

    unit    key `unit` of the metadata record `log` (`frictool ingest --unit`); the text that a
            pattern extracts from the file's path; the folder of the file, if any
    date    key `date` of the metadata record `log`; the clock of a recording; the text that a
            pattern extracts from the file's path
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime

from frictool.logs.canonical.mcap_layout import DATE, EPOCH_KEY, KIND, NS, TIME, UNIT
from frictool.logs.log import Log

# ns, start of the year 2000: an earlier clock counts from power-on and gives no date
EARLIEST = 946_684_800 * NS
DIGITS = {8: "%Y%m%d", 10: "%Y%m%d%H", 12: "%Y%m%d%H%M", 14: "%Y%m%d%H%M%S"}


@dataclass(frozen=True)
class NamePatterns:
    """Regular expressions that extract actuator and date from a log's path.

    unit, date: pattern of the actuator and of the date; None if there is no pattern.

    The extracted text is the whole match or, if the pattern has groups, the groups joined by "-".
    """

    unit: str | None = None
    date: str | None = None


@dataclass(frozen=True)
class LogOrigin:
    """Actuator and date of a log; unknown values are None.

    unit: name or serial number of the actuator.
    date: date in ISO 8601; a date that comes from a clock is in UTC.
    """

    unit: str | None
    date: str | None


@dataclass(frozen=True)
class LogName:
    """Path of a log, as shown to the user.

    folder: last folder in the path `file` if the log was found in a listed folder; "" if this path
        has no folder or the log itself was listed.
    """

    file: str
    folder: str = ""


def origin_of(
    noted: Mapping[str, str],
    clock_ns: int | None,
    first: float,
    name: LogName,
    patterns: NamePatterns,
) -> LogOrigin:
    """Return actuator and date of a log from its metadata, clock and path.

    noted: metadata record `log` of the log.
    clock_ns: clock time in ns at time 0 of the log; None if the log has no clock.
    first: time of the first sample, in s.
    """
    called = origin_by_name(name, patterns)
    return LogOrigin(
        noted.get(UNIT) or called.unit, noted.get(DATE) or _of_clock(clock_ns, first) or called.date
    )


def origin_of_log(log: Log, name: LogName, patterns: NamePatterns) -> LogOrigin:
    """Return actuator and date of a log in memory."""
    clock = log.metadata.get(TIME, {}).get(EPOCH_KEY)
    first = float(log.main.time[0]) if log.main.time.size else 0.0
    return origin_of(
        log.metadata.get(KIND, {}), None if clock is None else int(clock), first, name, patterns
    )


def origin_by_name(name: LogName, patterns: NamePatterns) -> LogOrigin:
    """Return the actuator and the date that the path of the log contains."""
    unit = _matched_text(patterns.unit, name.file) or name.folder
    return LogOrigin(unit or None, as_date(_matched_text(patterns.date, name.file) or ""))


def unmatched_patterns(patterns: NamePatterns, names: Sequence[LogName]) -> list[str]:
    """Return a message for each pattern that is probably misspelt.

    A pattern is probably misspelt if it matches no name. The pattern of the date is also probably
    misspelt if none of its matches is a date.

    """
    messages = []
    for option, pattern in (("--unit", patterns.unit), ("--date", patterns.date)):
        matches = [
            (name.file, text)
            for name in names
            if pattern and (text := _matched_text(pattern, name.file))
        ]
        if pattern and not matches:
            messages.append(
                f"{option} {pattern!r} matches no name of a log, such as {names[0].file}"
            )
        elif option == "--date" and matches and not any(as_date(text) for _, text in matches):
            file, text = matches[0]
            messages.append(
                f"--date {pattern!r} finds {text!r} in {file}; this is not a date; allowed: "
                "year, month and day, optionally hour, minute and second"
            )
    return messages


def _of_clock(clock_ns: int | None, first: float) -> str | None:
    if clock_ns is None or clock_ns < EARLIEST:
        return None
    return datetime.fromtimestamp(clock_ns // NS + round(first), UTC).strftime("%Y-%m-%dT%H:%M:%SZ")


def as_date(text: str) -> str | None:
    """Return the date in a text as ISO 8601; None if the text is not a date.

    The text consists of year, month and day, and optionally hour, minute and second. Any characters
    may separate the digits.

    >>> as_date("2026-01-03_08h15")
    '2026-01-03T08:15:00'
    """
    digits = "".join(re.findall(r"[0-9]+", text))
    if len(digits) not in DIGITS:
        return None
    try:
        date = datetime.strptime(digits, DIGITS[len(digits)])
    except ValueError:
        return None
    return date.strftime("%Y-%m-%d" if len(digits) == 8 else "%Y-%m-%dT%H:%M:%S")


def _matched_text(pattern: str | None, name: str) -> str | None:
    match = re.search(pattern, name) if pattern else None
    if match is None:
        return None
    return "-".join(group for group in match.groups() if group) or match.group()
