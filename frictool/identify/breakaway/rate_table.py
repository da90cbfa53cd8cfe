"""Breakaway as a function of the ramp's rate, from a table of single breakaways.

The table is a CSV file with two columns: the effort at which the axis started to move, and the rate
of the effort's ramp. A header names the columns `effort` and `rate`; without a header, the effort
is the first column. The effort is in N m | N; the rate may have any unit.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import scipy

from frictool.errors import LogError
from frictool.identify.fit_result import Interval
from frictool.typing import Vector

FEWEST = 2  # least number of breakaways at one rate
LARGEST = 1_000_000  # largest size of a table, bytes
UNIT = re.compile(r"\s*[\[(][^\])]*[\])]")  # unit of a column, in the header
EFFORT_UNIT = re.compile(r"effort\s*[\[(]([^\])]*)[\])]", re.IGNORECASE)
EFFORT_UNITS = ("N m", "Nm", "N")
SEPARATOR = re.compile(r"\s*[,;\t]\s*|\s+")


@dataclass(frozen=True)
class RateTable:
    """Breakaway efforts (n,), N m | N, and the rates of their ramps (n,), in any unit."""

    name: str
    effort: Vector
    rate: Vector


@dataclass(frozen=True)
class BreakawayAtRate:
    """Breakaways at one rate of the ramp.

    - rate: rate in the unit of the table
    - mean: mean breakaway and its interval, N m | N
    - count: number of breakaways
    """

    rate: float
    mean: Interval
    count: int


@dataclass(frozen=True)
class BreakawayOverRate:
    """Breakaway as a function of the ramp's rate.

    - rates: mean breakaways, in ascending order of the rate
    - per_decade: increase of the breakaway per factor of ten in the rate, N m | N; None if the
      table has a single rate
    - interval: mean breakaway of all rates, and the range that contains the intervals of all rates
    """

    rates: tuple[BreakawayAtRate, ...]
    per_decade: Interval | None
    interval: Interval


def read_rate_table(path: Path) -> RateTable:
    """Read a table from a CSV file; raise LogError with the number of an invalid line."""
    if path.stat().st_size > LARGEST:
        raise LogError(
            str(path), f"is too large for a breakaway table; allowed: at most {LARGEST} bytes"
        )
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except UnicodeDecodeError:
        raise LogError(str(path), "is not a text file in UTF-8") from None
    order = (0, 1)
    rows: list[tuple[float, float]] = []
    for number, line in enumerate(lines, start=1):
        text = line.strip() if rows else UNIT.sub("", line.strip())
        cells = [cell.strip("\"'").lower() for cell in SEPARATOR.split(text)]
        if cells == [""]:
            continue
        if not rows and {"effort", "rate"} <= set(cells):
            unit = EFFORT_UNIT.search(line)
            if unit is not None and unit[1].strip() not in EFFORT_UNITS:
                raise LogError(
                    str(path),
                    f"line {number}: found the unit {unit[1].strip()!r} of the effort; allowed: "
                    f"{' or '.join(EFFORT_UNITS)}",
                )
            order = (cells.index("effort"), cells.index("rate"))
            continue
        try:
            effort, rate = (float(cells[k]) for k in order)
        except (ValueError, IndexError):
            raise LogError(
                str(path),
                f"line {number}: found {line.strip()[:40]!r}; allowed: two numbers a line (effort, "
                "rate), after an optional header with the columns effort and rate",
            ) from None
        if not (math.isfinite(effort) and math.isfinite(rate) and rate > 0.0):
            raise LogError(
                str(path),
                f"line {number}: found rate {rate:g} and effort {effort:g}; allowed: a "
                "finite rate above 0, and a finite effort",
            )
        rows.append((abs(effort), rate))
    if len(rows) < FEWEST:
        raise LogError(str(path), f"has {len(rows)} breakaways; at least {FEWEST} are needed")
    table = np.array(rows)
    return RateTable(str(path), table[:, 0], table[:, 1])


def breakaway_over_rate(table: RateTable, confidence: float) -> BreakawayOverRate:
    """Return the breakaway at each rate of a table, and its increase with the rate.

    If a rate has a single breakaway, its scatter is taken from the other rates. Raises LogError if
    every rate has a single breakaway.
    """
    rates, index = np.unique(table.rate, return_inverse=True)
    count = np.bincount(index)
    mean = np.bincount(index, table.effort) / count
    freedom = table.effort.size - rates.size
    if freedom < 1:
        raise LogError(table.name, "has one breakaway at each rate; record several at each rate")
    pooled = float(np.sum((table.effort - mean[index]) ** 2)) / freedom
    at_rates = []
    for k, rate in enumerate(rates.tolist()):
        efforts = table.effort[index == k]
        single = efforts.size < FEWEST
        variance = pooled if single else float(np.var(efforts, ddof=1))
        quantile = scipy.special.stdtrit(
            freedom if single else efforts.size - 1, 0.5 + 0.5 * confidence
        )
        half = float(quantile) * math.sqrt(variance / efforts.size)
        at_rates.append(BreakawayAtRate(rate, Interval.around(float(mean[k]), half), efforts.size))
    low = min(one.mean.low for one in at_rates)
    high = max(one.mean.high for one in at_rates)
    return BreakawayOverRate(
        tuple(at_rates),
        _rise(np.log10(rates), mean, [one.mean for one in at_rates], confidence),
        Interval(float(np.mean(mean)), low, high),
    )


def _rise(
    decades: Vector, mean: Vector, intervals: list[Interval], confidence: float
) -> Interval | None:
    """Return the increase of the breakaway per decade of the rate, with its interval.

    `decades` (k,) are the logarithms to base 10 of the rates. A line is fitted to the mean
    breakaways (k,). The half width of its slope is the larger of two values: one follows from the
    intervals of the means, one from their scatter around the line. Return None for a single rate.
    """
    if decades.size < 2:
        return None
    x = decades - np.mean(decades)
    weights = x / float(x @ x)
    slope = float(weights @ mean)
    half = np.array([one.half_width for one in intervals])
    square = float(np.sum((weights * half) ** 2))
    if decades.size > 2:
        left = mean - np.mean(mean) - slope * x
        variance = float(left @ left) / (decades.size - 2)
        quantile = float(scipy.special.stdtrit(decades.size - 2, 0.5 + 0.5 * confidence))
        square = max(square, quantile**2 * variance / float(x @ x))
    return Interval.around(slope, math.sqrt(square))


def rate_lines(over_rate: BreakawayOverRate, unit: str) -> list[str]:
    """Return lines of text on the breakaway at each rate."""
    at = ", ".join(
        f"{one.rate:g}: {one.mean.value:.4g} [{one.mean.low:.4g}, {one.mean.high:.4g}] "
        f"({one.count})"
        for one in over_rate.rates
    )
    lines = [f"breakaway at each ramp rate [{unit}] (number of breakaways): {at}"]
    rise = over_rate.per_decade
    if rise is not None:
        verb = (
            "rises" if rise.low > 0.0 else "falls" if rise.high < 0.0 else "does not clearly rise"
        )
        lines.append(
            f"breakaway {verb} with the rate: {rise.value:.4g} {unit} a decade "
            f"[{rise.low:.4g}, {rise.high:.4g}]"
        )
    return lines
