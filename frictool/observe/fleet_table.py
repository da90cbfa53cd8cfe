"""Table of a fleet as text, CSV, Parquet and JSON, with one row per log.

Each row contains the wear, and the wear divided by the wear at the unit's commissioning.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any, BinaryIO

from frictool.logs.losses import loss_count_text
from frictool.observe.commissioning import Commissioning, commissioning_of_estimate
from frictool.observe.fleet import FleetResult
from frictool.observe.observation_outcome import ObservationOutcome, ratio_to
from frictool.observe.wear_estimate import EstimateRange
from frictool.observe.wear_limit import WearVerdict, judge
from frictool.presentation.sections import TextTable

ESTIMATED = ("wear", "low", "high", "ratio", "ratio_low", "ratio_high")
COLUMNS = (
    "unit",
    "date",
    "file",
    *ESTIMATED,
    "kind",
    "moves",
    "velocity_rms",
    "duration_s",
    "alarm",
    "reason",
)
TEXTS = ("unit", "date", "file", "kind", "reason")
# rightmost columns of the table, which a narrow terminal cuts off
SEEN_LAST = ("kind", "moves", "velocity_rms", "duration_s", "reason")


@dataclass(frozen=True)
class FleetRow:
    """Result for one log.

    - ratio: wear divided by the wear of the unit at commissioning; None if either is unknown
    - verdict: comparison of the wear with the limit; None if there is no limit or no outcome
    - reason: reason for the verdict, or for a missing result
    - first: True if this log is the first of its unit, with which the later logs are compared
    """

    file: str
    unit: str | None
    date: str | None
    outcome: ObservationOutcome | None
    ratio: EstimateRange | None
    verdict: WearVerdict | None
    reason: str
    first: bool = False

    @property
    def alarm(self) -> bool | None:
        """Return True if the wear is above the limit; None if undecided or without a verdict."""
        return None if self.verdict is None else self.verdict.exceeded

    def cells(self) -> dict[str, Any]:
        """Return the value of each column; None marks an empty cell."""
        out = self.outcome
        estimate = None if out is None else out.estimate
        return {
            "unit": self.unit,
            "date": self.date,
            "file": self.file,
            **_range("wear", "low", "high", None if estimate is None else estimate.wear),
            **_range("ratio", "ratio_low", "ratio_high", self.ratio),
            "kind": None if estimate is None else estimate.kind,
            "moves": None if estimate is None else estimate.moves,
            "velocity_rms": None if out is None else out.figures.get("velocity_rms"),
            "duration_s": None if out is None else out.duration,
            "alarm": self.alarm,
            "reason": self.reason or None,
        }

    def as_json(self) -> dict[str, Any]:
        """Return the JSON object of `observe run` for this log, extended by the row's fields."""
        outcome = {} if self.outcome is None else self.outcome.as_json()
        ratio = {} if self.ratio is None else {"ratio": self.ratio.as_json()}
        limit = None if self.verdict is None else self.verdict.limit
        verdict = {"wear_limit": limit, "alarm": self.alarm, "reason": self.reason or None}
        return {
            **outcome,
            "log": self.file,
            "unit": self.unit,
            "date": self.date,
            **ratio,
            **verdict,
            "read": self.outcome is not None,
        }


def _range(
    value: str, low: str, high: str, estimate: EstimateRange | None
) -> dict[str, float | None]:
    return (
        {value: None, low: None, high: None}
        if estimate is None
        else {value: estimate.value, low: estimate.low, high: estimate.high}
    )


def rows(
    fleet: Sequence[FleetResult], limit: float | None, commissioning: Commissioning | None
) -> list[FleetRow]:
    """Return one row per log, sorted by unit, date and file.

    - limit: largest allowed wear. If the wear at commissioning is known, the limit applies to the
      wear divided by the wear at commissioning.
    - commissioning: one wear at commissioning for all units. If None, each unit is compared with
      its first log that has an estimate.
    """
    first = {} if commissioning is not None else _first_logs(fleet)
    made = [_row(one, limit, commissioning, first) for one in fleet]
    return sorted(made, key=lambda row: (row.unit or "", row.date or "", row.file))


def _first_logs(fleet: Iterable[FleetResult]) -> dict[str, FleetResult]:
    """Return for each unit the earliest dated log that determines the wear."""
    dated = [
        (one.origin.date, one.member.name.file, one)
        for one in fleet
        if one.origin.date is not None and one.outcome is not None
    ]
    first: dict[str, FleetResult] = {}
    for _, _, one in sorted(dated, key=lambda entry: entry[:2]):
        estimate = None if one.outcome is None else one.outcome.estimate
        if (
            one.origin.unit is not None
            and estimate is not None
            and estimate.moves
            and estimate.wear.low > 0.0
        ):
            first.setdefault(one.origin.unit, one)
    return first


