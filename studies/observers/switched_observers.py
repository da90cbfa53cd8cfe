"""Errors of switched observers in the tests of thesis 6.3.2 and 6.4.2, on simulated logs.

    python -m studies.observers.switched_observers BUILD

The command reads BUILD/first and BUILD/second (make -C configs/clutch observers).

first    friction is multiplied by 1.5 at 5 s. settled: time after this step from which the wear
         alpha stays within 5 % (for an additive observer, the friction over a period of the sine).
         The other values are over the last 5 s.
second   range of alpha from 2 s on, and mean of alpha in the second half of each of the two series
         of steps

The friction error is the rms error over samples in which axis and observer both slip, divided by
the rms true friction. The true friction is the model's map at the true position, times its wear.
The velocity error is the rms error over all samples.
"""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from frictool.documents.model import Model
from frictool.documents.observer import Observer
from frictool.documents.registry import load
from frictool.logs.log import Log, Stream
from frictool.logs.log_reader import read_log
from frictool.observe.design.friction_map import friction_at, friction_map
from frictool.observe.observer_run import ObserverOutput
from frictool.observe.second_observer import TOPIC
from frictool.typing import BoolVector, Vector
from studies.clutch.rig import CLUTCH

DESIGNS = {
    "multiplicative_printed": ("--kind", "multiplicative", "--decay", 1),
    "multiplicative_decay": ("--kind", "multiplicative", "--intervals", 20),
    "multiplicative": ("--kind", "multiplicative", "--intervals", 20, "--quiet", 4),
    "additive_printed": ("--kind", "additive", "--decay", 1),
    "additive_decay": ("--kind", "additive"),
    "additive": ("--kind", "additive", "--decay", 0.94, "--quiet", 4),
}
PLANTS = {"first": CLUTCH / "observers/perfect.yaml", "second": CLUTCH / "nonlinear.yaml"}
OPTIONS = {
    "first": ("--switch-speed", "10rad/s"),
    "second": ("--switch-speed", "100rad/s", "--inertia", 1.056e-5),
}
# onset of the wear [s]; friction from then on, divided by the model's; allowed relative error
ONSET, WORN, WITHIN = 5.0, 1.5, 0.05
PERIOD = 0.5  # s, of the sine
SETTLED_AFTER = 2.0  # s, time in the second test from which on alpha is evaluated
HEADS = {
    "first": ("settled s", "alpha before", "alpha after", "friction %", "within 5 %", "velocity"),
    "second": ("alpha low", "alpha high", "series 1", "series 2", "friction %", "velocity"),
}


@dataclass(frozen=True)
class Truth:
    """True values (n,) of a simulated log: time [s], velocity [rad/s] and dry friction [N m].

    The friction has the sign of the velocity.
    """

    time: Vector
    velocity: Vector
    friction: Vector


@dataclass(frozen=True)
class First:
    """Results of the first test.

    - settled: settling time of alpha [s]; infinite if alpha does not settle
    - before, after: mean alpha before the step and over the last 5 s [1 | N m]
    - friction: error [%]
    - within: share of the samples with a friction error of at most 5 %
    - velocity: error [rad/s]
    """

    settled: float
    before: float
    after: float
    friction: float
    within: float
    velocity: float


@dataclass(frozen=True)
class Second:
    """Results of the second test.

    - low, high: range of alpha [1 | N m]
    - series: mean alpha in the second half of each series of steps [1 | N m]
    - friction, velocity: errors [%], [rad/s]
    """

    low: float
    high: float
    series: tuple[float, float]
    friction: float
    velocity: float


def truth(model: Model, main: Stream) -> Truth:
    """Return the true values from the stream of a simulation."""
    signals, known = main.signals, friction_map(model)
    position, velocity = signals["position_true"], signals["velocity"]
    sides = [friction_at(known, direction, position) for direction in (1, -1)]
    factor = signals.get("friction_factor", np.ones(velocity.size))
    return Truth(main.time, velocity, np.sign(velocity) * np.where(velocity > 0.0, *sides) * factor)


def slipping(known: Truth, found: ObserverOutput, observer: Observer) -> BoolVector:
    """Return a mask (n,) of the samples in which axis and observer both slip."""
    assert observer.switched is not None
    sigma = observer.switched.switch_speed.value
    both: BoolVector = (np.abs(known.velocity) >= sigma) & (np.abs(found.velocity) >= sigma)
    return both


def first(known: Truth, found: ObserverOutput, observer: Observer) -> First:
    """Return the results of the first test."""
    assert found.wear is not None
    time, last = known.time, known.time >= known.time[-1] - 5.0
    both, error = slipping(known, found, observer), found.friction - known.friction
    if observer.kind == "multiplicative":
        inside = np.abs(found.wear / WORN - 1.0) <= WITHIN
    else:
        inside = _over_a_period(known, error, both & (time >= ONSET)) <= WITHIN
    near = np.abs(error) <= WITHIN * np.abs(known.friction)
    before = (time >= 0.5 * ONSET) & (time < ONSET)
    return First(
        settled=_settled(time, inside),
        before=float(np.mean(found.wear[before])),
        after=float(np.mean(found.wear[last])),
        friction=_relative(error[both & last], known.friction[both & last]),
        within=float(np.mean(near[both & last])) if np.any(both & last) else 0.0,
        velocity=_rms((found.velocity - known.velocity)[last]),
    )


