"""Motion with the drive off: friction relative to the inertia, or the true reason of a refusal."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

from frictool.typing import Vector
from studies.command_line import run
from tests.identify.arm import PERIOD, Arm, play, write_bench, write_log
from tests.support.command_line import refused

ARM = Arm(inertia=2e-3, viscous=4e-3, coulomb=0.03, breakaway=0.03, counts=40_000)
RATES = ARM.viscous / ARM.inertia, ARM.coulomb / ARM.inertia  # 1/s, rad/s^2


def coasting(start: float, seconds: float = 2.0) -> Vector:
    """Counted position (n,) in rad of an axis that coasts from `start` rad/s, in closed form."""
    viscous, coulomb = RATES
    time = np.arange(round(seconds / PERIOD)) * PERIOD
    speed, side = abs(start), math.copysign(1.0, start)
    stop = math.log1p(speed * viscous / coulomb) / viscous
    moving = np.minimum(time, stop)
    fallen = (speed + coulomb / viscous) * (1.0 - np.exp(-viscous * moving)) / viscous
    position = side * (fallen - coulomb / viscous * moving)
    return np.asarray(np.floor(position / ARM.step + 0.37) * ARM.step)


def swinging(rate: float, pendulum: bool) -> Vector:
    """The counted position (n,) in rad of an axis released at 1.2 rad, by Runge and Kutta's method.

    `rate` is the spring or the weight over the inertia, 1/s^2.
    """
    viscous, coulomb = RATES
    x, v, side, h = 1.2, 0.0, -1.0, PERIOD / 8

    def slope(x: float, v: float) -> float:
        return -rate * (math.sin(x) if pendulum else x) - viscous * v - coulomb * side

    out = np.empty(4000)
    for k in range(out.size):
        out[k] = math.floor(x / ARM.step + 0.37) * ARM.step
        for _ in range(8):
            a = slope(x, v)
            b = slope(x + 0.5 * h * v, v + 0.5 * h * a)
            c = slope(x + 0.5 * h * (v + 0.5 * h * a), v + 0.5 * h * b)
            d = slope(x + h * (v + 0.5 * h * b), v + h * c)
            x += h * v + h * h * (a + b + c) / 6.0
            after = v + h * (a + 2.0 * b + 2.0 * c + d) / 6.0
            if after * side < 0.0:  # the axis has stopped
                load = rate * (math.sin(x) if pendulum else x)
                after = 0.0
                side = 0.0 if abs(load) <= coulomb else -math.copysign(1.0, load)
            v = after
            if side == 0.0:
                break
    return out


def noise(size: int, seed: int) -> Vector:
    """Noise (n,) of a current sensor in N m, without any current."""
    return 1e-3 * np.random.default_rng(seed).standard_normal(size)


def identified(folder: Path, positions: list[Vector], *options: str, load: str = "") -> dict:
    """Identify from the positions of coasting axes; return the JSON."""
    logs = [
        write_log(folder / f"coast_{k}.csv", one, noise(one.size, k))
        for k, one in enumerate(positions)
    ]
    bench = write_bench(folder, ARM, load)
    result = run(
        "identify", *logs, "--bench", bench, "-o", folder / "model.yaml", "--json", *options
    )
    assert result.code == 0, result.stderr
    return json.loads(result.stdout)


def test_friction_is_scaled_by_the_inertia_of_the_bench(tmp_path: Path) -> None:
    """Four coast-downs: each parameter is the ratio times the bench's inertia, which is 0.4 to 2
    times the true one, and so is the interval."""
    facts = identified(tmp_path, [coasting(one) for one in (40.0, -35.0, 25.0, -45.0)])
    for name, true in (("viscous", ARM.viscous), ("coulomb", ARM.coulomb)):
        one = facts["parameters"][name]
        assert one["value"] == pytest.approx(true, rel=0.01)
        assert one["low"] == pytest.approx(0.4 * true, rel=0.02)
        assert one["high"] == pytest.approx(2.0 * true, rel=0.02)
    assert "inertia" not in facts["parameters"]
    assert "the drive was off" in facts["not_identified"]["inertia"]
    assert facts["force_error"] is None


def test_the_ratios_contain_the_truth(tmp_path: Path) -> None:
    """The ratios to the inertia need no bench; the text prints them with intervals."""
    facts = identified(tmp_path, [coasting(one) for one in (40.0, -35.0, 25.0, -45.0)])
    words = facts["not_identified"]["inertia"].split()
    for name, true in zip(("viscous", "coulomb"), RATES, strict=True):
        at = words.index(name)
        low, high = (float(words[at + k].strip("[],")) for k in (3, 4))
        assert low <= true <= high
        assert high - low < 0.02 * true


@pytest.mark.parametrize(("pendulum", "term"), [(False, "spring"), (True, "gravity")])
def test_a_free_oscillation_needs_the_load_that_drives_it(
    tmp_path: Path, pendulum: bool, term: str
) -> None:
    """Declared, spring and weight come out relative to the inertia; undeclared, the refusal says
    what to declare."""
    rate = 400.0
    position = swinging(rate, pendulum)
    log = write_log(tmp_path / "free.csv", position, noise(position.size, 3))
    bench = write_bench(tmp_path, ARM)
    refused(
        run("identify", log, "--bench", bench, "-o", tmp_path / "none.yaml"),
        1,
        "the drive was off",
        "declare load.terms: [offset, spring] or [offset, gravity]",
    )
    facts = identified(tmp_path, [position], load=f"load: {{terms: [offset, {term}]}}\n")
    law = facts["laws"]["load"]
    strength = law["gravity"]["sine"] if pendulum else law["stiffness"]
    assert strength["value"] == pytest.approx(rate * ARM.inertia, rel=5e-3)
    assert facts["parameters"]["coulomb"]["value"] == pytest.approx(ARM.coulomb, rel=0.02)


def test_an_axis_that_speeds_up_with_the_drive_off_is_moved_by_something_else(
    tmp_path: Path,
) -> None:
    """Coast-downs backward in time have negative friction."""
    logs = [
        write_log(tmp_path / f"{k}.csv", coasting(one)[::-1], noise(2000, k))
        for k, one in enumerate((40.0, -35.0, 25.0, -45.0))
    ]
    refused(
        run("identify", *logs, "--bench", write_bench(tmp_path, ARM)),
        1,
        "the drive was off",
        "negative",
        "such as a hand",
    )


def test_one_coast_down_separates_no_offset(tmp_path: Path) -> None:
    """In one direction Coulomb friction and offset are one number: viscous friction remains. The
    noise of the current does not look like a reversed sign."""
    facts = identified(tmp_path, [coasting(40.0)])
    assert facts["parameters"].keys() == {"viscous"}
    assert "state mechanics.offset" in facts["not_identified"]["coulomb"]


def test_coast_downs_beside_a_driven_log_use_its_inertia(tmp_path: Path) -> None:
    """A driven log gives the inertia, and the coast-downs sharpen the friction."""
    time = np.arange(6_000) * PERIOD
    command = 0.2 * np.sin(9.0 * time) + 0.12 * np.sin(5.1 * time)
    position, effort = play(ARM, command)
    log = write_log(tmp_path / "driven.csv", position, effort + noise(effort.size, 9))
    coasts = [
        write_log(tmp_path / f"coast_{k}.csv", one, noise(one.size, k))
        for k, one in enumerate([coasting(40.0), coasting(-35.0)])
    ]
    bench = write_bench(tmp_path, ARM)
    model = tmp_path / "model.yaml"
    result = run("identify", log, *coasts, "--bench", bench, "-o", model, "--json")
    assert result.code == 0, result.stderr
    facts = json.loads(result.stdout)
    for name in ("inertia", "viscous", "coulomb"):
        assert facts["parameters"][name]["value"] == pytest.approx(getattr(ARM, name), rel=0.01)
