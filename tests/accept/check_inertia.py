"""The inertia beside friction that varies with the position: does the weak form's interval hold it,
on the tutorial's clutch and test?

Each seed has its own inertia, within the bench's range, its own turning places, encoder phase and
noise: `excite --kind sines` played to configs/clutch/nonlinear.yaml under the gains of
docs/tutorial.md. It passes between 92 and 98 % of the records.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import msgspec
import numpy as np

from frictool.cli.position_loop_options import ServoGains
from frictool.documents.model import Model
from frictool.documents.provenance import Provenance
from frictool.documents.registry import load
from frictool.identify.estimators.weak import weak
from frictool.identify.excite.excitation_kinds import ExcitationSettings as Test
from frictool.identify.excite.excitation_kinds import excite
from frictool.identify.methods import IdentificationSettings
from frictool.identify.motion_record import MotionRecord, record_of
from frictool.simulate.bench_experiment import bench_test
from studies.rigs.clutch_friction import KNEE
from studies.rigs.identification_rigs import ROOT, clutch
from tests.support.identification_statistics import HIGHEST, LOWEST, RATE

SEEDS = 200
GAINS, NOISE = ServoGains(30.0, 0.1, None), 0.1  # A


def played(seed: int) -> tuple[MotionRecord, float]:
    """The record of a seed, and its inertia."""
    model = load(ROOT / "configs" / "clutch" / "nonlinear.yaml", Model)
    known = model.bench.mechanics.inertia
    inertia = float(np.random.default_rng([seed, 77]).uniform(*known.interval))
    drawn = msgspec.structs.replace(model.parameters.inertia, value=inertia)
    model = msgspec.structs.replace(
        model, parameters=msgspec.structs.replace(model.parameters, inertia=drawn)
    )
    test = excite("sines", model.bench, Test(seed=seed)).as_log("sines")
    log = bench_test(
        model,
        test,
        GAINS.servo(model.bench),
        NOISE,
        seed,
        Provenance(command="accept", frictool="0"),
    )
    return record_of(log, model.bench), inertia


def coverage() -> dict[str, Any]:
    """Inertia and knee; the structure that was chosen."""
    hits, knees, errors, halves, right = 0, 0, [], [], 0
    for seed in range(SEEDS):
        record, inertia = played(seed)
        found = weak([record], clutch(), IdentificationSettings(RATE))
        interval = found.parameters["inertia"]
        hits += interval.low <= inertia <= interval.high
        errors.append(interval.value / inertia - 1.0)
        halves.append(interval.half_width / inertia)
        regimes = () if found.laws is None else found.laws.regimes
        right += len(regimes) == 1 and found.details["position_order"] >= 4
        knees += any(one.above.low <= KNEE <= one.above.high for one in regimes)
    return {
        "passed": LOWEST * SEEDS <= hits <= HIGHEST * SEEDS and right == SEEDS,
        "seeds": SEEDS,
        "stated_rate": RATE,
        "covered_inertia": int(hits),
        "covered_knee": int(knees),
        "right_structure": int(right),
        "rms_percent": 100.0 * float(np.sqrt(np.mean(np.square(errors)))),
        "mean_percent": 100.0 * float(np.mean(errors)),
        "half_percent": 100.0 * float(np.median(halves)),
    }


CHECKS: dict[str, Callable[[], dict[str, Any]]] = {
    "identify: inertia beside the friction map": coverage
}
