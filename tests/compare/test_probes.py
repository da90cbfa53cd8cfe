"""Each criterion of table 2.1 on a law that has the property and on one that has not."""

from __future__ import annotations

import math

import numpy as np
import pytest

from frictool.compare import law_probes
from frictool.compare.comparison_setting import scaled_setting, table_3_1
from frictool.typing import Vector

TABLE = table_3_1()


def along(curve: object) -> law_probes.Follow:
    """The velocity-driven answer of a law without memory."""
    return lambda velocity, steps: np.array([curve(v) for v in velocity])


def stribeck(v: float) -> float:
    return 1.0 + 0.5 * math.exp(-((v / 1e-3) ** 2)) + 0.4 * v


def lagging(velocity: Vector, steps: Vector) -> Vector:
    """The Stribeck curve through a lag of 5 ms."""
    out, state = [], stribeck(float(velocity[0]))
    for v, h in zip(velocity, steps, strict=True):
        state += (stribeck(float(v)) - state) * (1.0 - math.exp(-h / 5e-3))
        out.append(state)
    return np.array(out)


def test_the_stribeck_effect_is_a_friction_that_falls() -> None:
    assert law_probes.stribeck_effect(along(stribeck), TABLE) == "+"
    assert law_probes.stribeck_effect(along(lambda v: 1.0 + 0.4 * v), TABLE) == "-"
    assert law_probes.stribeck_effect(along(lambda v: 1.0), TABLE) == "-"


def test_viscous_friction_grows_with_speed() -> None:
    assert law_probes.viscous_friction(along(stribeck), TABLE) == "+"
    assert (
        law_probes.viscous_friction(
            along(lambda v: 1.0 + 0.5 * math.exp(-((v / 1e-3) ** 2))), TABLE
        )
        == "-"
    )


def test_frictional_memory_is_a_loop_over_speed() -> None:
    assert law_probes.frictional_memory(lagging, TABLE) == "±"
    assert law_probes.frictional_memory(along(stribeck), TABLE) == "-"


def test_rising_static_friction_is_a_breakaway_that_depends_on_the_rate() -> None:
    assert law_probes.rising_static_friction(1.5, 1.42, TABLE) == "±"
    assert law_probes.rising_static_friction(1.5, 1.4999, TABLE) == "-"


@pytest.mark.parametrize(
    ("compliance", "held", "settles", "cell"),
    [
        (True, True, True, "-"),
        (False, False, True, "-"),
        (False, True, False, "±"),
        (False, True, True, "+"),
    ],
)
def test_stiction(compliance: bool, held: bool, settles: bool, cell: str) -> None:
    assert law_probes.stiction(compliance, held, settles) == cell


def test_a_fixed_step_settles_with_a_band_and_not_with_a_point() -> None:
    def point(v: float, u: float) -> tuple[float, float]:
        return (math.copysign(1.0, v) if v != 0.0 else u), v

    def band(v: float, u: float) -> tuple[float, float]:
        return (u, 0.0) if abs(v) <= 1e-3 else (math.copysign(1.0, v), v)

    assert law_probes.settles(band, TABLE)
    assert not law_probes.settles(point, TABLE)


def test_similar_actuators_have_similar_probes() -> None:
    """Scales turn mass, Coulomb and viscous friction into those of table 3.1; the same law has the
    same cells there."""
    other = scaled_setting("other", "rotary", 1.3e-5, 0.1, 0.15, 3.8e-4)
    scales = other.scales
    assert other.mass * scales.length / scales.time**2 / scales.force == pytest.approx(1.0)
    assert other.viscous * scales.speed / scales.force == pytest.approx(0.4)
    scaled = along(lambda v: scales.force * stribeck(v / scales.speed))
    assert (
        law_probes.stribeck_effect(scaled, other)
        == law_probes.viscous_friction(scaled, other)
        == "+"
    )
