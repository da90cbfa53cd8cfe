"""Function `NAME_unwrap` of the exported C, which removes the wraps of the encoder's readings.

    turns[k] = turns[k-1] - round((reading[k] - reading[k-1])/period)
    position[k] = reading[k] + turns[k] period

A wrapping encoder shows the position modulo a period. The controller needs the position without
wraps: without this correction, a wrap would make the controller turn the axis back by a whole
period. The first reading counts as the position if it is within the travel of the bench. Otherwise,
`turns[0]` is the number of periods that brings the position nearest to the middle of the travel.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from frictool.control.fixed_point import FixedProgram
from frictool.control.fixed_point_kernel import shift_rounded
from frictool.documents.controller import Controller
from frictool.documents.quantity import si_unit
from frictool.export.c_fixed_point import FixedNumbers, moved
from frictool.export.c_identifier import c_identifier
from frictool.export.c_statements import NumberWriter
from frictool.export.fixed_point_header import multiplier

FLOAT_COUNTS = 2.0**24  # number of counts up to which a float represents every integer
# readings of the self-test: first reading and distance [periods], number up and number down
FIRST, APART, UP, DOWN = 0.1, 0.3, 8, 16


@dataclass(frozen=True)
class EncoderWrap:
    """Wraps of a bench's encoder.

    - period: change of the position after which the reading repeats [rad | m]
    - step: position per count [rad | m]; negative if the counts decrease during forward motion
    - travel: lowest and highest position of the axis [rad | m]; None if the bench has no travel
    - fastest: speed of half a period per sample, above which the number of turns is lost
    - held: longest interval [samples] between valid readings without a fault
    - top_speed: largest speed of the axis; None if the bench does not state it
    - units: units of the position and of the speed
    """

    period: float
    step: float
    travel: tuple[float, float] | None
    fastest: float
    held: int
    top_speed: float | None
    units: tuple[str, str]

    @property
    def warning(self) -> str:
        """Return a warning if the axis can be too fast for its encoder, else an empty text."""
        for samples in (1, self.held):
            if self.top_speed is not None and self.top_speed >= self.fastest / samples:
                span = "per sample" if samples == 1 else f"during {samples - 1} invalid readings"
                return (
                    f"top_speed {self.top_speed:.4g} {self.units[1]} is at least half a period of "
                    f"the encoder {span}, so that wraps may be miscounted; allowed: below "
                    f"{self.fastest / samples:.4g} {self.units[1]}"
                )
        return ""

    @property
    def requirement(self) -> str:
        """Return the sentence that position and reference must be without wraps."""
        return (
            f"the encoder wraps after {self.period:.6g} {self.units[0]}: position and reference "
            "must be without wraps"
        )

    def readings(self) -> list[int]:
        """Return counts that the encoder shows, over several periods in both directions."""
        counts = self.period / abs(self.step)
        apart = max(math.floor(APART * counts), 1)
        moves = [0, *[apart] * UP, *[-apart] * DOWN]
        return [math.floor((FIRST * counts + move) % counts) for move in np.cumsum(moves).tolist()]


def encoder_wrap(controller: Controller) -> EncoderWrap | None:
    """Return the wraps of the encoder in a controller's bench; None if it never wraps."""
    bench = controller.bench
    period, travel = bench.encoder.period, bench.mechanics.travel
    if period is None:
        return None
    top = bench.mechanics.top_speed
    return EncoderWrap(
        period,
        bench.encoder.position_per_count,
        None if travel is None else (travel.low, travel.high),
        0.5 * period / controller.sample_period_s,
        controller.measurement_hold_samples + 1,
        None if top is None else top.value,
        (si_unit("position", controller.axis), si_unit("velocity", controller.axis)),
    )


