"""Default gains of a bench's position loop, for simulated tests.

    effort = P (reference - position) + D d/dt (reference - position) + feedforward
    feedforward = inertia a + viscous v + coulomb sign(v) + offset

P and D are gains; inertia, viscous, coulomb and offset are values of the bench; v and a are the
velocity and the acceleration of the reference. If a test has a column FEEDFORWARD, the feedforward
in this column is used instead. The speed loop has the bandwidth 0.5/delay, where delay is the sum
of the drive's time constant, the computational delay and one period. The position loop has 0.3
times the bandwidth of the speed loop. D is reduced, and P with D, such that a position change of
one encoder count changes the drive by at most a quarter of the drive's limit.
"""

from __future__ import annotations

import numpy as np

from frictool.documents.bench import Bench
from frictool.engine.bench_position_loop import PositionServo
from frictool.logs.log import Log
from frictool.typing import Vector

SPEED_SHARE = 0.5  # bandwidth of the speed loop times the delay
POSITION_SHARE = 0.3  # bandwidth of the position loop divided by the bandwidth of the speed loop
FEEDFORWARD = "feedforward"  # column of a test with the effort of the loop's feedforward
LARGEST_COUNT = 0.25  # largest change of the drive by one count, relative to the drive's limit


def default_servo(bench: Bench) -> PositionServo:
    """Return a position loop for a bench, with default gains from position to effort."""
    actuator = bench.actuator
    period = bench.sample_period_s
    delay = actuator.loop_time_constant_s + (1 + bench.delay_samples) * period
    limit = actuator.constant.value * actuator.limit.value
    damping = min(
        bench.mechanics.inertia.value * SPEED_SHARE / delay,
        LARGEST_COUNT * limit * period / bench.encoder.resolution,
    )
    bandwidth = damping / bench.mechanics.inertia.value
    return PositionServo(
        proportional=damping * POSITION_SHARE * bandwidth,
        derivative=damping,
        reference_rate=1.0,
        limit=limit,
    )


def feedforward(bench: Bench, excitation: Log) -> Vector | None:
    """Return the feedforward (n,) [N m | N] of a test; None for a test with drive ramps.

    The feedforward is the column FEEDFORWARD of the test. Without this column, it is the effort
    that the bench's nominal axis needs to follow the reference.
    """
    signals = excitation.main.signals
    if "reference" not in signals:
        return None
    if FEEDFORWARD in signals:
        return signals[FEEDFORWARD]
    known = bench.mechanics
    period = bench.sample_period_s
    rate = signals.get("reference_velocity")
    velocity = np.gradient(signals["reference"], period) if rate is None else rate
    acceleration = np.gradient(velocity, period)
    offset = known.offset.value if known.offset else 0.0
    return np.asarray(
        known.inertia.value * acceleration
        + known.viscous.value * velocity
        + known.coulomb.value * np.sign(velocity)
        + offset
    )
