"""Clocks that were set off and made to drift are found out, by messages and by signals."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.logs.clocks.clock_drift import ClockPair, of_messages, of_streams
from frictool.logs.log import Stream


@settings(max_examples=25)
@given(
    offset=st.integers(-(10**9), 10**9),
    drift=st.floats(-2e-4, 2e-4),
    delay=st.floats(1e-5, 0.02),
    seed=st.integers(0, 99),
)
def test_messages_with_delays_tell_offset_and_drift(
    offset: int, drift: float, delay: float, seed: int
):
    """The shortest delays of many are short beside their mean, so that the line lies on them."""
    rng = np.random.default_rng(seed)
    sent = 1_700_000_000_000_000_000 + np.arange(3000) * 10_000_000
    late = rng.exponential(delay, sent.size)
    middle = (sent[0] + sent[-1]) // 2
    received = sent + offset + np.rint(drift * (sent - middle) + 1e9 * late).astype(np.int64)
    found = of_messages(sent, received)
    assert found is not None
    assert found.offset == pytest.approx(offset / 1e9, abs=0.02 * delay + 2e-9)
    assert found.drift == pytest.approx(drift, abs=0.02 * delay / 15.0 + 1e-9)
    assert found.spread == pytest.approx(late.mean(), rel=0.05, abs=1e-8)


@given(st.lists(st.tuples(st.integers(0, 10**6), st.integers(0, 10**6)), min_size=2, max_size=30))
def test_no_message_arrives_before_it_was_sent(pairs: list[tuple[int, int]]):
    sent = np.sort(np.array([one for one, _ in pairs]))
    received = sent + np.array([delay for _, delay in pairs])
    found = of_messages(sent, received)
    if found is None:
        assert np.unique(sent).size < 2
        return
    assert found.drift is not None
    line = 1e9 * found.offset + found.drift * (sent - (int(sent[0]) + int(sent[-1])) // 2)
    assert (received - sent >= line - 1e-3).all()


@pytest.mark.parametrize(
    ("drift", "told"), [(0.0, False), (1e-6, False), (3e-4, True), (-3e-4, True)]
)
def test_a_recorder_whose_clock_drifts_is_told(drift: float, told: bool):
    rng = np.random.default_rng(2)
    sent = 1_700_000_000_000_000_000 + np.arange(6000) * 10_000_000
    received = sent + np.rint(
        drift * (sent - sent[0]) + 1e6 * rng.exponential(0.5, sent.size)
    ).astype(np.int64)
    clocks = ClockPair()
    for part in np.split(np.arange(sent.size), [1000, 1001]):
        clocks.take(sent[part], received[part])
    text = clocks.finding("header.stamp", 0.01)
    assert (text is not None) == told
    if text is not None:
        assert float(text.split()[4]) == pytest.approx(1e6 * drift, rel=0.01)
        assert "the log has the times of header.stamp" in text
    assert ClockPair().finding("header.stamp", 0.01) is None


def measured(time: np.ndarray, clock: np.ndarray, noise: float, seed: int) -> Stream:
    """One signal at the true times, dated by a clock."""
    rng = np.random.default_rng(seed)
    signal = (
        np.sin(2.9 * time)
        + 0.6 * np.sin(7.3 * time + 1.0)
        + 0.4 * np.sin(17.0 * time)
        + noise * rng.normal(size=time.size)
    )
    return Stream("/axis", clock, {"velocity": signal}, {"velocity": "rad/s"})


@settings(max_examples=15)
@given(
    offset=st.floats(-0.05, 0.05),
    drift=st.floats(-1e-3, 1e-3),
    noise=st.sampled_from([0.0, 0.05]),
    rate=st.sampled_from([400.0, 1000.0, 1500.0]),
)
def test_two_instruments_on_one_axis(offset: float, drift: float, noise: float, rate: float):
    ours, theirs = np.arange(0.0, 24.0, 0.001), np.arange(0.0, 24.0, 1.0 / rate)
    one = measured(ours, ours, noise, 1)
    other = measured(theirs, theirs + offset + drift * (theirs - 12.0), noise, 2)
    found = of_streams(one, other, "velocity")
    assert found is not None
    assert found.drift is not None
    assert found.offset == pytest.approx(
        offset, abs=1e-5 + 0.05 * abs(drift) + 0.01 * noise
    )  # the middles differ by 0.05 s at most
    assert found.drift == pytest.approx(drift, abs=1e-6 + 2e-3 * noise)
    assert found.windows >= 10


def test_what_is_not_alike_tells_nothing():
    time = np.arange(0.0, 20.0, 0.001)
    rng = np.random.default_rng(1)
    one, other = (
        Stream("/axis", time, {"effort": rng.normal(size=time.size)}, {"effort": "N"})
        for _ in range(2)
    )
    assert of_streams(one, other, "effort") is None
    later = Stream("/axis", time + 100.0, other.signals, other.units)
    assert of_streams(one, later, "effort") is None
    still = Stream("/axis", time, {"effort": np.zeros(time.size)}, {"effort": "N"})
    assert of_streams(still, one, "effort") is None
