"""An arm that turns several times under gravity that the bench does not declare."""

from __future__ import annotations

from pathlib import Path

import msgspec
import numpy as np
import pytest

from frictool.documents.bench import Bench
from frictool.documents.quantity import Quantity
from frictool.documents.registry import load
from frictool.identify.identification import identify_records
from frictool.identify.methods import IdentificationSettings
from frictool.identify.motion_record import make_record
from tests.identify.arm import PERIOD, Arm, play, write_bench

TIME = np.arange(8_000) * PERIOD


@pytest.mark.parametrize("seed", [2, 4, 8])
def test_the_intervals_of_a_requested_method_hold_the_truth(tmp_path: Path, seed: int) -> None:
    """Gravity takes a third and more of the inertia's effort, and the method has no column."""
    draw = np.random.default_rng([seed, 42])
    inertia, rate, size = (
        10.0 ** draw.uniform(-1.0, 0.0),
        draw.uniform(2.0, 5.0),
        draw.uniform(4, 9),
    )
    inertial = inertia * size * rate**2
    coulomb = inertial * draw.uniform(0.3, 1.5)
    arm = Arm(
        inertia,
        coulomb * draw.uniform(0.2, 1.0) / (size * rate),
        coulomb,
        coulomb * draw.uniform(1.0, 1.2),
        inertial * draw.uniform(0.3, 1.2),
        int(10.0 ** draw.uniform(4.0, 5.0)),
    )
    loop = 12.0 * rate
    gains = inertia * loop**2, 0.2 * inertia * loop**3, 1.6 * inertia * loop
    command = size * np.minimum(TIME / 0.8, 1.0) ** 2 * np.sin(rate * TIME)
    position, effort = play(arm, command, gains)
    noise = 0.01 * np.quantile(np.abs(effort), 0.99) * draw.standard_normal(TIME.size)
    bench = load(write_bench(tmp_path, arm), Bench)
    limit = Quantity(5.0 * float(np.max(np.abs(effort))), unit="A")
    bench = msgspec.structs.replace(
        bench, actuator=msgspec.structs.replace(bench.actuator, limit=limit)
    )
    record = make_record("log", TIME, position, effort + noise, arm.step, 0.0)
    settings = IdentificationSettings()
    result = identify_records([record], [], bench, "least-squares", settings)
    assert any("above 20 %" in warning for warning in result.warnings)
    for name, interval in result.identified.items():
        if name != "offset":
            assert interval.low <= getattr(arm, name) <= interval.high
