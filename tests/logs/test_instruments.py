"""Several instruments at one rig: each by its own columns, layout and clock; a clock's offset is
given or found, with its interval."""

from __future__ import annotations

from pathlib import Path

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from frictool.documents.bench import Bench, ClockEstimate, Column, Instrument, Layout
from frictool.documents.quantity import Quantity
from frictool.documents.registry import load
from frictool.errors import LogError
from frictool.logs.clocks.alignment import CLOCK_OFFSET
from frictool.logs.clocks.clock_offset import clock_offset
from frictool.logs.log import Log
from frictool.logs.log_assembly import assemble, assemble_log
from tests.support.example_logs import ROOT, bench, measured

SECONDS = 2.0


def motion(time: np.ndarray) -> np.ndarray:
    """A stroke and back, smooth, that resembles itself at no other time."""
    return np.exp(-(((time - 0.7) / 0.12) ** 2)) - 0.6 * np.exp(-(((time - 1.2) / 0.2) ** 2))


def rig(**force: object) -> Bench:
    columns = {"time": Column("t", "s"), "velocity": Column("v", "rad/s")}
    drive = Instrument("drive*.csv", columns)
    sensor = Instrument(
        "force*.csv",
        {"time": Column(1, "ms"), "effort": Column(2, "N m", scale=-200.0, zero_first_samples=10)},
        layout=Layout(header_line=0),
        sample_period_s=0.0005,
        **force,
    )
    return msgspec.structs.replace(bench({}), instruments={"drive": drive, "force": sensor})


def files(folder: Path, ahead: float, noise: float = 0.0) -> list[Path]:
    rng = np.random.default_rng(4)
    t, u = np.arange(0.0, SECONDS, 1e-3), np.arange(0.0, SECONDS, 5e-4)
    x, y = motion(t), motion(u - ahead) / -200.0 + 0.3
    drive, force = folder / "drive_1.csv", folder / "force_1.csv"
    drive.write_text(
        "t [s],v [rad/s]\n"
        + "".join(
            f"{a:.4f},{b:.9f}\n"
            for a, b in zip(t, x + noise * rng.normal(size=x.size), strict=True)
        )
    )
    force.write_text(
        ";\n".join(
            f"{a * 1e3:.2f};{b:.9f}"
            for a, b in zip(u, y + noise / 200 * rng.normal(size=y.size), strict=True)
        )
        + ";\n"
    )
    return [drive, force]


def read(paths: list[Path], rig: Bench) -> Log:
    return assemble_log(assemble(paths, rig))


def test_each_file_is_read_as_its_instrument_s(tmp_path: Path):
    log = read(files(tmp_path, 0.0), rig())
    assert [stream.topic for stream in log.streams] == ["/axis", "/axis/force"]
    assert log.streams[1].period == pytest.approx(5e-4)
    effort = log.streams[1].signals["effort"]
    assert abs(effort[:10].mean()) < 1e-6
    assert effort == pytest.approx(motion(log.streams[1].time), abs=1e-4)
    assert CLOCK_OFFSET not in log.metadata


def test_a_clock_that_is_ahead_is_put_back(tmp_path: Path):
    log = read(files(tmp_path, 0.004), rig(clock_offset=Quantity(0.004, unit="s")))
    force = log.streams[1]
    assert force.time[0] == pytest.approx(-0.004)
    assert force.signals["effort"] == pytest.approx(motion(force.time), abs=1e-4)
    assert log.metadata[CLOCK_OFFSET] == {"/axis/force": "0.004 s, given"}


def test_the_offset_is_found_and_kept_with_its_interval(tmp_path: Path):
    estimate = ClockEstimate("effort", "velocity", Quantity(0.1, unit="s"))
    log = read(files(tmp_path, 0.0123, noise=0.01), rig(clock_estimate=estimate))
    assert log.streams[1].time[0] == pytest.approx(-0.0123, abs=2e-4)
    assert log.metadata[CLOCK_OFFSET]["/axis/force"].endswith(
        "s (95 %), effort against /axis.velocity"
    )


