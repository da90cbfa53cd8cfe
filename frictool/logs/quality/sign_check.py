"""Judgement of the signs of effort and motion.

Friction takes energy: between two times at which the axis stands, the work of the effort, W = sum F
dx, is what friction has taken, and positive. With one sensor reversed it is negative. A spring or a
weight gives its work back. The other signals tell which sensor it is:

    velocity against the differences of the position     negative: the velocity's sensor is reversed
    position against its reference                       negative: the position's sensor is;
                                                         positive: the effort's

On a slow axis with a coarse encoder the sum misleads: a controller's derivative brakes at each
count, in the sample in which the count shows. The sign counts as reversed only if the mean effort
from the first to the last count of the strokes is negative as well.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np

from frictool.logs.log import Stream, Vector

CLEAR = 0.1  # share of the work to and fro that the net work has to be, to say anything
STANDS = 0.1  # of the top speed
LEAST_SPAN = 0.5  # of the log between the two stands
LEAST_STROKE = 0.05  # of the position's range
SURE = 2.0  # standard errors
AGREES = 0.5  # least correlation of two signals of one motion
# differences of the position are taken over one part in so many of the log, and 64 samples at most
WINDOWS = 400


@dataclass(frozen=True)
class SignCheck:
    """work: net over absolute, -1 to 1; None where the log cannot tell. reversed: signals of the
    wrong sign, as far as it is known."""

    work: float | None
    reversed: tuple[str, ...] = ()

    @property
    def text(self) -> str | None:
        """One line where something is reversed."""
        if not self.reversed:
            return None
        names = " or ".join(self.reversed)
        if self.work is not None and self.work <= -CLEAR:
            found = f"the effort takes energy from the axis ({100 * self.work:.0f} % of the work), which friction cannot give"
        else:
            found = "the velocity runs against the position"
        fix = "encoder.direction, or a scale of -1 in columns"
        return f"{found}: the sign of {names} is reversed; see {fix}"


def sign_of(stream: Stream) -> SignCheck:
    """What a stream tells of the signs of its signals."""
    signals = stream.signals
    position, velocity = signals.get("position"), signals.get("velocity")
    effort = next((name for name in ("effort", "current", "voltage") if name in signals), None)
    if position is None or position.size < 4 or np.ptp(position) == 0.0:
        return SignCheck(None)
    window = _window(position)
    wrong = []
    if (
        velocity is not None
        and _correlation(
            velocity[window:] + velocity[:-window], position[window:] - position[:-window]
        )
        < -AGREES
    ):
        wrong.append("velocity")
    work = None if effort is None else net_work(position, signals[effort])
    if (
        effort is not None
        and work is not None
        and work <= -CLEAR
        and _brakes(position, signals[effort])
    ):
        wrong.append(_culprit(effort, signals))
    return SignCheck(work, tuple(wrong))


def _culprit(effort: str, signals: dict[str, Vector]) -> str:
    """Of position and effort the one that is reversed, where the reference tells."""
    reference = signals.get("reference")
    together = 0.0 if reference is None else _correlation(reference, signals["position"])
    if together > AGREES:
        return effort
    return "position" if together < -AGREES else f"position or {effort}"


def _window(position: Vector) -> int:
    """Return the number of samples over which differences of a position (n,) are taken."""
    return max(1, min(64, position.size // WINDOWS))


def net_work(position: Vector, effort: Vector) -> float | None:
    """Return the work of the effort between the first and the last stand over its absolute work, -1
    to 1; both arguments (n,).

    None if the stands span too little of the log, or nothing moves.
    """
    window = _window(position)
    speed = np.abs(position[window:] - position[:-window])
    stands = np.flatnonzero(speed <= STANDS * speed.max()) + window // 2
    if stands.size < 2 or stands[-1] - stands[0] < LEAST_SPAN * position.size:
        return None
    between = slice(int(stands[0]), int(stands[-1]) + 1)
    force = effort[between]
    done = 0.5 * (force[1:] + force[:-1]) * np.diff(position[between])
    total = float(np.abs(done).sum())
    return float(done.sum()) / total if total > 0.0 else None


def _brakes(position: Vector, effort: Vector) -> bool:
    """Return whether the mean effort along the strokes of a position (n,), weighted by length, is
    negative beyond its uncertainty."""
    window = _window(position)
    speed = np.sign(position[window:] - position[:-window])
    moving = np.flatnonzero(speed)
    turns = moving[1:][np.diff(speed[moving]) != 0.0]
    least, direction, mean, length = (
        LEAST_STROKE * float(np.ptp(position)),
        list[float](),
        list[float](),
        list[float](),
    )
    for first, end in itertools.pairwise([0, *(turns + window // 2).tolist(), position.size]):
        changes = first + np.flatnonzero(np.diff(position[first:end]))
        if changes.size < 2:
            continue
        advance = float(position[changes[-1] + 1] - position[changes[0]])
        if abs(advance) >= least:
            direction.append(math.copysign(1.0, advance))
            mean.append(float(np.mean(effort[changes[0] + 1 : changes[-1] + 1])))
            length.append(abs(advance))
    signs, efforts, weights = np.array(direction), np.array(mean), np.array(length)
    if not signs.size:
        return False
    if (signs > 0.0).any() and (signs < 0.0).any():
        efforts = efforts - 0.5 * (
            np.median(efforts[signs > 0.0]) + np.median(efforts[signs < 0.0])
        )  # the offset
    along = signs * efforts
    average = float(np.average(along, weights=weights))
    spread = math.sqrt(float(np.average((along - average) ** 2, weights=weights)) / signs.size)
    return average + SURE * spread < 0.0


def _correlation(one: Vector, other: Vector) -> float:
    spread = float(np.std(one) * np.std(other))
    return (
        float(np.mean((one - one.mean()) * (other - other.mean()))) / spread
        if spread > 0.0
        else 0.0
    )
