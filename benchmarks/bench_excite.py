"""Duration of a designed test, compared with the best test of a single kind.

excite.RIG       test of Coulomb friction to 2 % and inertia to 1 % on a bench of studies/promises.
                 frictool's value is the duration of the test that `excite --for` writes. The peer
                 is the shortest test of one kind (`excite --kind`) that reaches the same precision
                 in simulation. The last column also states the processor time of the design.
excite.design    largest of these processor times, compared with LIMIT
"""

from __future__ import annotations

import functools
import math
import time
from collections.abc import Callable
from typing import Any

from frictool.documents.bench import Bench
from frictool.errors import NoSolutionError
from frictool.identify.excite.excitation_kinds import (
    SINE_DURATION,
    ExcitationSettings,
    excite,
)
from frictool.identify.excite.precise_strokes import PrecisionRequest, bench_value
from frictool.identify.excite.sines import DURATION
from frictool.plan.rehearsal import rehearse
from frictool.plan.rehearsed_test import rehearsed_strokes
from studies.promises.rigs import benches

WANTED = {"coulomb": 0.02, "inertia": 0.01}
SINES = ("sine", "sines")  # kinds of test with a duration
REPETITIONS = {"steps": 1, "multisine": 3}  # default of the kinds of test with repetitions
ROUNDS, LONGEST = 5, 20.0  # rehearsed lengths of a kind; the longest relative to the default
RIGS = ("belt", "table", "pump", "stage", "emps")  # no test reaches the precision on other benches
LIMIT = 20.0  # s of processor time of a design
Row = Callable[[], dict[str, Any]]


@functools.cache
def designed(name: str) -> tuple[float, float]:
    """Return the duration of the designed test [s] and the processor time of its design [s]."""
    begin = time.process_time()
    test = rehearsed_strokes(_bench(name), PrecisionRequest(WANTED))
    return test.sequence.duration, time.process_time() - begin


def _bench(name: str) -> Bench:
    return next(bench for bench in benches() if bench.name == name)


def single_kind(bench: Bench, kind: str) -> float:
    """Return the duration of the shortest test of one kind with the requested precision [s].

    The half widths of a simulated test are proportional to the inverse square root of its length.
    The length of the next simulated test follows from this rule. The result is infinite if no test
    has the precision.
    """
    shortest = math.inf
    length = 1.0  # duration or repetitions, relative to the default
    for _ in range(ROUNDS):
        duration = (SINE_DURATION if kind == "sine" else DURATION) * length
        settings = (
            ExcitationSettings(seed=0, duration=duration)
            if kind in SINES
            else ExcitationSettings(seed=0, repetitions=max(round(REPETITIONS[kind] * length), 1))
        )
        try:
            sequence = excite(kind, bench, settings)
        except NoSolutionError:
            break
        sample = rehearse(sequence, bench, dict.fromkeys(WANTED, math.inf))
        ratio = max(
            one.upper / (WANTED[name] * bench_value(bench, name)) for name, one in sample.items()
        )
        if ratio <= 1.0:
            shortest = min(shortest, sequence.duration)
        length *= ratio**2
        if length > LONGEST:
            break
    return shortest


def _row(name: str) -> Row:
    def row() -> dict[str, Any]:
        duration, spent = designed(name)
        bench = _bench(name)
        least, kind = min((single_kind(bench, one), one) for one in (*SINES, *REPETITIONS))
        return {
            "peer": f"best single kind: {kind}",
            "ours": duration,
            "theirs": least,
            "unit": "s of test",
            "ratio": least / duration,
            "accuracy": f"Coulomb friction 2 %, inertia 1 %; designed in {spent:.3g} s",
        }

    row.id = f"excite.{name}"  # type: ignore[attr-defined]  # read by benchmarks/__main__.py
    return row


def excite_design() -> dict[str, Any]:
    """Return the row of the largest processor time of a design."""
    slowest, name = max((designed(name)[1], name) for name in RIGS)
    return {
        "peer": "limit of a design",
        "ours": slowest,
        "theirs": LIMIT,
        "unit": "s of cpu",
        "ratio": LIMIT / slowest,
        "accuracy": f"the slowest of {len(RIGS)} benches: {name}",
    }


excite_design.id = "excite.design"  # type: ignore[attr-defined]  # read by benchmarks/__main__.py
ROWS = [*(_row(name) for name in RIGS), excite_design]
