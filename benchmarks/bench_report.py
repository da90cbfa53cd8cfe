"""Metrics of a step, compared with those of python-control on the same samples."""

from __future__ import annotations

from typing import Any

import numpy as np

from benchmarks.timing import pair
from frictool.metrics.overshoot import overshoot_percent
from frictool.metrics.response_time import response_time_95
from frictool.metrics.rise_time import rise_time

SAMPLES, RATE = 20_000, 5000.0
DAMPING, FREQUENCY = 0.3, 20.0


def report_step() -> dict[str, Any]:
    """Return the row of response time, rise time and overshoot of a hold of 20 000 samples."""
    import control

    time = np.arange(SAMPLES) / RATE
    damped = FREQUENCY * np.sqrt(1.0 - DAMPING**2)
    decay = np.exp(-DAMPING * FREQUENCY * time)
    position = 1.0 - decay * (
        np.cos(damped * time) + DAMPING * FREQUENCY / damped * np.sin(damped * time)
    )

    def ours() -> tuple[float, float, float]:
        return (
            response_time_95(time, position, 0.0, 1.0),
            rise_time(time, position, 0.0, 1.0),
            overshoot_percent(position, 0.0, 1.0),
        )

    def theirs() -> dict[str, float]:
        found: dict[str, float] = control.step_info(
            position, time, final_output=1.0, SettlingTimeThreshold=0.05
        )
        return found

    a, b = pair(ours, theirs, 21)
    mine, other = ours(), theirs()
    apart = max(abs(mine[0] - other["SettlingTime"]), abs(mine[1] - other["RiseTime"])) * RATE
    accuracy = (
        f"times within {apart:.2g} samples of theirs, overshoot within "
        f"{abs(mine[2] - other['Overshoot']):.1g} %"
    )
    return {
        "id": "report.step",
        "peer": "control.step_info",
        "ours": a,
        "theirs": b,
        "unit": "s",
        "ratio": b / a,
        "accuracy": accuracy,
    }


ROWS = [report_step]
