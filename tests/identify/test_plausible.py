"""Records that cannot be of the bench's axis, and counts that were skipped."""

from __future__ import annotations

import re
from dataclasses import replace

import msgspec
import numpy as np
import pytest

from frictool.documents.bench import Bench
from frictool.documents.quantity import Quantity
from frictool.errors import LogError
from frictool.identify.coast_down import drive_was_off
from frictool.identify.fit_result import Interval
from frictool.identify.fit_warnings import contradiction_warnings
from frictool.identify.force_error import motion_rows
from frictool.identify.identification import NothingIdentified, identify_records
from frictool.identify.methods import REFERENCE, IdentificationSettings
from frictool.identify.motion_record import MotionRecord, make_record
from frictool.identify.record_plausibility import implausible
from studies.rigs.identification_rigs import clutch, record
from studies.rigs.sample_logs import TRUTH, sines, steps
from tests.support.linear_axis import linear_axis, linear_bench


@pytest.fixture(scope="module")
def log() -> MotionRecord:
    return record(sines(1))


def without(bench: Bench, *names: str) -> Bench:
    return msgspec.structs.replace(
        bench, mechanics=msgspec.structs.replace(bench.mechanics, **dict.fromkeys(names))
    )


def test_the_clutch_is_plausible(log: MotionRecord) -> None:
    assert implausible(log, clutch()) == []
    assert implausible(record(steps(1)), clutch()) == []


@pytest.mark.parametrize("value", [1e300, -1e300, 1e17])
def test_a_position_that_no_encoder_shows(log: MotionRecord, value: float) -> None:
    position = log.position.copy()
    position[500] = value
    with pytest.raises(
        LogError, match=r"at 0\.5 s; allowed: a position of at most 2\^53 encoder counts"
    ):
        implausible(replace(log, position=position), without(clutch(), "travel", "top_speed"))


def test_a_position_beyond_any_travel(log: MotionRecord) -> None:
    position = log.position.copy()
    position[700:] += 700.0
    with pytest.raises(
        LogError, match=r"at 0\.7 s; allowed: a position within 10 times the travel \(630 rad\)"
    ) as raised:
        implausible(
            replace(
                log,
                position=position[:1200],
                effort=log.effort[:1200],
                time=log.time[:1200],
                piece=log.piece[:1200],
            ),
            clutch(),
        )
    assert raised.value.exit_code == 3
    assert (
        implausible(replace(log, position=log.position + 1e6), clutch()) == []
    )  # where zero lies is nobody's business


def test_an_effort_that_no_actuator_gives(log: MotionRecord) -> None:
    effort = log.effort.copy()
    effort[300] = -1e200
    with pytest.raises(
        LogError, match=r"-1e\+200 N m at 0\.3 s; allowed: at most 10 times the effort at"
    ):
        implausible(replace(log, effort=effort), clutch())


@pytest.mark.parametrize("bits", [8, 9])
def test_a_counter_that_wraps_is_said_with_its_bits(log: MotionRecord, bits: int) -> None:
    counts = np.rint(log.position / TRUTH.encoder_step).astype(np.int64)
    wrapped = replace(log, position=((counts + 100) % 2**bits) * TRUTH.encoder_step)
    jumps = np.flatnonzero(np.abs(np.diff(wrapped.position)) > 10.0)
    assert jumps.size > 10
    (warning,) = implausible(wrapped, clutch())
    assert f"jumps {jumps.size} times, first at {log.time[jumps[0] + 1]:.6g} s" in warning
    assert f"set encoder.wrap_bits, here to {bits}" in warning
    assert implausible(wrapped, without(clutch(), "top_speed")) == []


def test_counts_that_are_lost_are_no_wrap(log: MotionRecord) -> None:
    position = log.position.copy()
    position[900:] += 40.0 * TRUTH.encoder_step
    (warning,) = implausible(replace(log, position=position), clutch())
    assert "jumps once, at 0.9 s" in warning
    assert "are counts lost?" in warning


def test_a_motion_above_the_top_speed_is_no_jump() -> None:
    """Successive steps of a fast motion are equal; those before and after a jump are shorter."""
    slow = msgspec.structs.replace(clutch().mechanics, top_speed=Quantity(15.0, unit="rad/s"))
    bench = msgspec.structs.replace(clutch(), mechanics=slow)
    time = 1e-3 * np.arange(2000)
    position, effort = 25.0 + 5.0 * np.sin(8.0 * time), np.sin(8.0 * time)
    fast = make_record("fast", time, position, effort, resolution=1e-3, lag=0.0)
    (warning,) = implausible(fast, bench)
    assert "the speed reaches 2.67 times mechanics.top_speed" in warning
    position[900:] += 0.05
    (warning,) = implausible(replace(fast, position=position), bench)
    assert "jumps once, at 0.9 s" in warning


