"""The parameters of every law from a model and its bench, each by its stated rule."""

from __future__ import annotations

import math
from dataclasses import replace

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from frictool.compare import input_protocol, stick_slip_criterion
from frictool.compare.actuator_setting import from_model
from frictool.compare.comparison_setting import ComparisonSetting
from frictool.compare.law_simulator import LawSimulator, setting_violations
from frictool.documents.model import Model
from frictool.documents.quantity import Quantity
from studies.rigs.clutch_model import clutch_model


def changed(**parameters: float) -> Model:
    """The clutch with other values of some parameters."""
    model = clutch_model()
    found = {
        name: msgspec.structs.replace(getattr(model.parameters, name), value=value)
        for name, value in parameters.items()
    }
    return msgspec.structs.replace(
        model, parameters=msgspec.structs.replace(model.parameters, **found)
    )


def on_bench(period: float, counts: float) -> ComparisonSetting:
    model = clutch_model()
    encoder = msgspec.structs.replace(model.bench.encoder, counts_per_revolution=counts)
    return from_model(
        msgspec.structs.replace(
            model,
            bench=msgspec.structs.replace(model.bench, sample_period_s=period, encoder=encoder),
        )
    )


def test_parameters_follow_from_bench_and_model_by_the_stated_rules() -> None:
    found = from_model(clutch_model())
    assert found.scales.time == pytest.approx(1.32e-5 / 3.81e-4 / 2.5)
    assert found.scales.fall == pytest.approx(0.2)
    assert found.decay == pytest.approx(5.0 / 1e-3)  # (3.8)
    assert found.switch_velocity == pytest.approx(4.0 * found.stribeck_velocity)
    assert found.switch_velocity < found.decay * 2.0 * math.pi / 56.0  # (3.10)
    assert found.effort_limit == pytest.approx(50.0 * 13.4e-3)
    assert found.stiffness * found.presliding == pytest.approx(found.breakaway)  # (3.35)
    assert found.damping == pytest.approx(2.0 * math.sqrt(found.mass * found.stiffness))
    assert found.presliding < 2.0 * math.pi / 56.0


@given(st.floats(1e-5, 1e-2), st.floats(4.0, 1e7))
def test_what_follows_from_a_bench_keeps_every_inequality(period: float, counts: float) -> None:
    """(3.8), (3.10), (3.11), (3.2), for any sample period and encoder; the coarse encoders of a
    slow bench and the finest."""
    found = on_bench(period, counts)
    assert setting_violations(found, ("hybrid_a", "hybrid_b", "hybrid_c")) == ([], [])
    assert found.step * math.sqrt(found.stiffness / found.mass) < 0.1
    assert found.step * found.decay <= 1.0


def test_a_bench_that_breaks_an_inequality_is_told_with_its_own_numbers() -> None:
    found = from_model(clutch_model())
    broken, _ = setting_violations(replace(found, decay=1000.0), ("hybrid_a",))
    assert broken == ["p0 >= 5/T_s: p0 = 1000 1/s, 5/T_s = 5000 1/s (T_s = 0.001 s)"]
    broken, _ = setting_violations(replace(found, encoder_step=1e-6), ("hybrid_a",))
    assert broken[0].startswith("Sigma < delta_x p0")


def test_the_tests_fit_the_axis() -> None:
    """Without viscous friction, and with little: travel and top speed of the bench limit the
    scales, and the runs keep within them."""
    for viscous in (0.0, 1e-6):
        found = from_model(changed(viscous=viscous))
        assert 8.0 * found.scales.length <= 63.0 * (1.0 + 1e-9)
        assert found.scales.speed <= 400.0 * (1.0 + 1e-9)
        run = LawSimulator(found).run("stribeck", input_protocol.stick_slip(found.scales), 2001)
        assert abs(run.position).max() < 63.0
        assert abs(run.velocity).max() < 400.0


@pytest.mark.parametrize("ratio", [1.1, 1.3, 2.0])
def test_whatever_the_fall_of_the_friction_the_actuator_sticks_as_often_and_lugre_is_as_rigid(
    ratio: float,
) -> None:
    """Amplitudes are proportional to F_s - F_c: with the pull's speed in proportion, the periods
    are those of table 3.1."""
    setting = from_model(changed(breakaway=ratio * 0.099))
    exact, lugre = (
        stick_slip_criterion.measure(
            LawSimulator(setting).run(law, input_protocol.stick_slip(setting.scales), 60_001),
            setting.stribeck_velocity,
        )
        for law in ("stribeck", "lugre")
    )
    assert exact.sticks == 9
    assert exact.period_s is not None
    assert exact.period_s / setting.scales.time == pytest.approx(6.5123, rel=0.01)
    assert exact.jump == pytest.approx(
        0.6512 * setting.scales.fall * setting.scales.length, rel=0.02
    )
    assert lugre.verdict(exact) == "+"


def test_an_actuator_without_dry_friction_or_too_weak_is_refused() -> None:
    with pytest.raises(ValueError, match=r"parameters\.coulomb: found 0"):
        from_model(changed(coulomb=0.0))
    with pytest.raises(
        ValueError,
        match=r"gives at most 0\.67 N m \(N\); allowed: more than parameters\.breakaway, 1 N m",
    ):
        from_model(changed(breakaway=1.0))
    assert from_model(changed(breakaway=0.01)).breakaway == 0.099
    model = clutch_model()
    slow = msgspec.structs.replace(model.bench.mechanics, top_speed=Quantity(1.0, unit="rad/s"))
    scales = from_model(
        msgspec.structs.replace(model, bench=msgspec.structs.replace(model.bench, mechanics=slow))
    ).scales
    assert scales.speed == pytest.approx(1.0)
