"""Views of a batch: table with one row per group of logs, JSON, and text on the scatter."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from datetime import UTC, datetime
from typing import Any, BinaryIO

from frictool.documents.bench import Bench
from frictool.identify.batch import BatchResult
from frictool.identify.fit_result import CURVE, PARAMETERS, Interval
from frictool.identify.model_document import unit_of
from frictool.identify.population import (
    DAY_S,
    ParameterDrift,
    Population,
    ScatterTest,
    UnitValue,
    populations,
)

ESTIMATES = (*PARAMETERS, *CURVE)
TEXTS = ("unit", "date", "file", "model", "method", "reason")
COLUMNS = (
    *TEXTS[:4],
    *(column for name in ESTIMATES for column in (name, f"{name}_low", f"{name}_high")),
    "force_error",
    "samples",
    *TEXTS[4:],
)
MONTH_DAYS = 30.0
MOST_NAMED = 5  # largest number of machines (units) named in one line


def model_file(one: BatchResult) -> str | None:
    """Return the path of the model file relative to the output folder; None without a model."""
    return None if one.model is None else f"{one.group.name}.yaml"


def ordered(batch: Sequence[BatchResult]) -> list[BatchResult]:
    """Return the results sorted by unit, date and file."""
    return sorted(
        batch, key=lambda one: (one.origin.unit or "", one.origin.date or "", one.group.files)
    )


def cells(one: BatchResult) -> dict[str, Any]:
    """Return the value of each column in the row of a result; None marks an empty cell.

    Only parameters that were identified from the logs have values.
    """
    row: dict[str, Any] = dict.fromkeys(COLUMNS)
    row |= {
        "unit": one.origin.unit,
        "date": one.origin.date,
        "file": one.group.files,
        "model": model_file(one),
        "reason": one.reason or None,
    }
    if one.model is None:
        return row
    for name, interval in one.model.identified.items():
        row |= {name: interval.value, f"{name}_low": interval.low, f"{name}_high": interval.high}
    fit = one.model.fit
    return (
        row
        | {"method": one.model.method}
        | ({} if fit is None else {"force_error": fit.force_error, "samples": fit.samples})
    )


def as_csv(batch: Sequence[BatchResult]) -> str:
    """Return the table as CSV with a header line (RFC 4180, but with LF line ends)."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(COLUMNS)
    for one in batch:
        writer.writerow(
            [
                "" if cell is None else repr(cell) if isinstance(cell, float) else cell
                for cell in cells(one).values()
            ]
        )
    return out.getvalue()


