"""Whether the signs of effort and motion agree.

Friction takes energy: between two times at which the axis stands, the work of the effort, W = sum F dx, is what friction has taken, and
positive. With one sensor reversed it is negative. What a spring or a weight takes it gives back. Which sensor it is, the others tell:

    velocity against the differences of the position     negative: the velocity's sensor is reversed
    position against its reference                       negative: the position's sensor is; positive: the effort's
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from frictool.logs.log import Stream, Vector

CLEAR = 0.1  # share of the work to and fro that the net work has to be, to say anything
STANDS = 0.1  # of the top speed
LEAST_SPAN = 0.5  # of the log between the two stands
AGREES = 0.5  # least correlation of two signals of one motion
WINDOWS = 400  # differences of the position are taken over one part in so many of the log, and 64 samples at most


@dataclass(frozen=True)
class Sign:
    """work: net over absolute, -1 to 1; None where the log cannot tell. reversed: signals of the wrong sign, as far as it is known."""

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


def sign_of(stream: Stream) -> Sign:
    """What a stream tells of the signs of its signals."""
    signals = stream.signals
    position, velocity = signals.get("position"), signals.get("velocity")
    effort = next((name for name in ("effort", "current", "voltage") if name in signals), None)
    if position is None or position.size < 4 or np.ptp(position) == 0.0:
        return Sign(None)
    window = _window(position)
    wrong = []
    if velocity is not None and _correlation(velocity[window:] + velocity[:-window], position[window:] - position[:-window]) < -AGREES:
        wrong.append("velocity")
    work = None if effort is None else net_work(position, signals[effort])
    if effort is not None and work is not None and work <= -CLEAR:
        wrong.append(_culprit(effort, signals))
    return Sign(work, tuple(wrong))


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
    """Return the work of the effort between the first and the last stand over its absolute work, -1 to 1; both arguments (n,).

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


def _correlation(one: Vector, other: Vector) -> float:
    spread = float(np.std(one) * np.std(other))
    return float(np.mean((one - one.mean()) * (other - other.mean()))) / spread if spread > 0.0 else 0.0
