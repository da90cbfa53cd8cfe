"""Second-order sections as direct form I biquads of CMSIS-DSP.

The functions are arm_biquad_cascade_df1_f32, _q31 and _q15:

    f32    y = b0 x + b1 x1 + b2 x2 + a1 y1 + a2 y2; a1 and a2 have the opposite sign
           of H = (b0 + ..)/(1 + a1/z + a2/z^2)
    q31    acc = the same sum in the format 2.62 (2 integer bits, 62 fraction bits),
           y = acc >> (31 - postShift); acc must stay within +-2 and y within +-1, because an
           overflow of acc or y changes the sign
    q15    acc = the same sum in the format 34.30, y = acc >> (15 - postShift); y saturates

In fixed point each coefficient is multiplied by 2^-postShift before it is stored. The signals are
scaled with the sum of the absolute impulse response. Input and output of each stage therefore stay
within a quarter of the range: no stage overflows for any input. `input_scale` and `output_scale`
are the input and the output at full range. Shifts round down, which adds a bias of at most one
count per stage. The bias passes through 1/A of the stage, with A = 1 + a1/z + a2/z^2, and through
the stages behind it; `noise` is the bound of the amplified bias.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from frictool.control.coefficient_words import BITS
from frictool.control.difference_equation import impulse_sums
from frictool.control.second_order_sections import chain_state_space
from frictool.documents.controller import Number
from frictool.errors import NoSolutionError

# largest signal of a stage, relative to the range: two guard bits, as CMSIS-DSP requires
REACH = 0.25
Row = tuple[float, ...]


@dataclass(frozen=True)
class Biquads:
    """Biquad stages, with the scales of input and output.

    `stages`: b0 b1 b2 a1 a2 of each stage in the convention of CMSIS; integers in fixed point.
    `post_shift`: exponent that all stages share; each coefficient is stored multiplied by
        2^-post_shift.
    `input_scale`, `output_scale`: input and output at full range, in their units; 1 in float.
    `noise`: bound of the output's error due to rounding of the signals; NaN in float.
    """

    stages: tuple[tuple[float, ...] | tuple[int, ...], ...]
    post_shift: int
    input_scale: float
    output_scale: float
    noise: float

    def sections(self, number: Number) -> tuple[Row, ...]:
        """Return (b0, b1, b2, a0, a1, a2) of each rounded stage.

        The stages in series have input and output in their units, not as fractions of full range.
        """
        unit = 1.0 if number == "float" else math.ldexp(1.0, self.post_shift - BITS[number])
        rows = [[unit * value for value in stage] for stage in self.stages]
        rows[-1][:3] = [value * self.output_scale / self.input_scale for value in rows[-1][:3]]
        return tuple((b0, b1, b2, 1.0, -a1, -a2) for b0, b1, b2, a1, a2 in rows)


def float_biquads(sections: tuple[Row, ...]) -> Biquads:
    """Return unscaled biquad stages in float, with the signs of a1 and a2 changed."""
    stages = tuple(
        tuple(float(np.float32(value)) for value in (b0, b1, b2, -a1, -a2))
        for b0, b1, b2, _, a1, a2 in sections
    )
    return Biquads(stages, 0, 1.0, 1.0, math.nan)


def fixed_biquads(name: str, sections: tuple[Row, ...], number: Number, entering: float) -> Biquads:
    """Return biquad stages in fixed point, scaled for |input| <= entering.

    Raises NoSolutionError if a section is unstable, or if the rounded stages might overflow.
    """
    bits = BITS[number]
    reach = [entering, *(entering * response_sum(sections[: k + 1]) for k in range(len(sections)))]
    if not all(math.isfinite(one) for one in reach):
        raise NoSolutionError(
            f"{name}: a section has a pole on or outside the unit circle, and may overflow in "
            f"{number}; use --number float, or --lang c, which saturates"
        )
    scales = [one / REACH if one > 0.0 else 1.0 for one in reach]
    scaled = [
        (*(value * before / after for value in (b0, b1, b2)), -a1, -a2)
        for (b0, b1, b2, _, a1, a2), before, after in zip(
            sections, scales[:-1], scales[1:], strict=True
        )
    ]
    largest = max(abs(value) for row in scaled for value in row)
    shift = max(math.frexp(largest)[1], 0)
    if round(math.ldexp(largest, bits - shift)) >= 2**bits:
        shift += 1
    stages = tuple(tuple(round(math.ldexp(value, bits - shift)) for value in row) for row in scaled)
    made = Biquads(stages, shift, scales[0], scales[-1], 0.0)
    noise = _noise(name, made, number)
    return Biquads(stages, shift, scales[0], scales[-1], noise * scales[-1])


def response_sum(sections: tuple[Row, ...]) -> float:
    """Return the sum of the absolute impulse response of a chain of sections; inf if unstable.

    The sum is the largest output for inputs within +-1.
    """
    a, b, c, d = chain_state_space(sections)
    n = len(b)
    whole = np.zeros((n + 1, n + 1))  # the output becomes one more state
    whole[:n, :n], whole[n, :n] = a, c
    return float(impulse_sums(whole, np.append(b, d))[n])


def _noise(name: str, made: Biquads, number: Number) -> float:
    """Return the bound of the rounding error at the output, relative to the output's full range.

    Raises NoSolutionError if a stage might overflow or saturate.
    """
    bits = BITS[number]
    unit = math.ldexp(1.0, made.post_shift - bits)
    count = math.ldexp(1.0, -bits)
    rows = [[unit * value for value in stage] for stage in made.stages]
    chain = [(b0, b1, b2, 1.0, -a1, -a2) for b0, b1, b2, a1, a2 in rows]
    # the input is rounded to the nearest count
    noise = 0.5 * count
    entered = REACH
    for k, (b0, b1, b2, a1, a2) in enumerate(rows):
        noise = (
            response_sum((tuple(chain[k]),)) * noise
            + response_sum(((1.0, 0.0, 0.0, 1.0, -a1, -a2),)) * count
        )
        left = REACH * response_sum(tuple(chain[: k + 1])) + noise
        total = (abs(b0) + abs(b1) + abs(b2)) * entered + (abs(a1) + abs(a2)) * left
        if not (left < 1.0 and (number == "q15" or math.ldexp(total, -made.post_shift) < 2.0)):
            raise NoSolutionError(
                f"{name}: section {k} may overflow in {number}: with rounding errors, its output "
                f"can reach {left:.3g} times the range of the numbers; use "
                f"{'--number q31' if number == 'q15' else '--number float'}, or --lang c"
            )
        entered = left
    return noise
