"""Comparison of two switched observers and the estimator of `observe run` (6.3.2, second test).

    python -m studies.observers.estimator_comparison [SEEDS]

`make -C configs/clutch observers` runs this command. Each run is 20 s of steps on the clutch of
nonlinear.yaml (encoder with 56 counts per turn, backlash, 0.5 A of noise). Noise and start position
within a count are random. The inertia of the estimators' model is 20 % below the clutch's. The
switched observers are designed as in the Makefile, with a decay only and with quiet gains.

wear       friction relative to the model's. For a multiplicative observer: mean alpha over the last
           5 s. For an additive observer: (f + alpha)/f over the last 5 s, by least squares in slip.
           For the estimator of `observe run`: its last value
bias, sd   mean error and standard deviation of the wear over the runs
velocity   rms error over all samples
friction   relative rms error from 5 s on, as in switched_observers.py; the friction of the
           estimator is its wear times the model's map
"""

from __future__ import annotations

import functools
import sys
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from frictool.documents.observer import Observer
from frictool.documents.provenance import Provenance
from frictool.observe.design import additive, multiplicative
from frictool.observe.design.friction_map import friction_at, friction_map
from frictool.observe.design.switched_settings import SwitchedObserverSettings
from frictool.observe.motion_block import MotionBlock
from frictool.observe.observer_run import ObserverOutput, run_along
from frictool.observe.velocity import VelocityEstimator
from frictool.observe.wear.wear_estimator import WearEstimator
from frictool.typing import IntVector, Vector
from studies.rigs.clutch_fleet import Loop, Run, Unit, believed, clutch, run, steps

Found = tuple[float, float, float]  # wear, error of the velocity [rad/s], of the friction [%]
SEEDS, WEARS = 20, (1.0, 1.2, 1.5)
LOOPS: tuple[Loop, ...] = ("speed", "linear")
SIGMA = 100.0  # rad/s
SETTLED, LAST = 5.0, 5.0  # s from the beginning, and before the end
PHASE_STREAM = 105  # second seed of the random start phase
PROVENANCE = Provenance("written by a test", "0")


@dataclass(frozen=True)
class Row:
    """Results of one estimator in one loop at one wear, over all runs.

    bias, deviation: mean error and standard deviation of the wear [%]. velocity [rad/s], friction
    [%]: mean errors.
    """

    name: str
    loop: str
    wear: float
    bias: float
    deviation: float
    velocity: float
    friction: float


@functools.cache
def designed(kind: str) -> Observer:
    """Return the observer of a kind, designed as in configs/clutch/Makefile for the second test."""
    if kind.startswith("multiplicative"):
        quiet = 4.0 if kind == "multiplicative" else None
        return multiplicative.design(
            believed(),
            SwitchedObserverSettings(intervals=20, switch_speed=SIGMA, quiet=quiet),
            PROVENANCE,
        )
    settings = (
        SwitchedObserverSettings(switch_speed=SIGMA, quiet=4.0, decay=0.94)
        if kind == "additive"
        else SwitchedObserverSettings(switch_speed=SIGMA)
    )
    return additive.design(believed(), settings, PROVENANCE)


def truth(log: Run, piece: MotionBlock) -> Vector:
    """Return the true dry friction (n,) [N m], with the sign of the velocity."""
    return _of_map(piece, log.velocity, np.full(piece.time.size, log.unit.wear))


def _of_map(piece: MotionBlock, velocity: Vector, wear: Vector) -> Vector:
    sides = [
        friction_at(friction_map(clutch()), direction, piece.position) for direction in (1, -1)
    ]
    return np.asarray(wear * np.sign(velocity) * np.where(velocity > 0.0, *sides))


def by_observer(kind: str, log: Run) -> Found:
    """Return the errors of a switched observer along a log."""
    piece = log.pieces[0]
    found = next(run_along(designed(kind), log.pieces))
    return _judged(log, piece, found, _alpha if designed(kind).kind == "multiplicative" else _ratio)


