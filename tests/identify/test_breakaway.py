"""Breakaway ramps: the delay of the encoder is corrected, the backlash left out, what is not known
of the axis widens the interval."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import msgspec
import numpy as np
import pytest

from frictool.engine.axis_motion import advance
from frictool.identify.breakaway import onset_friction
from frictool.identify.breakaway.breakaway import Breakaway, breakaway
from frictool.identify.breakaway.onset_detection import find_onsets, is_ramp, why_unusable
from frictool.identify.fit_result import Interval, UnusableLogs
from frictool.identify.identification import identify_records
from frictool.identify.methods import IdentificationSettings
from frictool.identify.motion_record import MotionRecord, make_record
from frictool.plant.axis import AxisParameters, rest
from studies.rigs.identification_rigs import clutch, mass_bench, record
from studies.rigs.sample_logs import TRUTH, ramp, sines, steps

KNOWN = {
    name: Interval(getattr(TRUTH, name), getattr(TRUTH, name), getattr(TRUTH, name))
    for name in ("inertia", "viscous", "coulomb", "offset")
}


@pytest.fixture(scope="module")
def log() -> MotionRecord:
    return record(ramp(1))


def test_breakaway_of_a_known_axis_is_right_in_either_direction(log: MotionRecord) -> None:
    found = breakaway([log], clutch(), KNOWN, 0.95)
    assert found.interval.value == pytest.approx(TRUTH.breakaway, rel=2e-3)
    assert found.interval.low <= TRUTH.breakaway <= found.interval.high
    assert found.forward == pytest.approx(TRUTH.breakaway + TRUTH.offset, rel=3e-3)
    assert found.backward == pytest.approx(TRUTH.breakaway - TRUTH.offset, rel=3e-3)
    for side in (1.0, -1.0):  # the page draws these points beside the model's breakaway
        points = found.friction[found.direction == side]
        assert np.mean(points) == pytest.approx(TRUTH.breakaway, rel=3e-3)


def test_the_largest_effort_before_motion_is_seen_is_late(log: MotionRecord) -> None:
    """The thesis's own interval [u_max - xi, u_max] does not hold the breakaway: it is seen more
    than 7 steps of the ramp late."""
    found = breakaway([log], clutch(), KNOWN, 0.95)
    step_of_ramp = 25.0 * TRUTH.constant * 1e-3
    assert found.delay > 7.0 * step_of_ramp
    seen = np.mean([onset.level for onset in find_onsets(log, clutch())])
    assert seen > TRUTH.breakaway + 7.0 * step_of_ramp


def test_what_is_not_known_widens_the_interval(log: MotionRecord) -> None:
    bench = clutch()
    sharp = breakaway([log], bench, KNOWN, 0.95).interval
    vague = breakaway(
        [log], bench, {**KNOWN, "inertia": Interval(1.32e-5, 1.11e-5, 1.53e-5)}, 0.95
    ).interval
    blind = breakaway(
        [log], bench, {**KNOWN, "coulomb": Interval(0.099, 0.018, 0.18)}, 0.95
    ).interval
    assert sharp.half_width < vague.half_width < blind.half_width
    for interval in (vague, blind):
        assert interval.low < TRUTH.breakaway < interval.high


def test_onsets_inside_the_backlash_are_left_out(log: MotionRecord) -> None:
    levels = np.array([onset.level for onset in find_onsets(log, clutch())])
    assert levels.min() > 0.09  # 0.055 N m +- offset inside the backlash
    assert len(find_onsets(log, clutch())) > 60


def test_ramps_that_only_alternate_measure_nothing_beyond_the_backlash() -> None:
    """A ramp after a reversal begins in the open backlash; without backlash each ramp counts."""
    bench = clutch()
    period = 1e-3
    ramp_of = np.concatenate((np.linspace(0.0, 0.11, 1000), np.zeros(400)))
    step = 2.0 * np.pi / 56
    moved = np.concatenate((np.zeros(1000), np.arange(1, 46).repeat(5), np.full(175, 45))) * step
    effort = np.concatenate([side * ramp_of for side in (1.0, -1.0) * 6])
    position = np.concatenate([moved, moved[-1] - moved] * 6)
    log = make_record("ramps", period * np.arange(effort.size), position, effort, step, 0.0)
    assert not is_ramp(log, bench)
    assert find_onsets(log, bench) == []
    reason = why_unusable(log, bench)
    assert reason is not None
    assert "12 ramps, but 0 usable" in reason
    assert reason.endswith(
        "after a reversal, move the axis 3.22 rad (backlash) and stop it; then raise the effort "
        "evenly in the same direction"
    )
    rigid = msgspec.structs.replace(
        bench, mechanics=msgspec.structs.replace(bench.mechanics, backlash=None)
    )
    assert is_ramp(log, rigid)
    assert len(find_onsets(log, rigid)) == 12
    logs = [record(sines(1)), log]
    result = identify_records(logs, [], bench, "least-squares", IdentificationSettings())
    assert result.refused["breakaway"] == reason
    assert why_unusable(record(sines(1)), bench) is None


def test_one_direction_needs_the_offset(log: MotionRecord) -> None:
    half = slice(0, int(np.argmax(log.position)))
    forward = make_record(
        "forward", log.time[half], log.position[half], log.effort[half], log.resolution, log.lag
    )
    found = breakaway([forward], clutch(), KNOWN, 0.95)
    assert np.isnan(found.backward)
    assert found.interval.value == pytest.approx(TRUTH.breakaway, rel=3e-3)
    unknown = {**KNOWN, "offset": Interval(0.0, -0.01, 0.01)}
    assert breakaway([forward], clutch(), unknown, 0.95).interval.half_width > 0.01


def test_kinds_of_logs(log: MotionRecord) -> None:
    assert is_ramp(log, clutch())
    assert not is_ramp(record(sines(1)), clutch())
    assert not is_ramp(record(steps(1)), clutch())
    still = make_record(
        "still", np.arange(3000) * 1e-3, np.zeros(3000), np.zeros(3000), TRUTH.encoder_step, 0.003
    )
    assert not is_ramp(still, clutch())


def test_no_ramp_is_said() -> None:
    with pytest.raises(UnusableLogs, match="at least 5"):
        breakaway([record(steps(1))], clutch(), KNOWN, 0.95)


MASS = AxisParameters(inertia=0.1, viscous=0.4, coulomb=1.0, breakaway=1.5, encoder_step=1e-4)
RATE = 5.0  # N/s


def mass_log(
    mass: AxisParameters, counts: int, shape: Callable[[float], float] = lambda t: RATE * t
) -> MotionRecord:
    """Return ramps whose command [N] is a function of the time since the last ramp's end [s]; it
    falls to 0 when the encoder has moved by so many counts."""
    state, parameters = np.asarray(rest(0.3e-4)), mass.as_array()
    position, effort, before = np.empty(20_000), np.empty(20_000), 0
    since = -1  # samples since the end of the last ramp
    for k in range(20_000):
        count = int(np.floor(state[0] / 1e-4))
        ended = count >= before + counts
        since = -1 if ended else since + 1
        before = count if ended else before
        command = 0.0 if ended else shape(1e-3 * (since + 1))
        position[k], effort[k] = count * 1e-4, command
        assert advance(state, command, parameters, 1e-3) == 0
    return make_record("mass", np.arange(20_000) * 1e-3, position, effort, 1e-4, 0.0)


def mass_ramps(
    mass: AxisParameters,
    counts: int,
    folder: Path,
    shape: Callable[[float], float] = lambda t: RATE * t,
) -> Breakaway:
    """Return the breakaway of `mass_log`."""
    truth = {"inertia": 0.1, "viscous": 0.4, "coulomb": 1.0, "offset": 0.0}
    return breakaway(
        [mass_log(mass, counts, shape)],
        mass_bench(folder),
        {name: Interval(value, value, value) for name, value in truth.items()},
        0.95,
    )


def test_changes_after_the_ramp_was_taken_back_are_not_used(tmp_path: Path) -> None:
    sliding_on = mass_log(MASS._replace(coulomb=0.5), 1)
    onsets = find_onsets(sliding_on, mass_bench(tmp_path))
    assert {onset.time.size for onset in onsets} == {1}


@pytest.mark.parametrize("counts", [1, 4])
def test_figure_4_7_a_held_command_on_a_mass(tmp_path: Path, counts: int) -> None:
    """0.1 kg, breakaway 1.5 N, 0.005 N a sample, taken back to 0 when the encoder has moved by 1 or
    by 4 counts."""
    found = mass_ramps(MASS, counts, tmp_path)
    assert found.interval.low <= 1.5 <= found.interval.high
    assert found.interval.value == pytest.approx(1.5, abs=2.0 * 0.005)
    assert found.interval.high - found.interval.value < 6.0 * 0.005
    # the changes do not tell well whether friction falls at once: without a fall the ramp alone
    # moves the axis by the first count
    unseen = RATE * (6.0 * 0.1 * 1e-4 / RATE) ** (1.0 / 3.0)
    assert found.interval.half_width < 4.0 * 0.005 + 0.5 * unseen
    assert found.onsets > 40
    assert found.delay > 3.0 * 0.005  # the thesis: [u_max - xi, u_max]


@pytest.mark.parametrize(
    ("velocity", "counts"),
    [
        (0.02, 4),
        (0.2, 8),
        *(
            pytest.param(*one, marks=pytest.mark.accept)
            for one in ((0.02, 8), (0.05, 4), (0.05, 8), (0.2, 4))
        ),
    ],
)
def test_friction_that_falls_over_the_speed_is_within_the_interval(
    tmp_path: Path, velocity: float, counts: int
) -> None:
    """Friction that has not fallen when the motion is seen delays it further: taken for one that
    fell, the breakaway is too high."""
    falling = MASS._replace(laws=MASS.laws._replace(stribeck_velocity=velocity))
    found = mass_ramps(falling, counts, tmp_path).interval
    assert found.low <= 1.5 <= found.high
    assert found.low > 1.5 - 0.2


@pytest.mark.parametrize(
    "shape",
    [
        lambda t: 1.5 * t**2 / 0.16,
        lambda t: 1.7 * math.expm1(3.0 * t) / math.expm1(1.2),
        lambda t: 4.0 * t - 4.0 * min(max(t - 0.2, 0.0), 0.2),
        lambda t: 5.0 * t + 0.08 * math.sin(2.0 * math.pi * t / 0.15),
        lambda t: 1.8 * math.sin(2.5 * t),
    ],
    ids=["square", "exponential", "pause", "wavy", "levelling off"],
)
def test_a_ramp_turned_by_hand_is_a_line_only_near_its_end(
    tmp_path: Path, shape: Callable[[float], float]
) -> None:
    """A line through half of the ramp misses the effort at the breakaway by 5 to 20 %."""
    found = mass_ramps(MASS, 4, tmp_path, shape)
    assert found.onsets > 20
    assert found.interval.low <= 1.5 <= found.interval.high
    assert found.interval.value == pytest.approx(1.5, rel=0.02)


def test_five_breakaways_in_a_direction_are_enough_and_four_are_not(
    log: MotionRecord, monkeypatch: pytest.MonkeyPatch
) -> None:
    forward = [onset for onset in find_onsets(log, clutch()) if onset.direction > 0.0]
    monkeypatch.setattr(onset_friction, "find_onsets", lambda *_: forward[:5])
    assert breakaway([log], clutch(), KNOWN, 0.95).onsets == 5
    monkeypatch.setattr(onset_friction, "find_onsets", lambda *_: forward[:4])
    with pytest.raises(UnusableLogs, match="found 4 forward"):
        breakaway([log], clutch(), KNOWN, 0.95)


def test_the_place_of_rest_is_uncertain_to_either_side(tmp_path: Path) -> None:
    """One change does not tell where in its count the axis rested: the breakaway may be higher as
    well as lower."""
    found = mass_ramps(MASS, 1, tmp_path).interval
    assert found.high - found.value > 2.0 * RATE * 1e-3
    assert found.value - found.low > 2.0 * RATE * 1e-3
