"""Records of axes that a known effort or a position loop drives."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import msgspec
import numpy as np

from frictool.documents.quantity import Quantity
from frictool.engine.bench_position_loop import PositionServo
from frictool.engine.effort_replay import FREE, replay, replay_parameters
from frictool.identify.estimators.output_error import simulation_error
from frictool.identify.methods import IdentificationSettings
from frictool.identify.motion_record import MotionRecord
from frictool.plant.axis import AxisParameters, rest
from frictool.plant.position_load import PositionLoad
from studies.rigs.identification_rigs import (
    MASS,
    MASS_POLE,
    mass_bench,
    mass_reference,
    mass_sine,
)
from tests.support.linear_axis import ENCODER_STEP, PERIOD

NO_LOAD = PositionLoad()


def driven(
    axis: AxisParameters, load: PositionLoad = NO_LOAD, samples: int = 12_000
) -> MotionRecord:
    """A log without noise of an axis that a known effort drives; the encoder is fine."""
    draw = np.random.default_rng(7)
    time = np.arange(samples) * PERIOD
    effort = (
        14.0 * np.sin(2.0 * np.pi * 0.9 * time)
        + 9.0 * np.sin(2.0 * np.pi * 0.37 * time + 1.0)
        + 0.1 * draw.standard_normal(samples)
    )
    x, v = np.empty(samples), np.empty(samples)
    assert (
        replay(replay_parameters(axis), load.as_array(), rest(), effort, effort, FREE, PERIOD, x, v)
        == 0
    )
    x = np.floor(x / ENCODER_STEP) * ENCODER_STEP
    return MotionRecord(
        "driven", time, x, effort, np.zeros(samples, dtype=np.int64), PERIOD, ENCODER_STEP, 0.0
    )


def closed_loop_errors(seed: int, folder: Path) -> list[float]:
    """Relative errors of inertia, viscous and Coulomb friction of table 4.1's mass; its breakaway
    is known, as a ramp gives it."""
    gains = (
        3.0 * MASS_POLE**2 * MASS.inertia,
        MASS_POLE**3 * MASS.inertia,
        3.0 * MASS_POLE * MASS.inertia - MASS.viscous,
    )
    bench = mass_bench(folder)
    bench = msgspec.structs.replace(
        bench,
        mechanics=msgspec.structs.replace(
            bench.mechanics, breakaway=Quantity(MASS.breakaway, unit="N")
        ),
    )
    record = replace(mass_sine(seed), reference=mass_reference(seed))
    found = simulation_error(
        [record], bench, IdentificationSettings(), (), PositionServo(*gains, reference_rate=1.0)
    ).parameters
    return [
        found[name].value / getattr(MASS, name) - 1.0 for name in ("inertia", "viscous", "coulomb")
    ]


def plain_axis(**changes: object) -> AxisParameters:
    return AxisParameters(5.0, 12.0, 8.0, 8.0, 0.5)._replace(**changes)
