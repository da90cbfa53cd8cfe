"""`info` with a bench offers exactly the methods with which `identify` accepts the log."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from frictool.documents.bench import Bench
from frictool.errors import FrictoolError
from frictool.identify.from_logs import identify
from frictool.identify.info import info
from frictool.identify.methods import METHODS, IdentificationRequest
from frictool.identify.motion_record import MotionRecord
from frictool.logs.log import Log, Stream
from studies.command_line import run
from studies.rigs.curve_logs import constant_speeds, stribeck_axis
from studies.rigs.identification_rigs import clutch, record
from studies.rigs.sample_logs import ramp, sines, steps
from tests.support.command_line import refused
from tests.support.example_logs import as_bytes


def log_of(source: MotionRecord, bench: Bench) -> Log:
    """Return the canonical log of a record; the drive signal follows from the bench."""
    drive = bench.actuator.drive
    signals = {
        "position": source.position,
        drive: source.effort / bench.actuator.constant.value,
        "effort": source.effort,
    }
    rotary = bench.axis == "rotary"
    units = {
        "position": "rad" if rotary else "m",
        drive: "A" if drive == "current" else "V",
        "effort": "N m" if rotary else "N",
    }
    return Log((Stream("/axis", source.time, signals, units),), source="log.mcap")


def drive_off() -> MotionRecord:
    """Return the motion of a test whose current was measured with the amplifier off."""
    one = record(sines(1)).part(slice(0, 8_000))
    noise = 1e-4 * np.random.default_rng(2).standard_normal(one.effort.size)
    return replace(one, effort=noise)


LOGS = {
    "sines": lambda: record(sines(1)),
    "steps": lambda: record(steps(1)),
    "ramps": lambda: record(ramp(1)),
    "speeds": lambda: constant_speeds(1, stribeck_axis()),
    "drive off": drive_off,
}


@cache
def offered_for(name: str) -> dict[str, str | None]:
    """Return for each method why a log does not suit it, or None."""
    methods: dict[str, str | None] = info(log_of(LOGS[name](), clutch()), clutch()).facts["methods"]
    return methods


SHORT = ("steps", "drive off")  # the other logs take longer


@pytest.mark.parametrize(
    "name",
    [name if name in SHORT else pytest.param(name, marks=pytest.mark.accept) for name in LOGS],
)
def test_a_method_is_offered_if_identify_accepts_the_log(name: str) -> None:
    bench = clutch()
    log = log_of(LOGS[name](), bench)
    offered = offered_for(name)
    for method in METHODS:
        try:
            identify([log], bench, IdentificationRequest(method))
        except FrictoolError:
            assert offered[method] is not None, method
        else:
            ramps = name == "ramps"  # the breakaway is identified by every method
            assert offered[method] is None or ramps, (method, offered[method])
    assert (offered["breakaway"] is None) is (name == "ramps")


def test_a_log_whose_drive_was_off_is_offered_no_method_and_told_why() -> None:
    methods = offered_for("drive off")
    assert all("the drive was off" in str(methods[name]) for name in ("auto", "least-squares"))


def test_opposite_signs_are_the_reason_for_every_method() -> None:
    bench, one = clutch(), record(sines(1))
    methods = info(log_of(replace(one, effort=-one.effort), bench), bench).facts["methods"]
    assert all("opposite signs" in str(methods[name]) for name in ("auto", "weak", "output-error"))


def test_speeds_suit_the_curve_and_sines_do_not(tmp_path: Path) -> None:
    bench = clutch()
    speeds, strokes = LOGS["speeds"](), LOGS["sines"]()
    assert info(log_of(speeds, bench)).facts["methods"]["stribeck-curve"] is None
    assert "runs at a constant speed" in str(
        info(log_of(strokes, bench)).facts["methods"]["stribeck-curve"]
    )
    path = tmp_path / "sines.mcap"
    path.write_bytes(as_bytes(log_of(strokes, bench)))
    call = ("identify", path, "--bench", Path("configs/clutch/bench.yaml"), "--method")
    refused(run(*call, "stribeck-curve"), 1, "runs at a constant speed")
    refused(run(*call, "friction-force"), 1, "reverses, but friction-force needs a stroke")