REFUSED = {
    "another channel": (
        ClockEstimate("effort", "position", Quantity(0.1)),
        "drive_1.csv has no position; it has velocity",
    ),
    "another quantity": (
        ClockEstimate("current", "velocity", Quantity(0.1)),
        "force_1.csv has no current",
    ),
    "too little": (
        ClockEstimate("effort", "velocity", Quantity(5.0)),
        "at offsets up to 5 s, only 0 samples overlap",
    ),
    "beyond": (
        ClockEstimate("effort", "velocity", Quantity(0.01)),
        "is at the end of the allowed range",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_does_not_tell_an_offset_is_refused(tmp_path: Path, name: str):
    estimate, message = REFUSED[name]
    with pytest.raises(LogError, match=message):
        read(files(tmp_path, 0.05), rig(clock_estimate=estimate))


def test_instruments_are_told_apart(tmp_path: Path):
    paths = files(tmp_path, 0.0)
    twice = rig()
    twice = msgspec.structs.replace(
        twice, instruments={**(twice.instruments or {}), "other": Instrument("*.csv", {})}
    )
    with pytest.raises(
        LogError, match=r"matches `files` of several instruments of bench 'rig': drive, other"
    ):
        read(paths, twice)
    with pytest.raises(LogError, match=r"maps no channel"):
        read([paths[0].rename(tmp_path / "unknown.csv")], rig())
    with pytest.raises(LogError, match="name another file before this one"):
        read([paths[1]], rig(clock_estimate=ClockEstimate("effort", "velocity", Quantity(0.1))))


def test_fewer_samples_than_their_zero_takes_are_refused(tmp_path: Path):
    path = tmp_path / "force_1.csv"
    path.write_text("0;1\n0.5;1\n1;1\n")
    with pytest.raises(
        LogError, match="column '2' has 3 samples, fewer than its zero_first_samples, 10"
    ):
        read([path], rig())


@given(
    ahead=st.floats(-0.04, 0.04),
    gain=st.sampled_from([-3.0, 0.1, 50.0]),
    noise=st.floats(0.0, 0.05),
    seed=st.integers(0, 99),
)
def test_the_interval_holds_the_offset(ahead: float, gain: float, noise: float, seed: int):
    """Two samplings that share no instant; four deviations, as this is asked of every draw, and
    what the interpolation errs."""
    rng = np.random.default_rng(seed)
    t, u = np.arange(0.0, SECONDS, 1e-3), np.arange(0.0, SECONDS, 0.667e-3)
    y = gain * (motion(u - ahead) + noise * rng.normal(size=u.size)) + 7.0
    found = clock_offset(t, motion(t) + 0.3 * noise * rng.normal(size=t.size), u, y, 0.05)
    assert found.low <= found.value <= found.high
    assert abs(found.value - ahead) <= 2.05 * (found.high - found.low) / 2.0 + 1e-6
    assert found.explained > 0.8


def test_offsets_that_cannot_be_told_are_refused():
    rng, t = np.random.default_rng(6), np.arange(0.0, SECONDS, 1e-3)
    with pytest.raises(ValueError, match=r"fit equally well; lower clock_estimate.most"):
        clock_offset(t, np.sin(40.0 * t), t, np.sin(40.0 * t) + 0.1 * rng.normal(size=t.size), 0.3)
    with pytest.raises(
        ValueError, match=r"name two channels of one quantity|at the end of the allowed range"
    ):
        clock_offset(t, motion(t), t, rng.normal(size=t.size), 0.1)
    with pytest.raises(ValueError, match=r"explains 0%|is at the end"):
        clock_offset(t, motion(t), t, np.zeros(t.size), 0.1)


def test_the_rack_s_two_exports_are_one_log():
    """The published fit of this record, on its own abscissa: while the stage runs, the force grows
    with the velocity."""
    paths = [measured("rack/a3MR.csv"), measured("rack/a3NI.csv")]
    log = read(paths, load(ROOT / "configs" / "rack" / "bench.yaml", Bench))
    drive, force = log.streams
    assert (drive.time.size, force.time.size) == (1024, 1078)
    assert drive.time[0] == pytest.approx(-0.004)
    assert drive.period == pytest.approx(0.000666666)
    assert force.time[-1] == pytest.approx(0.5385)
    assert drive.signals["velocity"].max() == pytest.approx(0.66, abs=0.01)
    assert abs(force.signals["effort"][:10].mean()) < 1e-9
    rises = np.argmax(drive.signals["velocity"] > 0.02)
    pushes = np.argmax(force.signals["effort"] > 50.0)
    assert abs(drive.time[rises] - force.time[pushes]) < 0.02
