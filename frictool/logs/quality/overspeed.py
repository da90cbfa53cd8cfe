"""Warning about a simulated speed above the largest speed of the axis."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from frictool.documents.bench import Bench
from frictool.documents.quantity import si_unit
from frictool.logs.log import Stream


def exceeds_top_speed(speed: float, bench: Bench) -> bool:
    """Return True if a speed [rad/s | m/s] exceeds `mechanics.top_speed`, to four digits."""
    top = bench.mechanics.top_speed
    return top is not None and float(f"{speed:.4g}") > top.value


def overspeed_words(speed: float, bench: Bench, name: str) -> str:
    """Return a warning if a simulated speed exceeds `mechanics.top_speed` of the bench, else "".

    - speed: largest simulated speed [rad/s | m/s]
    - name: name of the simulated plant or stream with this speed
    """
    top = bench.mechanics.top_speed
    if top is None or not exceeds_top_speed(speed, bench):
        return ""
    unit = si_unit("velocity", bench.axis)
    return (
        f"{name}: the simulated speed reaches {speed:.4g} {unit}, above mechanics.top_speed, "
        f"{top.value:.4g} {unit}; try a longer response_time_95_s or a slower prefilter"
    )


def overspeed_of_streams(streams: Mapping[str, Stream], bench: Bench) -> str:
    """Return the warning of `overspeed_words` for the fastest stream; "" without a warning."""
    speeds = {
        name: float(np.nanmax(np.abs(one.signals["velocity"]), initial=0.0))
        for name, one in streams.items()
        if "velocity" in one.signals
    }
    fastest = max(speeds, key=speeds.__getitem__, default="")
    return overspeed_words(speeds[fastest], bench, fastest) if speeds else ""
