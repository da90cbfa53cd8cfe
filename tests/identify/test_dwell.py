"""Rising static friction: ramps of several rates tell it, ramps of one do not."""

from __future__ import annotations

import numpy as np
import pytest

from frictool.friction.rising_breakaway import dwell_factor
from frictool.identify.breakaway.breakaway import Breakaway, breakaway
from frictool.identify.breakaway.friction_map import breakaway_laws
from frictool.identify.breakaway.rising_friction import rising_friction
from frictool.identify.fit_result import SLIDING, Interval
from studies.rigs.identification_rigs import clutch, record
from studies.rigs.sample_logs import TRUTH, ramp

FULL, FRESH, RISE_TIME = 0.13, 0.8, 0.5
AXIS = TRUTH._replace(
    breakaway=FULL,
    encoder_step=2.0 * np.pi / 4096.0,
    laws=TRUTH.laws._replace(fresh=FRESH, rise_time=RISE_TIME),
)
KNOWN = {name: Interval(*[getattr(TRUTH, name)] * 3) for name in SLIDING}


@pytest.fixture(scope="module")
def found() -> Breakaway:
    logs = [
        record(ramp(seed, AXIS, rate), AXIS, f"{rate:g} A/s")
        for seed, rate in enumerate((4.0, 25.0, 120.0))
    ]
    return breakaway(logs, clutch(), KNOWN, 0.95)


def test_ramps_of_three_rates(found: Breakaway) -> None:
    assert found.rising is not None
    assert found.interval.value == pytest.approx(FULL, rel=3e-3)
    assert found.interval.low <= FULL <= found.interval.high
    assert found.rising.fresh.value == pytest.approx(FRESH, abs=0.01)
    assert found.rising.rise_time.value == pytest.approx(RISE_TIME, rel=0.1)


def test_the_document_has_it(found: Breakaway) -> None:
    laws = breakaway_laws(found, clutch())
    assert (laws.dwell.fresh, laws.dwell.rise_time_s) == (
        found.rising.fresh.value,
        found.rising.rise_time.value,
    )
    assert laws.dwell.fresh_interval is not None
    assert laws.dwell.fresh_interval[0] <= FRESH <= laws.dwell.fresh_interval[1]
    assert laws.dwell.rise_time_interval_s[0] <= RISE_TIME <= laws.dwell.rise_time_interval_s[1]
    assert found.parameter == found.interval


def test_one_rate_tells_nothing() -> None:
    log = record(ramp(1, AXIS), AXIS)
    assert breakaway([log], clutch(), KNOWN, 0.95).rising is None


def test_a_constant_stays_one() -> None:
    generator = np.random.default_rng(3)
    rested, direction = generator.uniform(0.05, 3.0, 120), np.tile([1.0, -1.0], 60)
    taken = sum(
        rising_friction(
            rested,
            direction,
            0.11 + 0.004 * direction + 1e-3 * generator.standard_normal(120),
            0.95,
        )
        is not None
        for _ in range(40)
    )
    assert taken <= 4


def test_the_law_is_the_engine_s() -> None:
    generator = np.random.default_rng(4)
    rested, direction = generator.uniform(0.05, 3.0, 120), np.tile([1.0, -1.0], 60)
    exact = FULL * np.array([dwell_factor(t, FRESH, RISE_TIME) for t in rested]) + 0.004 * direction
    rising = rising_friction(rested, direction, exact, 0.95)
    assert (rising.full.value, rising.fresh.value, rising.rise_time.value) == pytest.approx(
        (FULL, FRESH, RISE_TIME), rel=1e-4
    )
