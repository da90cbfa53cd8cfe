"""The survey of a log: the same however the file is cut into pieces; every fact against the samples
that were made to show it."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from frictool.identify.applicable_methods import applicable_methods
from frictool.logs.log import Stream
from frictool.logs.quality import survey as module
from frictool.logs.quality.kind_recognition import kind_of
from frictool.logs.quality.survey import StreamSurvey, in_memory, row, survey
from frictool.logs.quality.time_base import time_base
from frictool.logs.stream_source import SampleBlock

STEP = 2 * np.pi / 56
UNITS = {"position": "rad", "current": "A", "command": "A", "reference": "rad"}


def rig(seed: int = 1, size: int = 6000) -> Stream:
    """A position in counts that moves to and fro, a current that is clipped, a command that changes
    every fifth sample."""
    rng, k = np.random.default_rng(seed), np.arange(size)
    time = k * 0.001 + np.where(k >= 4000, 0.0075, 0.0) + rng.uniform(-2e-5, 2e-5, size)
    position = STEP * np.rint(60.0 * np.sin(k / 400.0))
    current = np.clip(20.0 * np.sin(k / 150.0) + rng.normal(0.0, 0.1, size), -15.0, 15.0)
    command = np.repeat(rng.normal(size=size // 5), 5)
    return Stream(
        "/axis",
        np.rint(time * 1e9) / 1e9,
        {"position": position, "current": current, "command": command},
        UNITS,
    )


def surveyed(stream: Stream, limits: dict[str, float] | None = None) -> StreamSurvey:
    return survey(*in_memory(stream), limits or {})


def test_every_fact_is_found():
    stream = rig()
    found = surveyed(stream, {"current": 15.0})
    base = time_base(stream.time)
    position, current, command = (row(found, one, None) for one in found.signals.values())
    assert position["step"] == pytest.approx(STEP)
    assert position["flat_tops"] == []
    assert position["held_s"] is None
    assert [top["at"] for top in current["flat_tops"]] == [-15.0, 15.0]
    assert current["at_limit"] == np.sum(np.abs(stream.signals["current"]) >= 0.98 * 15.0)
    assert command["held_s"] == pytest.approx(0.005, rel=1e-3)
    for one in (position, current, command):
        assert one["samples"] == 6000
        assert one["gaps"] == base.gaps == 1
        assert one["rate_hz"] == pytest.approx(base.rate_hz, rel=1e-3)
        assert one["jitter_s"] == pytest.approx(base.jitter_s, rel=1e-2)
        assert one["rate_spread_hz"] == pytest.approx(one["jitter_s"] * one["rate_hz"] ** 2)
    fastest = 60.0 * STEP / 0.4
    assert found.velocity == (pytest.approx(-fastest, rel=0.05), pytest.approx(fastest, rel=0.05))
    assert found.jumps.count == 0


@given(
    cuts=st.lists(st.integers(1, 5999), max_size=6, unique=True),
    rows=st.sampled_from([500, 1 << 16]),
)
def test_the_survey_does_not_depend_on_the_pieces(cuts: list[int], rows: int):
    head, whole = in_memory(rig())

    def pieces() -> Iterator[SampleBlock]:
        (samples,) = whole()
        bounds = [0, *sorted(cuts), 6000]
        return (samples.part(low, high) for low, high in itertools.pairwise(bounds))

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "BLOCK_ROWS", rows)
        one, other = survey(head, pieces, {}), survey(head, whole, {})
    assert one.signals == other.signals
    assert (one.base, one.velocity, one.window) == (other.base, other.velocity, other.window)
    # records with equal NaN are unequal from Python 3.13 on
    np.testing.assert_equal(vars(one.jumps), vars(other.jumps))
    assert np.array_equal(one.opening.time, other.opening.time)


def test_a_wrapping_counter_in_a_canonical_log_is_named():
    stream = rig()
    position = STEP * np.mod(np.rint(stream.signals["position"] / STEP) + 20.0, 256.0)
    found = surveyed(Stream("/axis", stream.time, {"position": position}, UNITS))
    assert found.jumps.count >= 3
    assert "here to 8" in str(found.jumps.text())


def with_signals(**signals: np.ndarray) -> Stream:
    time = np.arange(next(iter(signals.values())).size) * 0.001
    return Stream("/axis", time, signals, dict.fromkeys(signals, ""))


def told(stream: Stream) -> dict[str, str | None]:
    return applicable_methods(surveyed(stream), kind_of(stream))


def test_which_methods_a_log_can_feed():
    k = np.arange(8000)
    fine, force = 1e-6 * np.rint(1e6 * np.sin(k / 300.0)), np.sign(np.cos(k / 300.0))
    assert (
        told(with_signals(position=fine, effort=force)).items()
        >= {
            "least-squares": None,
            "inverse-dynamic": None,
            "sines": None,
            "instrumental": "the log has no reference",
            "stribeck-curve": "found 0 runs at a constant speed forward and 0 backward; needed: at "
            "least 6 in each direction, or runs in one direction only",
            "friction-force": "the log reverses, but friction-force needs a stroke in one "
            "direction; cut one stroke out (ingest --from --to), or use --method auto",
            "breakaway": "the log is not a ramp of the effort from rest (detected: sines)",
        }.items()
    )
    followed = with_signals(position=fine, effort=force, reference=fine)
    assert told(followed)["instrumental"] is None
    coarse = 0.05 * np.rint(20.0 * fine)
    assert "one encoder count is" in str(
        told(with_signals(position=coarse, effort=force))["inverse-dynamic"]
    )
    assert told(with_signals(position=coarse, effort=force))["least-squares"] is None
    one_way = told(with_signals(position=k * 1e-3, current=force))
    assert "in one direction only" in str(one_way["least-squares"])
    known = Stream("/axis", k * 0.001, {"position": k * 1e-3, "current": force}, UNITS)
    offset_known = applicable_methods(surveyed(known), kind_of(known), known_offset=True)
    assert offset_known["least-squares"] is None
    pausing = np.cumsum(np.maximum(0.0, np.sin(k / 300.0))) * 1e-3
    one_way = told(with_signals(position=pausing, current=force))
    assert "in one direction only" in str(one_way["least-squares"])
    for name, stream in {
        "neither position nor velocity": with_signals(effort=force),
        "no drive signal (effort, current, voltage)": with_signals(position=fine),
        "does not change": with_signals(position=0.0 * fine, effort=force),
    }.items():
        assert all(name in str(why) for why in told(stream).values())
    signals, units = {"position": fine, "effort": force}, {"position": "", "effort": ""}
    uneven = Stream("/axis", np.cumsum(np.where(k % 2, 0.001, 0.0017)), signals, units)
    assert told(uneven)["least-squares"] is None
    waits = np.random.default_rng(3).exponential(0.001, k.size)
    ragged = Stream("/axis", np.cumsum(waits + 1e-6), signals, units)
    assert all("the log has no sample period" in str(why) for why in told(ragged).values())
    gap = Stream(
        "/axis",
        np.where(k > 4000, k + 500, k) * 0.001,
        {"position": fine, "effort": force},
        {"position": "", "effort": ""},
    )
    assert "gaps" in str(told(gap)["inverse-dynamic"])