def test_a_gap_in_time_is_no_jump(log: MotionRecord) -> None:
    position, piece = log.position.copy(), log.piece.copy()
    position[900:] += 40.0 * TRUTH.encoder_step
    piece[900:] = 1
    assert implausible(replace(log, position=position, piece=piece), clutch()) == []


def test_a_unit_that_makes_the_effort_1000_times_too_large_is_named(log: MotionRecord) -> None:
    """With mA read as A, inertia and friction are all wrong by one factor."""
    bench = clutch()
    limit = Quantity(1e3 * bench.actuator.limit.value, unit="A")
    actuator = msgspec.structs.replace(bench.actuator, limit=limit)
    result = identify_records(
        [replace(log, effort=1e3 * log.effort)],
        [],
        msgspec.structs.replace(bench, actuator=actuator),
        REFERENCE,
        IdentificationSettings(),
    )
    assert (
        "times the bench's values: check the unit in columns.current (mA or A)"
        in (result.warnings[0])
    )
    assert result.identified["coulomb"].value == pytest.approx(1e3 * TRUTH.coulomb, rel=0.1)


@pytest.mark.parametrize(
    ("seed", "factor"),
    [
        (1, 0.08),
        (2, 8.0),
        *(pytest.param(*one, marks=pytest.mark.accept) for one in ((1, 8.0), (2, 0.08))),
    ],
)
def test_a_wrong_constant_is_named_with_its_likely_value(seed: int, factor: float) -> None:
    truth, log = linear_axis(seed)
    hint = first_warning(replace(log, effort=factor * log.effort))
    assert hint.startswith("inertia, viscous, coulomb are all ")
    likely = re.search(r"actuator.constant is probably (\S+) N/A \(found: 20\)", hint)
    assert likely is not None
    # the bench's ranges contain the true values, and limit the factor
    assert 0.4 < float(likely[1]) * factor / truth.constant < 2.5


@pytest.mark.parametrize("gear", [0.05, 20.0])
def test_the_other_side_of_a_gear_is_named_with_its_ratio(gear: float) -> None:
    _, log = linear_axis(1)
    hint = first_warning(replace(log, position=gear * log.position, effort=log.effort / gear))
    found = re.search(r"by a gear ratio of (\S+) \(inertia and viscous by its square\)", hint)
    assert found is not None
    assert float(found[1]) == pytest.approx(max(gear, 1.0 / gear), rel=0.5)


def test_parameters_that_no_single_factor_explains_get_no_hint() -> None:
    def around(value: float) -> Interval:
        return Interval(value, 0.98 * value, 1.02 * value)

    other = {"inertia": around(50.0), "viscous": around(30.0), "coulomb": around(1.0)}
    assert len(contradiction_warnings(other, linear_bench())) == 3
    heavier = {"inertia": around(50.0), "viscous": around(120.0), "coulomb": around(9.0)}
    assert len(contradiction_warnings(heavier, linear_bench())) == 2


def first_warning(log: MotionRecord) -> str:
    result = identify_records([log], [], linear_bench(), REFERENCE, IdentificationSettings())
    return result.warnings[0]


def test_a_unit_that_makes_the_effort_1000_times_too_small_is_named(log: MotionRecord) -> None:
    """Such an effort is no drive that was off: it follows the motion."""
    weak = replace(log, effort=1e-3 * log.effort)
    assert not drive_was_off(motion_rows([weak], clutch()), clutch())
    result = identify_records([weak], [], clutch(), REFERENCE, IdentificationSettings())
    assert any("0.001 times the bench's values: check the unit" in one for one in result.warnings)
    known = IdentificationSettings(fixed={"inertia": Interval(1.3e-5, 1.1e-5, 1.5e-5)})
    with pytest.raises(NothingIdentified, match=r"far too small .* check the unit in columns.curr"):
        identify_records([weak], [], clutch(), REFERENCE, known)


def test_a_parameter_that_alone_contradicts_the_bench_says_nothing_of_a_unit(
    log: MotionRecord,
) -> None:
    bench = clutch()
    wrong = msgspec.structs.replace(
        bench.mechanics, coulomb=Quantity(500.0, 400.0, 600.0, unit="N m")
    )
    bench = msgspec.structs.replace(bench, mechanics=wrong)
    result = identify_records([log], [], bench, REFERENCE, IdentificationSettings())
    assert any(text.startswith("coulomb: the log's interval") for text in result.warnings)
    assert not any("check the unit" in text for text in result.warnings)
