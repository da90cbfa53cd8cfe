"""An effort that a gravity compensation commands while a hand moves the arm is refused as such."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from studies.command_line import run
from tests.identify.arm import PERIOD, Arm, play, write_bench, write_log

GRAVITY = "load: {terms: [offset, gravity]}\n"
ARM = Arm(inertia=0.17, viscous=0.02, coulomb=0.1, breakaway=0.12, gravity=3.3, counts=2048)
TIME = np.arange(12_000) * PERIOD


def identified(folder: Path, position: np.ndarray, effort: np.ndarray):
    """Identify from a log with the noise of a current sensor."""
    noise = 0.01 * np.random.default_rng(4).standard_normal(TIME.size)
    log = write_log(folder / "moved.csv", position, effort + noise)
    bench = write_bench(folder, ARM, GRAVITY)
    return run("identify", log, "--bench", bench, "-o", folder / "model.yaml")


def test_a_gravity_compensation_is_refused_as_such(tmp_path: Path) -> None:
    """The hand's effort is missing in the log, which shows neither inertia nor friction."""
    position = sum(
        a * np.sin(f * TIME + p) for a, f, p in ((1.1, 2.1, 0.3), (0.6, 3.7, 2.0), (0.3, 5.9, 1.0))
    )
    position = np.floor(position / ARM.step) * ARM.step
    result = identified(tmp_path, position, ARM.gravity * np.sin(position))
    assert result.code in (1, 4)
    assert "gravity compensation" in result.stderr
    assert not (tmp_path / "model.yaml").exists()


def test_a_driven_arm_in_gravity_is_not(tmp_path: Path) -> None:
    """The same arm under a servo gives its inertia and friction."""
    command = 0.8 * np.sin(5.0 * TIME) + 0.4 * np.sin(8.3 * TIME)
    result = identified(tmp_path, *play(ARM, command, (40.0, 0.0, 3.0)))
    assert result.code == 0, result.stderr
    assert "gravity compensation" not in result.stderr