def by_estimator(log: Run) -> Found:
    """Return the errors of the wear estimator that `observe run` uses."""
    piece = log.pieces[0]
    wear, velocity = WearEstimator(believed()), VelocityEstimator(believed()).take(piece)[0]
    known = np.full(piece.time.size, wear.estimate.wear.value)
    for estimate in [*wear.take(piece), *wear.finish()]:
        known[piece.time > estimate.time] = estimate.wear.value
    friction = _of_map(piece, velocity, known)
    last = wear.estimate.wear.value
    return _judged(
        log,
        piece,
        ObserverOutput(piece.time, piece.position, velocity, friction, known),
        lambda *_: last,
    )


def _judged(
    log: Run,
    piece: MotionBlock,
    found: ObserverOutput,
    wear: Callable[[ObserverOutput, Vector, IntVector], float],
) -> Found:
    true = truth(log, piece)
    both = (
        (np.abs(log.velocity) >= SIGMA)
        & (np.abs(found.velocity) >= SIGMA)
        & (piece.time >= SETTLED)
    )
    last = both & (piece.time >= piece.time[-1] - LAST)
    friction = 100.0 * _rms((found.friction - true)[both]) / _rms(true[both])
    return (
        wear(found, true / log.unit.wear, np.flatnonzero(last)),
        _rms(found.velocity - log.velocity),
        friction,
    )


def _alpha(found: ObserverOutput, of: Vector, last: IntVector) -> float:
    assert found.wear is not None
    return float(np.mean(found.wear[found.time >= found.time[-1] - LAST]))


def _ratio(found: ObserverOutput, of: Vector, last: IntVector) -> float:
    return float(np.sum(found.friction[last] * of[last]) / np.sum(of[last] ** 2))


def _rms(values: Vector) -> float:
    return float(np.sqrt(np.mean(values**2)))


ESTIMATORS: dict[str, Callable[[Run], Found]] = {
    **{
        name: functools.partial(by_observer, name)
        for name in ("multiplicative_decay", "multiplicative", "additive_decay", "additive")
    },
    "observe run": by_estimator,
}


def compared(loop: Loop, wear: float, seeds: int) -> list[Row]:
    """Return the rows of all estimators in a loop at a wear."""
    found: dict[str, list[Found]] = {name: [] for name in ESTIMATORS}
    for seed in range(seeds):
        phase = (
            float(np.random.Generator(np.random.PCG64([seed, PHASE_STREAM])).random())
            * clutch().bench.encoder.resolution
        )
        log = run(Unit(wear=wear), steps() + phase, seed, loop)
        for name, estimate in ESTIMATORS.items():
            found[name].append(estimate(log))
    return [_row(name, loop, wear, np.array(each)) for name, each in found.items()]


def _row(name: str, loop: str, wear: float, found: NDArray[np.float64]) -> Row:
    error = 100.0 * (found[:, 0] / wear - 1.0)
    return Row(
        name,
        loop,
        wear,
        float(np.mean(error)),
        float(np.std(error)),
        float(np.mean(found[:, 1])),
        float(np.mean(found[:, 2])),
    )


def table(rows: list[Row]) -> list[str]:
    """Return the rows as lines of text."""
    heads = (
        f"{'loop':<8}{'wear':>5}  "
        f"{'estimator':<22}{'bias %':>8}{'sd %':>8}{'velocity rad/s':>16}{'friction %':>12}"
    )
    return [
        heads,
        *(
            f"{one.loop:<8}{one.wear:>5.1f}  "
            f"{one.name:<22}{one.bias:>+8.2f}{one.deviation:>8.2f}{one.velocity:>16.1f}"
            f"{one.friction:>12.1f}"
            for one in rows
        ),
    ]


def main(arguments: list[str]) -> int:
    if len(arguments) > 1 or not all(word.isdigit() and int(word) > 0 for word in arguments):
        print(__doc__, file=sys.stderr)
        return 2
    seeds = int(arguments[0]) if arguments else SEEDS
    rows = [row for loop in LOOPS for wear in WEARS for row in compared(loop, wear, seeds)]
    print(f"second test, {seeds} runs each\n" + "\n".join(table(rows)))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