def write_parquet(
    batch: Sequence[BatchResult], bench: Bench, target: BinaryIO, provenance: dict[str, str]
) -> None:
    """Write the table as Parquet, with dates as UTC time stamps and units in the field metadata."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    kinds = dict.fromkeys(COLUMNS, pa.float64()) | dict.fromkeys(TEXTS, pa.string())
    kinds |= {"date": pa.timestamp("us", tz="UTC"), "samples": pa.int64()}
    units = {
        column: {"unit": unit_of(name, bench)}
        for name in ESTIMATES
        for column in (name, f"{name}_low", f"{name}_high")
    }
    schema = pa.schema(
        [pa.field(name, kinds[name], metadata=units.get(name)) for name in COLUMNS],
        metadata=provenance,
    )
    rows = [
        {**cells(one), "date": None if one.origin.date is None else _moment(one.origin.date)}
        for one in batch
    ]
    pq.write_table(pa.Table.from_pylist(rows, schema=schema), target, compression="zstd")


def _moment(date: str) -> datetime:
    moment = datetime.fromisoformat(date)
    return moment if moment.tzinfo is not None else moment.replace(tzinfo=UTC)


def batch_populations(batch: Sequence[BatchResult], confidence: float) -> dict[str, Population]:
    """Return scatter and tests (`Population`) of each parameter with values in several models."""
    values: dict[str, list[UnitValue]] = {name: [] for name in ESTIMATES}
    for one in batch:
        if one.model is not None:
            day = None if one.origin.date is None else _moment(one.origin.date).timestamp() / DAY_S
            for name, interval in one.model.identified.items():
                values[name].append(UnitValue(interval, one.origin.unit, day))
    return populations(values, confidence)


def headline(batch: Sequence[BatchResult]) -> str:
    """Return a line with the numbers of models, of machines, and of groups without a model."""
    units = len({one.origin.unit for one in batch if one.origin.unit is not None})
    lost = sum(one.lost for one in batch)
    empty = sum(one.model is None and not one.lost for one in batch)
    models = sum(one.model is not None for one in batch)
    line = f"{models} model{'s' * (models != 1)}" + (
        f" of {units} unit{'s' * (units != 1)}" if units else ""
    )
    line += f", {lost} could not be made: a log cannot be used" if lost else ""
    return line + (f", {empty} could not be made: nothing identified" if empty else "")


def reasons(batch: Sequence[BatchResult]) -> list[str]:
    """Return one line for each group without a model, and one for each warning about a model."""
    lines = []
    first: dict[tuple[tuple[str, Interval], ...], BatchResult] = {}
    for one in batch:
        texts = (
            [one.reason]
            if one.model is None
            else [f"warning: {text}" for text in one.model.warnings]
        )
        if one.model is not None:
            same = first.setdefault(tuple(one.model.identified.items()), one)
            if same is not one:
                texts.append(
                    f"warning: gives the same numbers as {same.group.files}; a duplicate log "
                    "makes the population look more uniform than it is"
                )
        lines += [f"{one.group.files}: {text}" for text in texts]
    return lines


def population_lines(parameters: dict[str, Population], bench: Bench) -> list[str]:
    """Return a text table: scatter of each parameter between the models, and a conclusion."""
    if not parameters:
        return []
    width = max(map(len, ("parameter", *parameters))) + 2
    lines = [
        f"{'parameter':<{width}}{'models':>6}{'mean':>12}{'spread':>12}{'expected':>12}  "
        f"{'unit':<11} one population?"
    ]
    for name, one in parameters.items():
        figures = f"{one.count:>6}{one.mean:>12.5g}{one.spread:>12.3g}{one.expected:>12.3g}"
        lines.append(f"{name:<{width}}{figures}  {unit_of(name, bench):<11} {conclusion(one)}")
    lines.append(
        "spread: standard deviation of the values; expected: standard deviation that "
        "the intervals explain"
    )
    return lines


def conclusion(one: Population) -> str:
    """Return "yes" if all models may have the same true value, else "no" with the reason."""
    no = []
    if one.between is not None and one.rejects(one.between):
        no.append(f"units differ by {one.between.beyond:.2g} {_p(one.between.p)}")
    if one.within is not None and one.rejects(one.within):
        which = f" ({', '.join(one.changing[:MOST_NAMED])})" if one.changing else ""
        no.append(f"logs of one unit{which} differ by {one.within.beyond:.2g} {_p(one.within.p)}")
    if one.drift is not None and one.rejects(one.drift):
        no.append(
            f"the values drift by {MONTH_DAYS * one.drift.slope.value:+.2g} in {MONTH_DAYS:g} days "
            f"{_p(one.drift.p)}"
        )
    if not no and one.rejects(one.whole):
        no.append(
            f"models differ by {one.whole.beyond:.2g} beyond their intervals {_p(one.whole.p)}"
        )
    return f"no: {'; '.join(no)}" if no else f"yes {_p(one.whole.p)}"


def _p(p: float) -> str:
    return f"(p = {p:.2g})" if p >= 1e-6 else "(p < 1e-6)"


def as_json(
    batch: Sequence[BatchResult], parameters: dict[str, Population], bench: Bench
) -> dict[str, Any]:
    """Return the batch as JSON values: the JSON view of each model, and the populations."""
    return {
        "models": [
            {
                "file": one.group.files,
                "model": model_file(one),
                "unit": one.origin.unit,
                "date": one.origin.date,
                "read": not one.lost,
                "reason": one.reason or None,
                "identification": None if one.model is None else one.model.view,
            }
            for one in batch
        ],
        "populations": {
            name: _population_json(one, unit_of(name, bench)) for name, one in parameters.items()
        },
    }


def _population_json(one: Population, unit: str) -> dict[str, Any]:
    def test(result: ScatterTest | None) -> dict[str, float] | None:
        return None if result is None else {"p": result.p, "beyond": result.beyond}

    def drift(result: ParameterDrift | None) -> dict[str, float] | None:
        return (
            None
            if result is None
            else {
                "per_day": result.slope.value,
                "low": result.slope.low,
                "high": result.slope.high,
                "p": result.p,
            }
        )

    figures = {
        name: getattr(one, name) for name in ("count", "units", "mean", "spread", "expected")
    }
    tests = {
        "whole": test(one.whole),
        "within_units": test(one.within),
        "between_units": test(one.between),
        "drift": drift(one.drift),
    }
    return {
        "unit": unit,
        **figures,
        **tests,
        "p_limit": one.limit,
        "changing_units": one.changing,
        "one_population": one.one,
        "conclusion": conclusion(one),
    }
