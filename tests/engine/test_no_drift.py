"""Laws with a non-local memory under efforts below the breakaway: how far they wander (3.7.5), and
what the table of `compare` says of it.

Generalised Maxwell-slip comes back to one loop. Leuven's does in z only: by (2.49) dx = dz/(1 -+
|F_h/g|^i), so that a cycle moves it by at most 2 dz m^i/(1 - m^i), with m the largest effort over
F_s and dz the width of the loop that annex A gives.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from frictool.compare.comparison import SAMPLES, compare
from frictool.compare.comparison_setting import table_3_1
from frictool.compare.drift_criterion import measure
from frictool.compare.input_protocol import drift
from frictool.compare.law_simulator import LawSimulator
from frictool.engine.drive import EffortFunction, held, ramped
from frictool.engine.law_simulation import run_law
from frictool.engine.status_codes import OK
from frictool.friction.law_registry import LAWS
from studies.rigs.table_3_1 import TABLE_3_1

F_S, Z_MAX, FREQUENCY, CYCLES = 1.5, 1e-5, 2.0, 8
FAST = settings(derandomize=True, deadline=None, max_examples=12)
EFFORTS = {
    "mean": st.floats(-0.8, 0.8),
    "swing": st.floats(0.1, 0.8),
    "first": st.floats(-0.9, 0.9),
}


def wander(name: str, mean: float, swing: float, first: float, **changes: float) -> float:
    """In z_max, over 8 cycles after 4: mean + swing sin, in units of F_s, after a push of `first`
    that leaves its trace in the memory."""
    law, period = LAWS[name], 1.0 / FREQUENCY
    wave = EffortFunction(
        offset=mean * F_S,
        amplitude=swing * F_S,
        frequency=2.0 * math.pi * FREQUENCY,
        phase=-4.0 * math.pi * FREQUENCY,
    )
    segments = [
        (1.0, ramped(0.0, first * F_S)),
        (1.5, ramped(first * F_S, 2.0 * (mean - first) * F_S, start=1.0)),
        (2.0, held(mean * F_S)),
        (2.0 + (4 + CYCLES) * period, wave),
    ]
    run = run_law(
        law,
        law.pack({**TABLE_3_1[name], **changes}),
        1.0,
        segments,
        [2.0 + 4 * period, 2.0 + (4 + CYCLES) * period],
    )
    assert run.status == OK
    return float(run.position[1] - run.position[0]) / Z_MAX


@FAST
@given(**EFFORTS)
def test_maxwell_slip_does_not_drift_below_the_breakaway(
    mean: float, swing: float, first: float
) -> None:
    assume(abs(mean) + swing <= 0.93)
    assert abs(wander("maxwell_slip", mean, swing, first)) < 1e-3


@pytest.mark.parametrize("name", ["leuven", "leuven_masing"])
@FAST
@given(**EFFORTS, exponent=st.sampled_from([10.0, 30.0]))
def test_leuven_drifts_no_further_than_its_equation_says(
    name: str, mean: float, swing: float, first: float, exponent: float
) -> None:
    most = abs(mean) + swing
    assume(most <= 0.93)
    width = 2.0 * (
        1.0 - math.sqrt(1.0 - swing)
    )  # of the loop in z, in z_max: Masing's branch is 2 f(dz/2), f = 1 - (1 - z)^2
    bound = 2.0 * width * most**exponent / (1.0 - most**exponent)
    assert abs(wander(name, mean, swing, first, exponent=exponent)) <= CYCLES * bound + 1e-5


@FAST
@given(
    mean=st.floats(0.2, 0.5),
    swing=st.floats(0.2, 0.4),
    first=EFFORTS["first"],
    forward=st.booleans(),
)
def test_leuven_of_first_order_drifts_where_it_is_pushed(
    mean: float, swing: float, first: float, forward: bool
) -> None:
    towards = 1.0 if forward else -1.0
    assert towards * wander("leuven", towards * mean, swing, first, exponent=1.0) > 0.01


@pytest.mark.parametrize(
    ("law", "exponent", "claim"),
    [
        pytest.param("leuven", 1.0, "-", marks=pytest.mark.accept),
        ("leuven", 10.0, "+"),
        ("maxwell_slip", 10.0, "+"),
    ],
)
def test_the_table_claims_no_drift_where_there_is_none(
    law: str, exponent: float, claim: str
) -> None:
    setting = replace(table_3_1(), leuven_exponent=exponent)
    motion = LawSimulator(setting).run(law, drift(setting.scales), SAMPLES["drift"])
    found = measure(motion, setting.presliding, setting.scales.time)
    assert found.verdict == claim
    assert (abs(found.z_max_units) < 1.0) == (claim == "+")
    assert np.isfinite(found.z_max_units)


def test_the_table_has_the_verdict_of_the_drift() -> None:
    setting = replace(table_3_1(), leuven_exponent=1.0)
    found = compare(setting, LawSimulator(setting), ("leuven",)).laws["leuven"]
    assert found.properties["non_drift"] == found.drift.verdict == "-"
    assert 1.0 < abs(found.drift.z_max_units) < math.inf
