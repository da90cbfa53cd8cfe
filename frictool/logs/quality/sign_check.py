"""Check of the signs of effort and motion.

Friction dissipates energy. The work W = sum F dx of the effort F on the position x, between two
times of standstill, goes into friction and is positive. If the sign of one sensor is reversed, W is
negative. A spring or a weight returns its work when the axis moves back. Its contribution to W is
only the difference between its energies at the two standstills. Other signals show which sensor is
reversed:

    correlation of velocity and differences of position    negative: velocity is reversed
    correlation of position and its reference              negative: position is reversed;
                                                           positive: effort is reversed

On a slow axis with a coarse encoder, W may be negative although the signs are correct. The reason
is a controller's derivative term, which brakes in each sample with a new count. A sign therefore
counts as reversed only if the mean effort is also opposite to the motion. The mean is taken within
each stroke, from the first to the last change of the position.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np

from frictool.documents.bench import COUNT, Bench
from frictool.logs.log import Stream
from frictool.typing import Vector

CLEAR = 0.1  # least net work relative to the absolute work for a decision
BY_CHANCE = 3.0  # least net work, in standard deviations of the work of a white effort
STANDS = 0.1  # largest speed that is treated as standstill, relative to the log's largest speed
LEAST_SPAN = 0.5  # least share of the log between the first and the last standstill
LEAST_STROKE = 0.05  # least length of a stroke, relative to the position's range
SURE = 2.0  # number of standard errors by which the mean effort has to be negative
AGREES = 0.5  # least correlation of two signals that show the same motion
# differences of the position are taken over 1/WINDOWS of the log, at most 64 samples
WINDOWS = 400


@dataclass(frozen=True)
class SignCheck:
    """Result of the check of signs.

    work: net work of the effort divided by sum |F dx|, -1 to 1; None if `net_work` cannot
        determine it.
    reversed: names of the signals with a reversed sign. An element such as "position or effort"
        means that one of these two signals is reversed.
    """

    work: float | None
    reversed: tuple[str, ...] = ()

    def text(self, bench: Bench | None = None) -> str | None:
        """Return a warning about the reversed signal; None if no signal is reversed."""
        if not self.reversed:
            return None
        names = " or ".join(self.reversed)
        if self.work is not None and self.work <= -CLEAR:
            finding = (
                f"the effort takes energy from the axis (work {100 * self.work:.0f} % of "
                f"|F dx|): another force moves it, or {names} has the wrong sign"
            )
        else:
            finding = (
                "velocity and change of position have opposite signs: the sign of "
                f"{names} is reversed"
            )
        fixes = " and ".join(reversal(name, bench) for name in self.reversed)
        return f"{finding}; {fixes}"


def sign_of(stream: Stream) -> SignCheck:
    """Check the signs of a stream's effort, position and velocity."""
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
        wrong.append(reversed_signal(effort, position, signals.get("reference")))
    return SignCheck(work, tuple(wrong))


def reversed_signal(effort: str, position: Vector, reference: Vector | None) -> str:
    """Return which of `effort` and "position" is reversed if their signs contradict each other.

    effort: name of the effort or drive signal.
    position, reference: samples (n,).

    If the reference does not decide, the result names both, such as "position or current".
    """
    together = 0.0 if reference is None else _correlation(reference, position)
    if together > AGREES:
        return effort
    return "position" if together < -AGREES else f"position or {effort}"


def reversal(name: str, bench: Bench | None) -> str:
    """Return advice on reversing a signal in bench.yaml; name: element of `SignCheck.reversed`.

    If `name` is "position or ...", reversing either signal corrects the signs, and the advice is to
    reverse the position. There is one exception: the log has a reference and a position that is not
    in counts. The advice is then to reverse the drive, so that position and reference agree.
    """
    channel, *others = name.split(" or ")
    if bench is None:
        return f"reverse the sign of columns.{channel}.scale in the bench"
    columns = bench.columns
    counted = "position" in columns and columns["position"].unit == COUNT
    if others and "reference" in columns and not counted:
        channel = others[0]
    if channel == "effort" and channel not in columns:
        channel = bench.actuator.drive
    if channel not in columns:
        return f"reverse the sign of columns.{channel}.scale in the bench"
    if channel == "position" and counted:
        direction = bench.encoder.direction
        return f"set encoder.direction: {-direction} in the bench (found: {direction})"
    return f"set columns.{channel}.scale: {-columns[channel].scale:.12g} in the bench"


def _window(position: Vector) -> int:
    return max(1, min(64, position.size // WINDOWS))


def net_work(position: Vector, effort: Vector) -> float | None:
    """Return the net work sum F dx of the effort F divided by sum |F dx|, -1 to 1.

    position, effort: samples (n,).

    The work is computed from the first to the last standstill. The result is None if this interval
    is too short compared with the log, if the axis does not move, or if noise could cause this
    work.
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
    # noise alone gives a work of about the root of the sum of squares
    if total == 0.0 or abs(float(done.sum())) < BY_CHANCE * float(np.linalg.norm(done)):
        return None
    return float(done.sum()) / total


def _brakes(position: Vector, effort: Vector) -> bool:
    """Return True if the effort in the direction of motion is clearly negative.

    The effort is the mean over all strokes, weighted by the lengths of the strokes.
    """
    window = _window(position)
    speed = np.sign(position[window:] - position[:-window])
    moving = np.flatnonzero(speed)
    turns = moving[1:][np.diff(speed[moving]) != 0.0]
    least = LEAST_STROKE * float(np.ptp(position))
    direction = list[float]()
    mean = list[float]()
    length = list[float]()
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
        # remove the offset of the effort
        efforts = efforts - 0.5 * (
            np.median(efforts[signs > 0.0]) + np.median(efforts[signs < 0.0])
        )
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
