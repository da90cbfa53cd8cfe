"""What identification hands over: values with intervals, what was refused and why, and how well the
data are explained."""

from __future__ import annotations

from dataclasses import dataclass, field

from frictool.documents.laws import Laws
from frictool.errors import EXIT_NO, FrictoolError

SLIDING = (
    "inertia",
    "viscous",
    "coulomb",
    "offset",
)  # effort = inertia a + viscous v + coulomb sign(v) + offset
PARAMETERS = (*SLIDING, "breakaway")
CURVE = ("stribeck_velocity",)  # parameters of the law of sliding that not every method looks for
DIMENSIONS = {
    "inertia": "inertia",
    "viscous": "viscous",
    "coulomb": "effort",
    "offset": "effort",
    "breakaway": "effort",
}
DIMENSIONS |= {"stribeck_velocity": "velocity"}


class UnusableLogs(FrictoolError):
    """A log is in order and yet gives nothing: the message says why."""

    exit_code = EXIT_NO


@dataclass(frozen=True)
class Interval:
    """A value in SI and the interval that holds the truth at the stated confidence."""

    value: float
    low: float
    high: float

    @property
    def half_width(self) -> float:
        return 0.5 * (self.high - self.low)


@dataclass(frozen=True)
class SlidingFit:
    """The sliding parameters of one method.

    parameters: name -> interval. refused: name -> reason, with figures. residual,
    held_out_residual: rms of the residual over rms of the right-hand side in the method's own
    equations, on the fitted and on unseen strokes; two methods cannot be compared by them.
    force_error: that of `force_error.py`, by which methods can be compared; `identify` fills it in.
    details: figures of the method. laws: what the method found of friction beyond the parameters.
    method, why: which method it is and why, where it was chosen. dropped: parameters taken to be 0,
    since strokes that the fit did not see are predicted no worse without them. fixed: parameters
    that were held at the interval of the bench.
    """

    parameters: dict[str, Interval]
    refused: dict[str, str]
    residual: float
    held_out_residual: float | None
    condition: float
    samples: int
    details: dict[str, float | int] = field(default_factory=dict)
    laws: Laws | None = None
    method: str | None = None
    why: str | None = None
    dropped: tuple[str, ...] = ()
    fixed: dict[str, Interval] = field(default_factory=dict)
    force_error: float | None = None
