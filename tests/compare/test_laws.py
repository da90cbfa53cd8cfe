"""The real laws with table 3.1: figures that the thesis or a derivation gives, and the rules of the
hybrid versions."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from frictool.compare import (
    drift_criterion,
    input_protocol,
    limit_cycle_criterion,
    prescribed_motion,
    presliding_criterion,
    stick_slip_criterion,
)
from frictool.compare.comparison import POINTS_PER_LEG
from frictool.compare.comparison_setting import scaled_setting, table_3_1
from frictool.compare.law_simulator import LawSimulator, setting_violations
from frictool.compare.trajectory import LawTrajectory
from frictool.friction.law_registry import LAWS

TABLE = table_3_1()
SIMULATOR = LawSimulator(TABLE)


@cache
def pulled(law: str) -> stick_slip_criterion.StickSlipResult:
    return stick_slip_criterion.measure(
        SIMULATOR.run(law, input_protocol.stick_slip(TABLE.scales), 60_001), TABLE.stribeck_velocity
    )


@cache
def drifting(law: str) -> LawTrajectory:
    return SIMULATOR.run(law, input_protocol.drift(TABLE.scales), 20_401)


def wandered(law: str) -> drift_criterion.DriftResult:
    return drift_criterion.measure(drifting(law), TABLE.presliding, 1.0)


def crept(law: str) -> presliding_criterion.PreslidingResult:
    path, turning = input_protocol.presliding_path(TABLE.presliding, POINTS_PER_LEG)
    friction = SIMULATOR.creep(law, path, input_protocol.CREEP_SPEED)
    return (
        presliding_criterion.RIGID
        if friction is None
        else presliding_criterion.measure(
            path, friction, turning, TABLE.breakaway, TABLE.presliding
        )
    )


def test_the_event_exact_law_sticks_and_slips_as_derived() -> None:
    found = pulled("stribeck")
    assert found.sticks == 9
    assert found.first_breakaway_s == pytest.approx(7.5, abs=1e-9)
    assert found.period_s == pytest.approx(6.5123, abs=1e-4)
    assert found.jump == pytest.approx(0.6512, abs=1e-4)
    assert found.stuck_share == pytest.approx(0.621, abs=5e-4)
    assert found.top_speed == pytest.approx(0.381, abs=5e-4)


@pytest.mark.parametrize(
    ("law", "sticks", "period"),
    [
        ("lugre", 9, 6.395),
        pytest.param("hybrid_a", 9, 6.5124, marks=pytest.mark.accept),
        ("karnopp", 9, 6.455),
        ("dahl", 1, None),
    ],
)
def test_stick_slip(law: str, sticks: int, period: float | None) -> None:
    found = pulled(law)
    assert (found.sticks, found.period_s) == (sticks, period and pytest.approx(period, rel=2e-3))


def test_a_limit_cycle_lasts_with_a_rigid_stick_and_dies_out_with_an_elasto_plastic_contact() -> (
    None
):
    def cycling(law: str) -> limit_cycle_criterion.LimitCycleResult:
        return limit_cycle_criterion.measure(
            SIMULATOR.run(law, input_protocol.limit_cycle(TABLE.scales), 60_001), TABLE.presliding
        )

    exact, plastic = cycling("stribeck"), cycling("elasto_plastic")
    assert (exact.amplitude, exact.period_s) == (
        pytest.approx(0.0669, abs=1e-4),
        pytest.approx(23.73, abs=1e-2),
    )
    assert plastic.period_s is None
    assert plastic.verdict(exact) == "-"


@pytest.mark.parametrize(
    ("law", "closure", "area", "verdict"),
    [
        ("lugre", 0.116, 0.377, "±"),
        ("elasto_plastic", 0.0, 0.001, "±"),
        ("hybrid_b", 0.0, 0.001, "±"),
        ("hybrid_c", 0.0, 0.455, "+"),
    ],
)
def test_presliding(law: str, closure: float, area: float, verdict: str) -> None:
    found = crept(law)
    assert found.closure == pytest.approx(closure, abs=5e-4)
    assert found.area == pytest.approx(area, rel=0.03 if law == "hybrid_c" else 1e-9, abs=5e-4)
    assert found.verdict == verdict


@pytest.mark.parametrize(
    "law", ["coulomb", "stribeck", "karnopp", "svc_band", "coulomb_tanh", "hybrid_a"]
)
def test_rigid_and_creeping_laws_have_no_presliding(law: str) -> None:
    assert crept(law) == presliding_criterion.RIGID


@pytest.mark.parametrize(
    ("law", "units"),
    [
        ("lugre", 86.0),
        pytest.param("dahl", 221.0, marks=pytest.mark.accept),
        pytest.param("svc_band", 9700.0, marks=pytest.mark.accept),
        ("stribeck", 0.0),
        pytest.param("maxwell_slip", 0.0, marks=pytest.mark.accept),
    ],
)
def test_drift(law: str, units: float) -> None:
    assert wandered(law).z_max_units == pytest.approx(units, rel=0.015, abs=1e-3)


def test_another_actuator_gives_the_same_figures_in_its_own_units() -> None:
    """Similarity: mass, force and time of a clutch; every dimensionless figure is that of table
    3.1."""
    clutch = scaled_setting("clutch", "rotary", 1.3e-5, 0.1, 0.15, 3.8e-4)
    scales, laws = clutch.scales, LawSimulator(clutch)
    found = stick_slip_criterion.measure(
        laws.run("stribeck", input_protocol.stick_slip(scales), 20_001), clutch.stribeck_velocity
    )
    here = pulled("stribeck")
    assert found.period_s is not None
    assert here.period_s is not None
    assert found.period_s / scales.time == pytest.approx(here.period_s, rel=1e-8)
    assert found.top_speed / scales.speed == pytest.approx(here.top_speed, rel=1e-4)


def test_the_printed_table_breaks_3_31_and_only_for_hybrid_versions() -> None:
    printed = replace(TABLE, step=1e-4, switch_velocity=1e-4)
    broken, advice = setting_violations(printed, ("lugre", "hybrid_a", "hybrid_b"))
    assert len(broken) == len(advice) == 1
    assert broken[0].startswith("m Sigma > u_max T_e")
    assert "0.0001 N s" in broken[0]
    assert "0.0002 N s" in broken[0]
    assert advice[0].startswith("Sigma > 3 v_s")
    assert setting_violations(printed, ("lugre", "stribeck")) == ([], [])
    assert setting_violations(TABLE, SIMULATOR.names()) == ([], [])
    assert setting_violations(replace(printed, step=4e-5), ("hybrid_b",))[0] == []


def test_parameters_are_counted_as_in_table_3_2() -> None:
    counted = {
        law: SIMULATOR.parameters(law)
        for law in ("lugre", "elasto_plastic", "hybrid_a", "hybrid_b", "hybrid_c")
    }
    assert counted == {
        "lugre": 7,
        "elasto_plastic": 8,
        "hybrid_a": 5,
        "hybrid_b": 6,
        "hybrid_c": 6 + 20 * 21 // 2,
    }


@pytest.mark.parametrize("law", ["lugre", "leuven", "maxwell_slip", "hybrid_b", "stribeck"])
def test_a_steady_slide_follows_the_curve_of_stribeck(law: str) -> None:
    """The contact's own steady state at three speeds, against (2.34) written out."""
    for v in (3e-4, 1e-3, 5e-3):
        steps = np.full(4000, TABLE.presliding / 50.0 / v)
        friction = prescribed_motion.friction_along(
            LAWS[law], SIMULATOR.packed(law), np.full(4000, v), steps
        )[-1]
        assert friction == pytest.approx(1.0 + 0.5 * np.exp(-((v / 1e-3) ** 2)) + 0.4 * v, rel=2e-3)


@cache
def properties(law: str) -> dict[str, str]:
    """Return the column of a law in table 2.1."""
    compliance = SIMULATOR.creep(law, np.linspace(0.0, 1e-6, 3), 1e-6) is not None
    return SIMULATOR.properties(law, compliance, drifting(law))


@pytest.mark.parametrize(
    ("law", "row", "cell"),
    [
        ("coulomb", "stiction", "±"),
        ("karnopp", "stiction", "+"),
        ("coulomb_tanh", "stiction", "-"),
        ("karnopp", "stribeck_effect", "-"),
        ("lugre", "rising_static_friction", "±"),
        ("lugre", "frictional_memory", "±"),
        ("dahl", "frictional_memory", "-"),
        ("dahl", "rising_static_friction", "-"),
        ("dahl", "viscous", "-"),
        ("svc", "viscous", "+"),
        ("svc", "stribeck_effect", "-"),
    ],
)
def test_cells_of_table_2_1(law: str, row: str, cell: str) -> None:
    assert properties(law)[row] == cell
