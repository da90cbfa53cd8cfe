"""Sample logs: tests of a SIMULATED clutch (tables 4.5 and 4.8), in the format of a bench.

    python -m studies.rigs.sample_logs            writes sines.csv, ramp.csv and steps.csv into
                                                  sample_logs (`make logs`)

A seed determines every byte of a log. TRUTH has the parameters, which no log contains.

    sines   position servo on half sines of 100 to 350 rad/s, about 5 s at each speed (4.38). The
            positions of the reversals are random, because strokes that repeat each other exactly
            also repeat the encoder's error, which averaging does not remove.
    ramp    the current grows until the encoder moves, returns to 0 and grows again, in both
            directions over the travel (figure 4.6)
    steps   position servo on steps over the travel
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import NamedTuple

import numpy as np

from frictool.plant.axis import AxisParameters, rest
from frictool.runtime.kernels import kernel
from frictool.typing import IntVector, Vector
from studies.rigs.engine_pointer import Advance, advance_pointer

TRUTH = AxisParameters(
    inertia=1.32e-5,
    viscous=3.81e-4,
    coulomb=0.099,
    breakaway=0.109,
    offset=0.004,
    constant=0.0134,
    lag=0.003,
    drive_limit=50.0,
    backlash=3.0,
    backlash_coulomb=0.05,
    backlash_breakaway=0.055,
    encoder_step=2.0 * math.pi / 56.0,
)
PERIOD = 0.001  # s
NOISE = 0.1  # A, standard deviation of the measured current
CURRENT_DIGITS = 3  # the recorder writes mA
SEED = 20

LOW_TURN, HIGH_TURN = (
    (3.0, 9.0),
    (54.0, 60.0),
)  # rad, where the sines turn, within the travel of 0 to 63 rad
SPEEDS = (100.0, 150.0, 200.0, 250.0, 300.0, 350.0)  # rad/s
SECONDS_EACH = 5.0
STEPS = (5.0, 55.0, 5.0, 35.0, 15.0)  # rad
STEP_SECONDS = 1.1
REFERENCE_SPEED = 30.0  # rad/s, second-order filter of the steps

SERVO = (
    3.0,
    0.1,
    300.0,
)  # A/rad, A s/rad, rad/s: the bench's own servo on position and filtered speed
RAMP = 25.0  # A/s
MOVED_COUNTS = 10  # the ramp falls back when the encoder has moved so far
PAUSE = 0.05  # s without current after each breakaway
TURN = (3.0, 60.0)  # rad, where the ramp changes its direction


class Recording(NamedTuple):
    """Recorded log: `time` (n,) in s, `encoder` (n,) in counts, `current` (n,) in A."""

    time: Vector
    encoder: IntVector
    current: Vector


@kernel
def _servo(
    state: Vector,
    reference: Vector,
    feedforward: Vector,
    servo: Vector,
    p: Vector,
    step: float,
    encoder: IntVector,
    drive: Vector,
    advance: Advance,
) -> int:
    """Simulate a servo along `reference` (n, 2) of position and speed.

    Fills `encoder` and `drive` (n,); returns the engine's status. A command computed at one sample
    acts from the next sample on.
    """
    command, filtered = 0.0, 0.0
    last = math.floor(state[0] / step)
    for k in range(encoder.shape[0]):
        encoder[k] = math.floor(state[0] / step)
        drive[k] = state[2]
        filtered += (1.0 - math.exp(-servo[2] * servo[3])) * (
            (encoder[k] - last) * step / servo[3] - filtered
        )
        last = encoder[k]
        status = advance(state, command, p, servo[3])
        if status != 0:
            return int(status)
        error = reference[k, 0] - encoder[k] * step
        command = servo[0] * error + servo[1] * (reference[k, 1] - filtered) + feedforward[k]
    return 0


@kernel
def _ramp(
    state: Vector,
    ramp: Vector,
    turn: Vector,
    p: Vector,
    step: float,
    encoder: IntVector,
    drive: Vector,
    advance: Advance,
) -> int:
    """Simulate the ramps of figure 4.6; return the number of filled samples, or < 0.

    ramp: A per sample, counts, samples of pause, sample period.
    """
    command, direction, pause = 0.0, 1.0, 0.0
    last = math.floor(state[0] / step)
    for k in range(encoder.shape[0]):
        encoder[k] = math.floor(state[0] / step)
        drive[k] = state[2]
        status = advance(state, command, p, ramp[3])
        if status != 0:
            return -int(status)
        if pause > 0.0:
            pause -= 1.0
            last = encoder[k]
        elif abs(encoder[k] - last) >= ramp[1]:
            command, pause = 0.0, ramp[2]
            if direction > 0.0 and encoder[k] * step > turn[1]:
                direction = -1.0
            elif direction < 0.0 and encoder[k] * step < turn[0]:
                return k + 1
        else:
            command += direction * ramp[0]
    return int(encoder.shape[0])


def _check(status: int) -> None:
    if status != 0:
        raise RuntimeError(f"the simulation failed with status {status}")


def _start(generator: np.random.Generator, position: float, truth: AxisParameters) -> Vector:
    """Return the state at rest near `position`, with a random start within a count."""
    state = rest(position + truth.encoder_step * generator.random())
    return np.asarray(state, dtype=np.float64)


def _recording(encoder: IntVector, drive: Vector, generator: np.random.Generator) -> Recording:
    time = np.arange(encoder.size, dtype=np.float64) * PERIOD
    noise = NOISE * generator.standard_normal(drive.size)
    current: Vector = np.round(drive + noise, CURRENT_DIGITS)
    return Recording(time, encoder, current)


def play_reference(
    position: Vector,
    speed: Vector,
    feedforward: Vector,
    generator: np.random.Generator,
    truth: AxisParameters,
) -> Recording:
    encoder, drive = np.empty(position.size, dtype=np.int64), np.empty(position.size)
    state = _start(generator, float(position[0]), truth)
    reference = np.column_stack((position, speed))
    servo = np.array([*SERVO, PERIOD])
    _check(
        _servo(
            state,
            reference,
            feedforward,
            servo,
            truth.as_array(),
            truth.encoder_step,
            encoder,
            drive,
            advance_pointer(),
        )
    )
    return _recording(encoder, drive, generator)


def _half_sines(generator: np.random.Generator, repeated: bool) -> tuple[Vector, Vector, Vector]:
    """Return position, speed and acceleration (n,) of half sines up and down at each of SPEEDS.

    repeated: True if all strokes have the same reversal positions.
    """
    low, high = generator.uniform(*LOW_TURN), 0.0
    parts: list[tuple[Vector, Vector, Vector]] = []
    for top_speed in SPEEDS:
        for _ in range(
            round(SECONDS_EACH * top_speed / (2.0 * math.pi * 0.5 * (HIGH_TURN[0] - LOW_TURN[0])))
        ):
            if not (repeated and parts):
                high = generator.uniform(*HIGH_TURN)
            following = low if repeated else generator.uniform(*LOW_TURN)
            for start, end in ((low, high), (high, following)):
                samples = round(math.pi * 0.5 * abs(end - start) / (top_speed * PERIOD))
                rate = math.pi / (samples * PERIOD)
                angle, half = rate * PERIOD * np.arange(samples), 0.5 * (end - start)
                position = start + half * (1.0 - np.cos(angle))
                parts.append(
                    (position, half * rate * np.sin(angle), half * rate**2 * np.cos(angle))
                )
            low = following
    joined = [np.concatenate(column) for column in zip(*parts, strict=True)]
    return joined[0], joined[1], joined[2]


def sines(seed: int, truth: AxisParameters = TRUTH, repeated: bool = False) -> Recording:
    """Return half sines at several speeds, joined at the reversals.

    repeated: True for reversals at the same positions in all strokes.
    """
    generator = np.random.default_rng([seed, 1])
    position, speed, acceleration = _half_sines(generator, repeated)
    feedforward = (truth.inertia * acceleration + truth.viscous * speed) / truth.constant
    return play_reference(position, speed, feedforward, generator, truth)


def ramp(seed: int, truth: AxisParameters = TRUTH, rate: float = RAMP) -> Recording:
    """Return breakaway ramps over the travel and back; `rate` is in A/s."""
    generator = np.random.default_rng([seed, 2])
    size = round(400.0 / PERIOD)
    encoder, drive = np.empty(size, dtype=np.int64), np.empty(size)
    settings = np.array(
        [
            rate * PERIOD,
            MOVED_COUNTS * max(1.0, round(TRUTH.encoder_step / truth.encoder_step)),
            PAUSE / PERIOD,
            PERIOD,
        ]
    )
    used = _ramp(
        _start(generator, 1.0, truth),
        settings,
        np.array(TURN),
        truth.as_array(),
        truth.encoder_step,
        encoder,
        drive,
        advance_pointer(),
    )
    _check(min(used, 0))
    return _recording(encoder[:used], drive[:used], generator)


def steps(seed: int, truth: AxisParameters = TRUTH) -> Recording:
    """Return steps through a critically damped filter, so that the servo can follow them."""
    samples = round(STEP_SECONDS / PERIOD)
    target = np.repeat(STEPS, samples)
    position, speed = np.empty(target.size), np.empty(target.size)
    x, v = STEPS[0], 0.0
    for k, goal in enumerate(target):
        position[k], speed[k] = x, v
        v += PERIOD * (REFERENCE_SPEED**2 * (goal - x) - 2.0 * REFERENCE_SPEED * v)
        x += PERIOD * v
    return play_reference(
        position, speed, np.zeros(target.size), np.random.default_rng([seed, 3]), truth
    )


LOGS = {"sines": sines, "ramp": ramp, "steps": steps}


def csv(recording: Recording) -> str:
    """Return the text of a log: a header with units, then one row per sample."""
    rows = [f"{t:.3f},{n},{i:.{CURRENT_DIGITS}f}" for t, n, i in zip(*recording, strict=True)]
    return "\n".join(["time [s],encoder [count],current [A]", *rows, ""])


def main() -> None:
    """Write every log into sample_logs."""
    for name, make in LOGS.items():
        target = Path(__file__).parents[2] / f"sample_logs/{name}.csv"
        text = csv(make(SEED))
        target.write_text(text, newline="\n")
        print(
            f"{target.name}: {text.count(chr(10)) - 1} samples, {len(text) / 1e3:.0f} kB, seed "
            f"{SEED}"
        )


if __name__ == "__main__":
    main()
