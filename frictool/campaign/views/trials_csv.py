"""CSV table of all trials, one row per draw, for other tools."""

from __future__ import annotations

import csv
import io

from frictool.campaign.trials.trials import BROKEN, MET, Trials

MARKS = {MET: "met", BROKEN: "broken"}


def as_csv(trials: Trials) -> str:
    """Return the trials as CSV text; the cell of an absent value is empty.

    The columns are the draw, the outcome, the reason if the draw could not be simulated, each
    factor [SI], and each metric [SI] with the outcome of its requirement.
    """
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    units = [_headed(factor.name, factor.unit) for factor in trials.space.factors]
    for metric in trials.metrics:
        units += [_headed(metric.name, metric.unit), f"{metric.name} met"]
    writer.writerow(["draw", "passed", "not simulated", *units])
    for draw in range(trials.count):
        row: list[object] = [
            draw,
            MARKS.get(int(trials.passed[draw]), ""),
            trials.failed.get(draw, ""),
            *map(repr, trials.values[draw].tolist()),
        ]
        for value, met in zip(
            trials.metric_values[draw].tolist(), trials.met[draw].tolist(), strict=True
        ):
            row += ["" if value != value else repr(value), MARKS.get(met, "")]
        writer.writerow(row)
    return out.getvalue()


def _headed(name: str, unit: str) -> str:
    return f"{name} [{unit}]" if unit not in ("", "1") else name