def _row(
    one: FleetResult,
    limit: float | None,
    commissioning: Commissioning | None,
    first: dict[str, FleetResult],
) -> FleetRow:
    out = one.outcome
    unit = one.origin.unit
    date = one.origin.date
    if out is None:
        return FleetRow(one.member.name.file, unit, date, None, None, None, one.reason)
    start = first.get(unit or "")
    reference = commissioning
    if start is not None and start is not one and start.outcome is not None:
        reference = commissioning_of_estimate(start.outcome.estimate, start.member.name.file)
    ratio = ratio_to(reference, out.estimate)
    verdict = None if limit is None else judge(out.estimate, limit, ratio, out.doubts)
    reasons = [] if verdict is None else [verdict.reason]
    reasons += [f"data lost: {loss_count_text(list(out.losses))}"] if out.losses else []
    reasons += ["first log of its unit"] if start is one else []
    return FleetRow(
        one.member.name.file, unit, date, out, ratio, verdict, "; ".join(reasons), start is one
    )


def counts(table: Sequence[FleetRow]) -> dict[str, int]:
    """Return the number of logs above the limit, undecided, not read, and with lost data."""
    return {
        "above_limit": sum(bool(row.alarm) for row in table),
        "undecided": sum(row.verdict is not None and row.verdict.exceeded is None for row in table),
        "not_read": sum(row.outcome is None for row in table),
        "data_lost": sum(row.outcome is not None and bool(row.outcome.losses) for row in table),
    }


def headline(table: Sequence[FleetRow], limit: float | None) -> str:
    """Return a one-line summary of the table."""
    lost, parts = counts(table)["not_read"], counts(table)["data_lost"]
    units = len({row.unit for row in table if row.unit is not None})
    text = f"{len(table)} log{'s' * (len(table) != 1)}" + (
        f" of {units} unit{'s' * (units != 1)}" if units else ""
    )
    text += f", {lost} could not be read" if lost else ""
    text += f", {parts} read with data lost" if parts else ""
    if limit is None:
        return text
    above = [row for row in table if row.alarm]
    worn = f": {', '.join(dict.fromkeys(row.unit or row.file for row in above))}" if above else ""
    undecided = counts(table)["undecided"]
    return f"{text}; above the limit {limit:g}: {len(above)}{worn}" + (
        f"; undecided: {undecided}" if undecided else ""
    )


def text_table(table: Sequence[FleetRow]) -> TextTable:
    """Return the table as cells of text; empty columns are left out."""
    cells = [{name: _short(value) for name, value in _joined(row).items()} for row in table]
    ordered = [*(name for name in COLUMNS if name not in SEEN_LAST), *SEEN_LAST]
    names = [name for name in ordered if any(one.get(name) for one in cells)]
    headings = tuple(name.replace("_", " ") for name in names)
    return TextTable("Logs", headings, tuple(tuple(one[name] for name in names) for one in cells))


def _joined(row: FleetRow) -> dict[str, Any]:
    """Return the cells of a row; a value and its interval are joined in one cell."""
    cells = row.cells()
    for value, low, high in (("wear", "low", "high"), ("ratio", "ratio_low", "ratio_high")):
        ends = cells.pop(low), cells.pop(high)
        if cells[value] is not None:
            cells[value] = f"{cells[value]:.4g} [{ends[0]:.4g}, {ends[1]:.4g}]"
    return cells


def _short(value: Any) -> str:
    if isinstance(value, bool):
        return "ALARM" if value else "no"
    return "" if value is None else f"{value:.4g}" if isinstance(value, float) else str(value)


def as_csv(table: Sequence[FleetRow]) -> str:
    """Return the table as CSV (RFC 4180, but lines end with LF only), with a header line."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(COLUMNS)
    for row in table:
        writer.writerow([_cell(value) for value in row.cells().values()])
    return out.getvalue()


def _cell(value: Any) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return "true" if value else "false"
    return repr(value) if isinstance(value, float) else str(value)


def write_parquet(table: Sequence[FleetRow], target: BinaryIO, provenance: dict[str, str]) -> None:
    """Write the table as Parquet; dates are time stamps in UTC."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    kinds = dict.fromkeys(COLUMNS, pa.float64()) | dict.fromkeys(TEXTS, pa.string())
    kinds |= {"date": pa.timestamp("us", tz="UTC"), "moves": pa.int64(), "alarm": pa.bool_()}
    cells = [{**row.cells(), "date": _stamp(row.date)} for row in table]
    schema = pa.schema([pa.field(name, kinds[name]) for name in COLUMNS], metadata=provenance)
    pq.write_table(pa.Table.from_pylist(cells, schema=schema), target, compression="zstd")


def _stamp(date: str | None) -> datetime | None:
    if date is None:
        return None
    stamp = datetime.fromisoformat(date)
    return stamp if stamp.tzinfo is not None else stamp.replace(tzinfo=UTC)