def second(known: Truth, found: ObserverOutput, observer: Observer) -> Second:
    """Return the results of the second test."""
    assert found.wear is not None
    time, both = known.time, slipping(known, found, observer) & (known.time >= SETTLED_AFTER)
    wear, end = found.wear[time >= SETTLED_AFTER], float(time[-1])
    halves = [(time >= (0.25 + part) * end) & (time <= (0.5 + part) * end) for part in (0.0, 0.5)]
    return Second(
        low=float(np.min(wear)),
        high=float(np.max(wear)),
        series=(float(np.mean(found.wear[halves[0]])), float(np.mean(found.wear[halves[1]]))),
        friction=_relative((found.friction - known.friction)[both], known.friction[both]),
        velocity=_rms(found.velocity - known.velocity),
    )


def _over_a_period(known: Truth, error: Vector, both: BoolVector) -> Vector:
    """Return the relative friction error over the period of the sine that ends at each sample (n,).

    Only samples in `both` (n,) count.
    """
    samples = round(PERIOD / float(known.time[1] - known.time[0]))

    def summed(values: Vector) -> Vector:
        total = np.cumsum(np.where(both, values, 0.0))
        return np.asarray(total - np.concatenate([np.zeros(samples), total[:-samples]]))

    there = summed(known.friction**2)
    return np.sqrt(summed(error**2) / np.where(there > 0.0, there, math.inf)) + np.where(
        there > 0.0, 0.0, math.inf
    )


def _settled(time: Vector, inside: BoolVector) -> float:
    """Return the time after the onset from which `inside` stays True, or infinity."""
    after = time >= ONSET
    outside = np.flatnonzero(~inside[after])
    if outside.size and outside[-1] == np.count_nonzero(after) - 1:
        return math.inf
    return float(time[after][outside[-1] + 1] - ONSET) if outside.size else 0.0


def _relative(error: Vector, of: Vector) -> float:
    """Return the relative rms error in %; infinite without samples."""
    return 100.0 * _rms(error) / _rms(of) if of.size else math.inf


def _rms(values: Vector) -> float:
    return float(np.sqrt(np.mean(values**2)))


def found_in(log: Log) -> ObserverOutput:
    """Return the estimates of `observe run --observer` from its log."""
    stream = next(stream for stream in log.streams if stream.topic == TOPIC)
    signals = stream.signals
    wear = signals.get("wear", signals.get("added"))
    return ObserverOutput(
        stream.time, signals["position"], signals["velocity"], signals["friction"], wear
    )


def line(figures: First | Second) -> tuple[str, ...]:
    """Return the cells of a table row, in the order of HEADS."""
    if isinstance(figures, First):
        settled = "never" if math.isinf(figures.settled) else f"{figures.settled:.3f}"
        alphas = f"{figures.before:.3f}", f"{figures.after:.3f}"
        return (
            settled,
            *alphas,
            f"{figures.friction:.1f}",
            f"{100 * figures.within:.0f} %",
            f"{figures.velocity:.1f}",
        )
    alphas = f"{figures.low:.3f}", f"{figures.high:.3f}"
    return (
        *alphas,
        *(f"{mean:.3f}" for mean in figures.series),
        f"{figures.friction:.1f}",
        f"{figures.velocity:.1f}",
    )


def figures(folder: Path, test: str, loop: str, name: str) -> First | Second:
    """Return the results of the observer `name` in one loop.

    The files are folder/test/LOOP/run.mcap, folder/test/NAME.yaml and folder/test/LOOP/NAME.mcap.
    """
    observer = load(folder / test / f"{name}.yaml", Observer)
    model = load(folder / test / "model.yaml", Model)
    known = truth(model, read_log(folder / test / loop / "run.mcap").streams[0])
    found = found_in(read_log(folder / test / loop / f"{name}.mcap"))
    return first(known, found, observer) if test == "first" else second(known, found, observer)


def table(folder: Path, test: str) -> list[str]:
    """Return the lines of a test: every observer in every loop."""
    rows: list[tuple[str, ...]] = [("loop", "observer", *HEADS[test])]
    for loop in sorted(path.parent.name for path in (folder / test).glob("*/run.mcap")):
        names = sorted(
            path.stem for path in (folder / test / loop).glob("*.mcap") if path.name != "run.mcap"
        )
        rows += [(loop, name, *line(figures(folder, test, loop, name))) for name in names]
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    return [
        f"{test} test",
        *(
            "  ".join(cell.rjust(width) for cell, width in zip(row, widths, strict=True))
            for row in rows
        ),
    ]


def main(arguments: list[str]) -> int:
    if len(arguments) != 1:
        print(__doc__, file=sys.stderr)
        return 2
    for test in HEADS:
        lines = table(Path(arguments[0]), test)
        if len(lines) < 3:
            print(
                f"{Path(arguments[0]) / test}: no run.mcap with estimates in a folder of it",
                file=sys.stderr,
            )
            return 1
        print("\n".join(lines) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
