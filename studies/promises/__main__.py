"""Count of kept promises: a test for each of ten benches is simulated on random axes.

    python -m studies.promises N
    python -m studies.promises N --rig belt --rig clutch --seed 100

Each rig has N axes, drawn in the middle of its a-priori intervals, with the seeds SEED to SEED + N
- 1. The designed test must reach the half widths that the default kind of test promises. Like the
promises of `excite --for`, these are upper bounds from simulations of axes in the whole a-priori
intervals. Both tests therefore keep them on 97 of 100 axes. With --median, the test must reach the
median half widths of the default kind on the study's axes. The default kind itself keeps these on
half of the axes only. Both requests are printed above the rows of a rig. A rig is left out if its
default kind identifies nothing reliably. The table shows for each parameter

- the number of kept promises
- the number of intervals that contain the true value
- the variance of the estimate divided by the Cramér-Rao bound
- the durations of the test and of the default kind
- the processor time of the design [s]
"""

from __future__ import annotations

import argparse
import math
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from frictool.documents.bench import Bench
from frictool.errors import NoSolutionError
from frictool.identify.excite.excitation_kinds import ExcitationSettings, excite
from frictool.identify.excite.excitation_sequence import ExcitationSequence
from frictool.identify.excite.precise_strokes import (
    QUANTILE,
    PreciseTest,
    PrecisionRequest,
    bench_value,
)
from frictool.plan.rehearsed_test import DEFAULT_KIND, rehearsed_default, rehearsed_strokes
from studies.promises.rigs import benches, truth
from studies.promises.trial import TrialRow, identified, trial

WANTED = ("inertia", "viscous", "coulomb")
DEFAULT_SEEDS = 5  # simulations of the default kind of test
HEADER = (
    f"{'rig':<12}{'parameter':<11}{'kept':>9}{'held':>9}{'variance':>10}{'test s':>9}"
    f"{'default s':>11}{'design s':>10}"
)


@dataclass(frozen=True)
class PromiseCount:
    """Outcome of one parameter on one rig.

    - kept, held: number of kept promises, and of intervals that contain the true value
    - variance: mean square error divided by the Cramér-Rao bound; NaN without an estimate
    - duration, default: duration of the test, and of the default kind [s]
    - design: processor time of the design [s]
    """

    rig: str
    parameter: str
    trials: int
    kept: int
    held: int
    variance: float
    duration: float
    default: float
    design: float

    def row(self) -> str:
        """Return the row of the table."""
        return (
            f"{self.rig:<12}{self.parameter:<11}{f'{self.kept}/{self.trials}':>9}"
            f"{f'{self.held}/{self.trials}':>9}{self.variance:>10.2f}{self.duration:>9.2f}"
            f"{self.default:>11.2f}{self.design:>10.2f}"
        )


@dataclass(frozen=True)
class TestCost:
    """Duration of the default kind [s], and processor time of the design of a test [s]."""

    default: float
    design: float


def count(bench: Bench, test: PreciseTest, seeds: range, cost: TestCost) -> Iterator[PromiseCount]:
    """Yield the outcome of all trials for each parameter with a promised half-width."""
    rows = [row for seed in seeds for row in trial(bench, test, seed)]
    for name in test.half_widths:
        of_name = [row for row in rows if row.parameter == name]
        errors = np.array([row.error for row in of_name if row.half_width is not None])
        bound = test.bounds[name] / QUANTILE
        yield PromiseCount(
            bench.name,
            name,
            len(of_name),
            sum(_kept(row) for row in of_name),
            sum(row.held for row in of_name),
            float(np.mean((errors / bound) ** 2)) if errors.size else math.nan,
            test.sequence.duration,
            cost.default,
            cost.design,
        )


def promised_precision(bench: Bench) -> dict[str, float]:
    """Return the half widths that the default kind promises, relative to the bench's values."""
    promise = rehearsed_default(bench, PrecisionRequest(dict.fromkeys(WANTED, math.inf)))
    return {name: half / bench_value(bench, name) for name, half in promise.half_widths.items()}


def median_precision(bench: Bench, sequence: ExcitationSequence) -> dict[str, float]:
    """Return the median half width of each parameter by `sequence`, relative to the bench's value.

    A parameter that `identify` refuses in half of the simulations is left out.
    """
    results = [
        identified(bench, truth(bench, seed), sequence, seed).identified
        for seed in range(DEFAULT_SEEDS)
    ]
    medians = {
        name: float(
            np.median([one[name].half_width if name in one else math.inf for one in results])
        )
        for name in WANTED
    }
    return {
        name: half / bench_value(bench, name)
        for name, half in medians.items()
        if math.isfinite(half)
    }


def counts_of(bench: Bench, seeds: range, by_median: bool = False) -> Iterator[PromiseCount]:
    """Yield the counts of a test that is designed for the precision of the default kind.

    Nothing is yielded if the default kind has no precision. Raises NoSolutionError if no test
    reaches this precision.
    """
    default = excite(DEFAULT_KIND, bench, ExcitationSettings())
    promised, median = promised_precision(bench), median_precision(bench, default)
    for label, one in (("promised", promised), ("median", median)):
        figures = ", ".join(f"{name} {part:.3%}" for name, part in one.items())
        print(f"{bench.name:<12}{label} by the default kind: {figures or 'nothing'}", flush=True)
    wanted = median if by_median else promised
    if not wanted:
        return
    start = time.process_time()
    test = rehearsed_strokes(bench, PrecisionRequest(wanted))
    yield from count(bench, test, seeds, TestCost(default.duration, time.process_time() - start))


def _kept(row: TrialRow) -> bool:
    return row.half_width is not None and row.half_width <= row.promised


def main(arguments: list[str]) -> int:
    """Print the table; return the exit code."""
    names = [bench.name for bench in benches()]
    parser = argparse.ArgumentParser(
        prog="python -m studies.promises",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("count", type=int, metavar="N", help="drawn axes of each rig")
    parser.add_argument("--rig", action="append", choices=names, help="only this rig")
    parser.add_argument("--seed", type=int, default=0, help="first seed (0)")
    parser.add_argument("--median", action="store_true", help="request the median half widths")
    given = parser.parse_args(arguments)
    print(HEADER)
    counts: list[PromiseCount] = []
    for bench in benches():
        if given.rig and bench.name not in given.rig:
            continue
        try:
            seeds = range(given.seed, given.seed + given.count)
            for one in counts_of(bench, seeds, given.median):
                counts.append(one)
                print(one.row(), flush=True)
        except NoSolutionError as error:
            print(f"{bench.name:<12}refused: {error}", flush=True)
    total = sum(one.trials for one in counts)
    if total:
        print(f"kept {sum(one.kept for one in counts) / total:.1%}")
        print(f"held {sum(one.held for one in counts) / total:.1%}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