def wrap_context(
    controller: Controller, numbers: NumberWriter, position: int
) -> dict[str, Any] | None:
    """Return the values for the C templates of NAME_unwrap; None if the encoder never wraps.

    `position`: index of the program's node of the position.
    """
    wrap = encoder_wrap(controller)
    if wrap is None:
        return None
    context = (
        _words(wrap, numbers.scaled, position)
        if isinstance(numbers, FixedNumbers)
        else _reals(wrap, numbers)
    )
    travel = wrap.travel
    reach = math.inf if travel is None else max(map(abs, travel))
    lossless = FLOAT_COUNTS * abs(wrap.step)
    macro = f"{c_identifier(controller.name).upper()}_ENCODER_PERIOD"
    return context | {
        "macro": macro,
        "fastest": f"{wrap.fastest:.4g}",
        "fastest_held": f"{wrap.fastest / wrap.held:.4g}",
        "invalid": wrap.held - 1,
        "warning": wrap.warning,
        "travel": None if travel is None else f"{travel[0]:.4g} to {travel[1]:.4g}",
        "lossless": f"{lossless:.4g}" if numbers.kind == "float" and reach > lossless else "",
    }


def _reals(wrap: EncoderWrap, numbers: NumberWriter) -> dict[str, Any]:
    kind = np.float32 if numbers.kind == "float" else np.float64
    period = kind(wrap.period)
    readings = [kind(count * wrap.step) for count in wrap.readings()]
    low, middle, high = _span(wrap)
    away = (kind(middle) - readings[0]) / period
    inside = kind(low) <= readings[0] <= kind(high)
    turns = 0 if inside else int(away + np.copysign(kind(0.5), away))
    rows = []
    for reading, before in zip(readings, [readings[0], *readings], strict=False):
        turns -= int(reading - before > kind(0.5) * period)
        turns += int(before - reading > kind(0.5) * period)
        rows.append((reading, reading + kind(turns) * period))
    return {
        "reading_kind": numbers.kind,
        "period": numbers.literal(wrap.period),
        "shown": "reading",
        "turned": "",
        "half": numbers.literal(0.5 * wrap.period),
        "reverse": False,  # the reading in rad or m grows during forward motion
        "rounding": numbers.literal(0.5),
        "span": [numbers.literal(value) for value in (low, middle, high)] if wrap.travel else [],
        "rows": [[f"{float(value).hex()}{numbers.suffix}" for value in row] for row in rows],
    }


def _words(wrap: EncoderWrap, scaled: FixedProgram, position: int) -> dict[str, Any]:
    fraction = scaled.fractions[position]
    least, most = scaled.words[position]
    count, period = multiplier(wrap.step, fraction), multiplier(wrap.period, fraction)
    low, middle, high = (
        round(math.ldexp(value, fraction)) if wrap.travel else 0 for value in _span(wrap)
    )
    half = math.floor(0.5 * wrap.period / abs(wrap.step))
    side = 1 if wrap.step > 0.0 else -1
    turn = shift_rounded(*period)
    readings = wrap.readings()
    first = shift_rounded(readings[0] * count[0], count[1])
    turns = 0
    if wrap.travel and not low <= first <= high:
        turns = (2 * abs(middle - first) + turn) // (2 * turn)
        turns = turns if middle >= first else -turns
    rows = []
    for reading, before in zip(readings, [readings[0], *readings], strict=False):
        turns += side * (int(before - reading > half) - int(reading - before > half))
        word = shift_rounded(reading * count[0], count[1])
        word += shift_rounded(turns * period[0], period[1])
        rows.append((reading, min(max(word, least), most)))
    return {
        "reading_kind": "int64_t",
        "period": repr(wrap.period),
        "half": half,
        "reverse": side < 0,
        "span": [low, middle, high] if wrap.travel else [],
        "turn": turn,
        "least": least,
        "most": most,
        "shown": moved(f"reading * {count[0]}", count[1]),
        "turned": moved(f"(int64_t)encoder->turns * {period[0]}", period[1]),
        "rows": [[str(value) for value in row] for row in rows],
    }


def _span(wrap: EncoderWrap) -> tuple[float, float, float]:
    """Return the lowest position of the travel, its middle, and the highest position."""
    low, high = wrap.travel or (-math.inf, math.inf)
    return low, 0.5 * (low + high) if wrap.travel else 0.0, high
