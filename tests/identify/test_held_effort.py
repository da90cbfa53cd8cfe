"""An effort that was read too slowly is refused; what acted as it was logged is kept."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from frictool.documents.bench import Bench
from frictool.documents.registry import load
from frictool.identify.held_effort import LEAST_EFFECT, SLOW, held_effort, hold_of, interpolated
from frictool.identify.methods import IdentificationSettings
from frictool.identify.motion_record import MotionRecord, make_record
from frictool.typing import Vector
from studies.command_line import run
from tests.identify.arm import PERIOD, Arm, play, write_bench, write_log
from tests.support.command_line import refused

TIME = np.arange(12_000) * PERIOD
HOLD = 50  # samples: 20 Hz
RIGS = range(12)


def rig(seed: int) -> tuple[Arm, Vector, Vector]:
    """Return an arm of any size under a servo on two sines, its position (n,) and its effort
    (n,)."""
    draw = np.random.default_rng([seed, 21])
    coulomb, rate = draw.uniform(0.05, 1.0), draw.uniform(15.0, 30.0)
    arm = Arm(
        10.0 ** draw.uniform(-2.0, 0.0),
        draw.uniform(0.01, 0.3),
        coulomb,
        1.1 * coulomb,
        counts=int(10.0 ** draw.uniform(4.0, 5.5)),
    )
    command = draw.uniform(0.2, 0.6) * np.sin(
        draw.uniform(3.0, 8.0) * TIME + draw.uniform(0.0, 6.0)
    )
    command += draw.uniform(0.1, 0.3) * np.sin(draw.uniform(1.0, 12.0) * TIME)
    stiffness = arm.inertia * rate**2
    return arm, *play(arm, command, (stiffness, 0.2 * stiffness * rate, 1.6 * arm.inertia * rate))


def noisy(effort: Vector, seed: int, share: float = 0.01) -> Vector:
    """Return the effort (n,) with noise of this share of its standard deviation."""
    return effort + share * np.std(effort) * np.random.default_rng(seed).standard_normal(
        effort.size
    )


def held(effort: Vector, hold: int = HOLD) -> Vector:
    """Return the effort (n,) that is read every `hold` samples."""
    return np.asarray(effort[np.arange(effort.size) // hold * hold])


def record(arm: Arm, position: Vector, effort: Vector) -> MotionRecord:
    return make_record("log", np.arange(position.size) * PERIOD, position, effort, arm.step, 0.0)


def bench_of(folder: Path, arm: Arm) -> Bench:
    return load(write_bench(folder, arm), Bench)


@pytest.mark.parametrize("method", ["auto", "least-squares", "weak", "output-error"])
def test_a_current_that_is_read_at_20_hz_is_refused(tmp_path: Path, method: str) -> None:
    arm, position, effort = rig(3)
    log, bench = (
        write_log(tmp_path / "slow.csv", position, held(noisy(effort, 3))),
        write_bench(tmp_path, arm),
    )
    model = tmp_path / "model.yaml"
    result = run("identify", log, "--bench", bench, "--method", method, "-o", model)
    refused(
        result,
        1,
        "slow.csv: the effort changes every 50 ms, the position every 1 ms",
        "log the measured current as often as the position",
    )
    assert not model.exists()


def test_an_effort_that_was_held_for_50_ms_is_kept(tmp_path: Path) -> None:
    """A slow controller holds its effort: the log is right, and the inertia too."""
    arm, _, effort = rig(3)
    position, effort = play(arm, held(effort))
    log, bench = write_log(tmp_path / "held.csv", position, effort), write_bench(tmp_path, arm)
    result = run("identify", log, "--bench", bench, "--method", "least-squares", "--json")
    assert result.code == 0, result.stderr
    assert "the effort changes every" not in result.stderr
    assert json.loads(result.stdout)["parameters"]["inertia"]["value"] == pytest.approx(
        arm.inertia, rel=0.02
    )


def test_a_motion_that_does_not_tell_is_warned_of(tmp_path: Path) -> None:
    """A delay may be a combination of inertia and friction: the log is then not refused, and a
    warning gives both inertias."""
    arm, position, effort = rig(0)
    log, bench = (
        write_log(tmp_path / "sine.csv", position, held(noisy(effort, 0))),
        write_bench(tmp_path, arm),
    )
    result = run("identify", log, "--bench", bench, "--method", "least-squares")
    assert result.code == 0, result.stderr
    assert "warning: sine.csv: the effort changes every 50 ms" in result.stderr
    assert "does not show whether the effort acted as logged" in result.stderr


def test_slow_samples_are_found_and_rigs_that_hold_or_quantise_are_not_refused(
    tmp_path: Path,
) -> None:
    """Each rig with a slow sample is refused or warned of if that matters; none that is in order is
    refused."""
    refusals = 0
    for seed in RIGS:
        arm, position, effort = rig(seed)
        bench = bench_of(tmp_path, arm)
        slow = held_effort(
            record(arm, position, held(noisy(effort, seed))), bench, IdentificationSettings()
        )
        assert slow is not None
        assert slow.hold == HOLD
        assert slow.high > SLOW or slow.effect < LEAST_EFFECT
        refusals += slow.low > SLOW
        really, acting = play(arm, held(effort))
        kept = held_effort(
            record(arm, really, held(noisy(acting, seed))), bench, IdentificationSettings()
        )
        assert kept is None or kept.low < SLOW
        step = 0.05 * np.ptp(effort)
        assert (
            held_effort(
                record(arm, position, np.round(effort / step) * step),
                bench,
                IdentificationSettings(),
            )
            is None
        )
    assert refusals > len(RIGS) // 3


def test_the_hold_and_what_lies_between_updates() -> None:
    wave = np.sin(0.005 * np.arange(2_000))
    found = hold_of(held(wave, 10))
    assert found is not None
    assert found[0] == 10
    assert np.max(np.abs(interpolated(held(wave, 10), *found) - wave)[:1_990]) < 1e-3
    assert hold_of(wave) is None
    assert hold_of(np.round(50.0 * wave)) is None  # one count at a time: a coarse converter
    assert hold_of(np.zeros(400)) is None
