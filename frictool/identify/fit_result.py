"""Result of an identification method: values with intervals, refusals, and quality of the fit."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field

from frictool.documents.laws import Laws
from frictool.documents.load_terms import LoadTerms
from frictool.documents.quantity import Axis, Estimate, Quantity, si_unit
from frictool.errors import EXIT_NO, FrictoolError

# effort = inertia a + viscous v + coulomb sign(v) + offset
SLIDING = ("inertia", "viscous", "coulomb", "offset")
PARAMETERS = (*SLIDING, "breakaway")
CURVE = ("stribeck_velocity",)  # parameters of sliding friction that only some methods estimate
DIMENSIONS = {
    "inertia": "inertia",
    "viscous": "viscous",
    "coulomb": "effort",
    "offset": "effort",
    "breakaway": "effort",
}
DIMENSIONS |= {"stribeck_velocity": "velocity"}


class UnusableLogs(FrictoolError):
    """Error: the logs are valid, but do not determine the requested parameters."""

    exit_code = EXIT_NO


@dataclass(frozen=True)
class Interval:
    """Estimate in SI units and its confidence interval [low, high]."""

    value: float
    low: float
    high: float

    @classmethod
    def around(cls, value: float, half: float, least: float = -math.inf) -> Interval:
        """Return the interval `value` +- `half`; the lower end is at least `least`."""
        return cls(float(value), float(max(value - half, least)), float(value + half))

    def estimate(self, dimension: str, axis: Axis, least: float = -math.inf) -> Estimate:
        """Return the interval with its unit for a document; the lower end is at least `least`."""
        unit = si_unit(dimension, axis)
        return Estimate(self.value, max(self.low, least), self.high, unit, source="identified")

    @property
    def half_width(self) -> float:
        """Return half of the interval's width."""
        return 0.5 * (self.high - self.low)


def intervals_around(
    names: Iterable[str], values: Iterable[float], half: Iterable[float]
) -> dict[str, Interval]:
    """Return the interval value +- half for each name, and ignore values beyond the last name."""
    return {
        name: Interval.around(value, reach)
        for name, value, reach in zip(names, values, half, strict=False)
    }


@dataclass(frozen=True)
class TriedModel:
    """Model that was compared with other models.

    - position_error: rms position error, rad | m
    - force_error: relative force error, defined in `force_error.py`
    - chosen: True for the model that was chosen
    - leaves_range: True if the simulation leaves the range of the measured positions by far

    If the logs are long enough, the errors are computed from strokes that the fit did not use.
    """

    name: str
    position_error: float
    force_error: float
    chosen: bool
    leaves_range: bool = False


@dataclass(frozen=True)
class Explanation:
    """Part of the effort that inertia, viscous and Coulomb friction and offset do not explain.

    - name: name of the part in `load.terms` of bench.yaml
    - what: physical name for messages
    - state: `used` if the fit includes this part of the effort, `left` if the part remains in the
      residual
    - effort: rms effort of this part, N m | N
    - probability: p-value of the test that this part of the effort is 0
    - held_out: prediction error of the effort in strokes left out of the fit, divided by the error
      of a fit without this part
    - settle: advice on a change of bench.yaml or a test that would show whether this part exists
    - rivals: physical names of other explanations that predict the strokes equally well
    """

    name: str
    what: str
    state: str
    effort: float
    probability: float
    held_out: float
    settle: str
    rivals: tuple[str, ...] = ()


@dataclass(frozen=True)
class SlidingFit:
    """Sliding parameters that one method estimated.

    - parameters: interval of each identified parameter
    - refused: for each parameter that was not accepted, the reason with numbers
    - residual: rms residual of the method's equations divided by the rms of their right-hand side,
      over the strokes of the fit; not comparable between methods
    - held_out_residual: the same ratio over strokes left out of the fit; None if this ratio was not
      computed
    - condition: condition number of the regressor matrix
    - samples: number of equations (rows) or of samples in the fit
    - details: numbers that are specific to the method
    - laws: laws of friction and load in addition to the sliding parameters, or None
    - effects: interval of each parameter of the effects, such as a delay, that were removed from
      the effort (`rows/effects.py`)
    - load: load terms of the fit if `auto` selected them, else None
    - explanations: further parts of the effort, such as a spring, that `auto` fitted or left in the
      residual
    - method: name of the method that gave the fit
    - why: reason why `auto` chose this method
    - dropped: parameters that were set to 0, since the value 0 does not worsen the prediction of
      strokes left out of the fit, or since the log does not determine the parameters
      (`rows/position_orders.py`)
    - fixed: interval of each parameter that was fixed in the fit; it lies within the interval in
      bench.yaml
    - force_error: relative force error, defined in `force_error.py` and comparable between methods;
      None if the axis never slips
    - tried: models that the method compared before it chose one
    - constants: identified constants of a servo
    - load_zero: position at which the load columns are 0, so that the offset is the total load
      there, rad | m (`total_load.py`); None if the columns are not shifted
    - attenuation: relative decrease of the fitted inertia by white noise of the position; 0 if the
      decrease is negligible, or if the method corrects it
    """

    parameters: dict[str, Interval]
    refused: dict[str, str]
    residual: float
    held_out_residual: float | None
    condition: float
    samples: int
    details: dict[str, float | int] = field(default_factory=dict)
    laws: Laws | None = None
    effects: dict[str, Interval] = field(default_factory=dict)
    load: LoadTerms | None = None
    explanations: tuple[Explanation, ...] = ()
    method: str | None = None
    why: str | None = None
    dropped: tuple[str, ...] = ()
    fixed: dict[str, Interval] = field(default_factory=dict)
    force_error: float | None = None
    tried: tuple[TriedModel, ...] = ()
    constants: dict[str, Quantity] = field(default_factory=dict)
    load_zero: float | None = None
    attenuation: float = 0.0
