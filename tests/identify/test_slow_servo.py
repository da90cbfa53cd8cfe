"""Slow servo runs on coarse encoders: the derivative's pulse at each count makes the sampled work
negative, and the signs are right."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from frictool.engine.axis_motion import advance
from frictool.identify.estimators.least_squares import least_squares
from frictool.identify.methods import IdentificationSettings
from frictool.identify.motion_record import MotionRecord, make_record
from frictool.identify.orientation import negative_effort, stroke_efforts, stroke_friction
from frictool.logs.quality.sign_check import CLEAR, net_work
from frictool.plant.axis import AxisParameters, rest
from studies.command_line import run
from tests.support.linear_axis import PERIOD
from tests.support.loaded_axis import rotary_bench

SAMPLES, RIGS = 12_000, 10
BENCH = """\
format: bench/1
name: servo
axis: rotary
sample_period_s: 0.001
encoder: {{counts_per_revolution: {counts}}}
actuator: {{drive: current, constant: {{value: 1, unit: N m/A}}, limit: {{value: 10, unit: A}}}}
mechanics:
  inertia: {{value: 2e-5, low: 1.9e-5, high: 2.1e-5, unit: kg m^2}}
  viscous: {viscous}
  coulomb: {coulomb}
columns:
  time: {{column: time, unit: s}}
  position: {{column: encoder, unit: count}}
  effort: {{column: torque, unit: N m}}
"""


def slow_servo(seed: int) -> tuple[MotionRecord, float]:
    """Return the log of a position servo with derivative action on raw counts, along a slow sine,
    and the Coulomb friction in N m."""
    draw = np.random.default_rng([seed, 77])
    inertia, coulomb = 10.0 ** draw.uniform(-5.5, -4.0), 10.0 ** draw.uniform(-2.0, -0.5)
    count = 2.0 * math.pi / round(10.0 ** draw.uniform(1.6, 3.0))
    axis = AxisParameters(
        inertia=inertia,
        viscous=1e-4,
        coulomb=coulomb,
        breakaway=1.1 * coulomb,
        offset=draw.uniform(-0.2, 0.2) * coulomb,
    ).as_array()
    stiffness = (
        inertia * (2.0 * math.pi * 10.0 ** draw.uniform(0.5, 1.3)) ** 2 + coulomb / count / 3.0
    )
    damping, most = 2.0 * math.sqrt(inertia * stiffness), draw.uniform(3.0, 15.0) * coulomb
    swing, omega = count * 10.0 ** draw.uniform(1.0, 1.7), 2.0 * math.pi * draw.uniform(0.3, 0.6)
    state, position, effort = rest(0.5 * count), np.empty(SAMPLES), np.empty(SAMPLES)
    before = math.floor(state[0] / count) * count
    for k in range(SAMPLES):
        position[k] = math.floor(state[0] / count) * count
        reference = swing * (1.0 - math.cos(omega * k * PERIOD))
        effort[k] = min(
            max(
                stiffness * (reference - position[k]) - damping * (position[k] - before) / PERIOD,
                -most,
            ),
            most,
        )
        before = position[k]
        assert advance(state, effort[k], axis, PERIOD) == 0
    return make_record("servo", np.arange(SAMPLES) * PERIOD, position, effort, count, 0.0), coulomb


def test_the_mean_effort_of_strokes_tells_the_sign_where_the_sampled_work_does_not() -> None:
    misled = 0
    for seed in range(RIGS):
        record, coulomb = slow_servo(seed)
        work, friction = (
            net_work(record.position, record.effort),
            stroke_friction(*stroke_efforts(record), 0.95),
        )
        misled += work is not None and work <= -CLEAR
        assert friction is not None
        assert 0.5 * coulomb < friction.value < 2.0 * coulomb
        assert negative_effort([record], rotary_bench(None), 0.95) is None
        assert (
            negative_effort([replace(record, effort=-record.effort)], rotary_bench(None), 0.95)
            is not None
        )
    assert misled >= RIGS // 2


def written(folder: Path, seed: int, sign: int) -> list[Path | str]:
    """Write bench and log of a slow servo whose effort has this sign; return both as arguments of a
    command.

    The bench knows each parameter better than the log tells it, and agrees with the log, so that
    nothing is identified.
    """
    record, _ = slow_servo(seed)
    count = record.resolution
    bench, log = folder / "bench.yaml", folder / "log.csv"
    found = least_squares([record], rotary_bench(None), IdentificationSettings()).parameters
    units = {"viscous": "N m s/rad", "coulomb": "N m"}
    values = {name: max(found[name].value, 1e-9) for name in units}
    known = {
        name: f"{{value: {value:.9g}, low: {0.9999 * value:.9g}, high: {1.0001 * value:.9g}, "
        f"unit: {units[name]}}}"
        for name, value in values.items()
    }
    bench.write_text(BENCH.format(counts=round(2.0 * math.pi / count), **known))
    rows = np.column_stack((record.time, np.rint(record.position / count), sign * record.effort))
    np.savetxt(log, rows, delimiter=",", header="time,encoder,torque", comments="", fmt="%.10g")
    return [log, "--bench", bench]


@pytest.mark.parametrize("sign", [1, -1])
def test_the_command_blames_the_sign_of_a_reversed_slow_run_only(tmp_path: Path, sign: int) -> None:
    target = tmp_path / "model.yaml"
    result = run("identify", *written(tmp_path, 1, sign), "--method", "least-squares", "-o", target)
    assert result.code != 0
    assert ("position and drive have opposite signs" in result.stderr) == (sign < 0), result.stderr
    assert not target.exists()


@pytest.mark.parametrize(
    ("seed", "sign", "blamed"),
    [
        pytest.param(0, 1, False, marks=pytest.mark.accept),
        pytest.param(1, 1, False, marks=pytest.mark.accept),
        (2, -1, False),
        pytest.param(3, 1, False, marks=pytest.mark.accept),
        (3, -1, True),
        (6, -1, True),
    ],
)
def test_info_names_a_reversed_sign_only_where_the_log_decides_it(
    seed: int, sign: int, blamed: bool, tmp_path: Path
) -> None:
    """Work of the samples and mean effort of the strokes have to agree; seeds 0 to 2 are logs in
    which they do not."""
    result = run("info", *written(tmp_path, seed, sign))
    assert result.code == 0, result.stderr
    assert ("the effort takes energy from the axis" in result.stdout + result.stderr) == blamed
