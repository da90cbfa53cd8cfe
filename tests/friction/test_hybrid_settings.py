"""A set of parameters that breaks (3.31) or (3.36) is named with its numbers."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from frictool.friction.hybrid_time_step import (
    HybridBench,
    HybridSettings,
    violations,
)
from frictool.friction.law_registry import LAWS

TABLE = HybridBench(
    sample_period=5e-3, encoder_step=1e-3, inertia=1.0, effort_limit=2.0, stribeck_velocity=1e-3
)
GOOD = HybridSettings(convergence_rate=1e3, capture_velocity=0.01, step=4e-3)


def test_a_fitting_set_breaks_nothing() -> None:
    for law in LAWS.values():
        assert violations(law, TABLE, GOOD) == []


def test_table_3_1_breaks_its_own_inequality() -> None:
    printed = HybridSettings(convergence_rate=1e3, capture_velocity=1e-4, step=1e-4)
    assert violations(LAWS["hybrid_a"], TABLE, printed) == [
        "m Sigma > u_max T_e: m Sigma = 1 kg x 0.0001 m/s = 0.0001 N s, u_max T_e = 2 N x 0.0001 "
        "s = 0.0002 N s",
        "Sigma > 3 v_s: Sigma = 0.0001 m/s, 3 v_s = 0.003 m/s",
    ]
    (line,) = violations(LAWS["hybrid_b"], TABLE, replace(printed, step=4e-5))
    assert line.startswith("Sigma > 3 v_s")


@pytest.mark.parametrize(
    ("changed", "start", "numbers"),
    [
        ({"convergence_rate": 900.0}, "p0 >=", "p0 = 900 1/s, 5/T_s = 1000 1/s"),
        (
            {"capture_velocity": 1.1},
            "Sigma <",
            "Sigma = 1.1 rad/s, delta_x p0 = 0.001 rad x 1000 1/s = 1 rad/s",
        ),
        ({"shortest_step": 1e-6}, "T_0 >=", "T_0 = 0 s, T_e_min = 1e-06 s"),
        ({"step": 0.9}, "m Sigma >", "u_max T_e = 2 N m x 0.9 s = 1.8 N m s"),
    ],
)
def test_each_inequality_is_named_with_its_numbers(
    changed: dict[str, float], start: str, numbers: str
) -> None:
    (line,) = violations(LAWS["hybrid_a"], TABLE, replace(GOOD, **changed), axis="rotary")
    assert line.startswith(start)
    assert numbers in line
    assert bool(violations(LAWS["hybrid_b"], TABLE, replace(GOOD, **changed))) == (
        start == "m Sigma >"
    )


@pytest.mark.parametrize("bad", [math.nan, -1.0, 0.0, math.inf])
def test_a_bench_out_of_range_is_refused(bad: float) -> None:
    with pytest.raises(ValueError, match=r"^inertia is .*; allowed: a finite number > 0$"):
        violations(LAWS["hybrid_a"], replace(TABLE, inertia=bad), GOOD)
    with pytest.raises(ValueError, match=r"^step is .*; allowed: a finite number > 0$"):
        violations(LAWS["hybrid_a"], TABLE, replace(GOOD, step=bad))


@pytest.mark.parametrize(
    ("changed", "start"),
    [
        ({"convergence_rate": 1280.0}, None),  # p0 = 5/T_s is allowed
        ({"capture_velocity": 2.0}, "Sigma < delta_x p0"),
        ({"shortest_step": 0.25, "hold_time": 0.25}, None),  # T_0 = T_e_min is allowed
        ({"step": 0.25}, "m Sigma > u_max T_e"),
        ({"capture_velocity": 0.125}, "Sigma > 3 v_s"),
    ],
)
def test_equality_breaks_the_strict_inequalities_only(
    changed: dict[str, float], start: str | None
) -> None:
    """The two sides are equal without rounding."""
    bench = HybridBench(
        sample_period=2.0**-8,
        encoder_step=2.0**-10,
        inertia=1.0,
        effort_limit=2.0,
        stribeck_velocity=0.125 / 3.0 if start == "Sigma > 3 v_s" else 2.0**-10,
    )
    settings = replace(
        HybridSettings(convergence_rate=2048.0, capture_velocity=0.5, step=2.0**-10), **changed
    )
    found = [line.split(":")[0] for line in violations(LAWS["hybrid_a"], bench, settings)]
    assert found == ([] if start is None else [start])
