"""Settings from the bench keep (3.31); a set that breaks it is named with its numbers."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.friction.hybrid_time_step import (
    HybridBench,
    HybridSettings,
    settings_from_bench,
    violations,
)

TABLE = HybridBench(
    sample_period=5e-3, encoder_step=1e-3, inertia=1.0, effort_limit=2.0, stribeck_velocity=1e-3
)
CLUTCH = HybridBench(sample_period=1e-3, encoder_step=0.1122, inertia=1.32e-5, effort_limit=1.0)
GOOD = settings_from_bench(TABLE)
SIZES = st.floats(1e-6, 1e3)


@settings(derandomize=True, deadline=None, max_examples=100)
@given(
    period=st.floats(1e-5, 0.1), step=SIZES, inertia=SIZES, limit=SIZES, share=st.floats(0.0, 0.2)
)
def test_settings_from_a_bench_break_nothing(
    period: float, step: float, inertia: float, limit: float, share: float
) -> None:
    """Stribeck's velocity small beside an encoder step per capture, as (3.10) asks."""
    bench = HybridBench(period, step, inertia, limit, share * step * 5.0 / period)
    found = settings_from_bench(bench)
    for version in ("hybrid_a", "hybrid_b", "hybrid_c"):
        assert violations(version, bench, found) == []
    assert found.convergence_rate == pytest.approx(5.0 / period)


def test_settings_of_the_clutch_are_finer_than_those_of_table_4_8() -> None:
    """p0 5e3 1/s; Sigma below 100 rad/s, which ends 1.19 rad away from the exact solution."""
    found = settings_from_bench(CLUTCH)
    assert found.convergence_rate == pytest.approx(5e3)
    assert found.capture_velocity == pytest.approx(5.61, rel=1e-3)
    assert found.step == pytest.approx(0.8 * 1.32e-5 * found.capture_velocity, rel=1e-12)
    assert found.capture_velocity / found.convergence_rate < 0.02 * CLUTCH.encoder_step


def test_table_3_1_breaks_its_own_inequality() -> None:
    printed = HybridSettings(convergence_rate=1e3, capture_velocity=1e-4, step=1e-4)
    assert violations("hybrid_a", TABLE, printed) == [
        "(3.11) m Sigma > u_max T_e: m Sigma = 1 kg x 0.0001 m/s = 0.0001 N s, u_max T_e = 2 N x 0.0001 s = 0.0002 N s",
        "(3.2) Sigma > 3 v_s: Sigma = 0.0001 m/s, 3 v_s = 0.003 m/s",
    ]
    assert [line[:6] for line in violations("hybrid_b", TABLE, replace(printed, step=4e-5))] == [
        "(3.2) "
    ]


@pytest.mark.parametrize(
    ("changed", "start", "numbers"),
    [
        ({"convergence_rate": 900.0}, "(3.8)", "p0 = 900 1/s, 5/T_s = 1000 1/s"),
        (
            {"capture_velocity": 1.1},
            "(3.10)",
            "Sigma = 1.1 rad/s, delta_x p0 = 0.001 rad x 1000 1/s = 1 rad/s",
        ),
        ({"shortest_step": 1e-6}, "(3.31)", "T_0 = 0 s, T_e_min = 1e-06 s"),
        ({"step": 0.9}, "(3.11)", "u_max T_e = 2 N m x 0.9 s = 1.8 N m s"),
    ],
)
def test_each_inequality_is_named_with_its_numbers(
    changed: dict[str, float], start: str, numbers: str
) -> None:
    (line,) = violations("hybrid_a", TABLE, replace(GOOD, **changed), axis="rotary")
    assert line.startswith(start)
    assert numbers in line
    assert bool(violations("hybrid_b", TABLE, replace(GOOD, **changed))) == (start == "(3.11)")


@pytest.mark.parametrize("bad", [math.nan, -1.0, 0.0, math.inf])
def test_a_bench_out_of_range_is_refused(bad: float) -> None:
    with pytest.raises(ValueError, match=r"^inertia is .*; allowed: a finite number > 0$"):
        settings_from_bench(replace(TABLE, inertia=bad))
    with pytest.raises(ValueError, match=r"^step is .*; allowed: a finite number > 0$"):
        violations("hybrid_a", TABLE, replace(GOOD, step=bad))
