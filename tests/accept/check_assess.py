"""Does `assess` promise what the bench then gives? Its proposed test is played on simulated clutches and identified as it says.

Each seed has its own noise, turns, encoder phase and its own axis, as in check_identify. Promised is half of a 95 % interval: the errors of
the records have to be within it at about that rate, and their rms times 1.96 near it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import msgspec
import numpy as np
from scipy.stats import binom

from frictool.documents.bench import Bench
from frictool.identify.assess.assessment import assess
from frictool.identify.assess.bench_facts import facts_of
from frictool.identify.assess.verdicts import CONFIDENCE, QUANTILE, best_window
from frictool.identify.excite.kinds import Settings as Test
from frictool.identify.excite.kinds import excite
from frictool.identify.methods import Settings
from frictool.identify.record import Record
from frictool.identify.weak import weak
from sample_logs.make import NOISE, _play
from tests.accept.check_identify import experiment
from tests.identify.benches import clutch, record

RECORDS = 200
DURATION = 30.0  # s
CHANCE = 1e-3
PARAMETERS = ("inertia", "viscous", "coulomb")


def played(seed: int) -> tuple[Record, dict[str, float]]:
    """The record of the proposed test on the axis of a seed, and what that axis is."""
    truth, bench = experiment(seed)
    reference, velocity, acceleration = excite("sines", bench, Test(seed=seed, duration=DURATION)).columns.values()
    nominal = bench.mechanics
    forward = (nominal.inertia.value * acceleration + nominal.viscous.value * velocity) / truth.constant
    log = _play(reference, velocity, forward, np.random.default_rng([seed, 17]), truth)
    return record(log, truth), {name: getattr(truth, name) for name in PARAMETERS}


def without_interval(bench: Bench) -> Bench:
    """The same bench that knows no interval of the inertia: the worst case of quantisation then refuses nothing, and the error is seen."""
    inertia = msgspec.structs.replace(bench.mechanics.inertia, low=None, high=None)
    return msgspec.structs.replace(bench, mechanics=msgspec.structs.replace(bench.mechanics, inertia=inertia))


def errors(records: int) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """Relative errors (records, 3) of the weak form over the window that assess names."""
    bench = clutch()
    window = best_window(facts_of(bench, DURATION, NOISE, None, None))
    out = np.empty((records, len(PARAMETERS)))
    for seed in range(records):
        log, truth = played(seed)
        found = weak([log], without_interval(bench), Settings(CONFIDENCE, window)).parameters
        out[seed] = [found[name].value / truth[name] - 1.0 for name in PARAMETERS]
    return out


def assess_weak_form() -> dict[str, Any]:
    """The inertia that differentiation is refused for, by the weak form, to the precision that assess states."""
    row = next(one for one in assess(clutch(), {}, DURATION, NOISE).rows if one.parameter == "inertia")
    promised = row.verdict.precision
    assert promised is not None
    found = errors(RECORDS)[:, 0]
    inside, reached = int(np.count_nonzero(np.abs(found) <= promised)), QUANTILE * float(np.sqrt(np.mean(found**2)))
    least = int(binom.ppf(CHANCE, RECORDS, CONFIDENCE))
    return {
        "passed": row.verdict.method == "weak" and inside >= least and reached <= 1.2 * promised,
        "records": RECORDS,
        "by_differentiation": row.verdict.bound,
        "promised": promised,
        "reached": reached,
        "bias": float(found.mean()),
        "inside": inside,
        "least_accepted": least,
    }


CHECKS: dict[str, Callable[[], dict[str, Any]]] = {"assess_weak_form": assess_weak_form}
