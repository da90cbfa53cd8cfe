"""Comparison of a drive signal with the drive's limit, to detect a mistaken unit such as mA."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from frictool.documents.bench import Bench
from frictool.documents.quantity import CHANNEL_DIMENSIONS, si_unit
from frictool.typing import Vector

SUSPECT = 2.0  # drive signal, relative to the drive's limit, above which there is a warning
# drive signal, relative to the drive's limit, above which there is an error
IMPOSSIBLE = 10.0
LEAST_SHARE = 0.01  # least share of samples above the limit; fewer samples are spikes
PER_MILLI = 1000.0


def beyond_limit(
    signals: Mapping[str, Vector], columns: Mapping[str, str], bench: Bench, ratio: float = SUSPECT
) -> str | None:
    """Return a message about a drive signal that is far beyond the drive's limit, else None.

    signals: values (n,) of each channel in SI; drive signals are current, voltage, measured effort.
    columns: name of each channel's column in the raw file. The message names a channel without an
        entry by its channel name.
    ratio: largest allowed ratio of a drive signal to the limit.
    """
    actuator = bench.actuator
    limits: dict[str, float] = {actuator.drive: actuator.limit.value}
    limits |= {"effort": actuator.limit.value * abs(actuator.constant.value)}
    for channel, limit in limits.items():
        values = signals.get(channel)
        if values is None or np.mean(np.abs(values) > ratio * limit) < LEAST_SHARE:
            continue
        unit = si_unit(CHANNEL_DIMENSIONS[channel], bench.axis)
        low, high = float(np.min(values)), float(np.max(values))
        name = f"column {columns[channel]!r}" if channel in columns else f"channel {channel}"
        milli = max(-low, high) <= PER_MILLI * SUSPECT * limit
        advice = (
            f"if it is in m{unit}, write unit: m{unit} in columns.{channel}"
            if milli
            else f"correct columns.{channel} or actuator.limit"
        )
        return (
            f"{name} is {low:.4g} to {high:.4g} {unit}, but the drive's limit in bench.yaml is "
            f"{limit:.4g} {unit}; {advice}"
        )
    return None
