"""Counters followed block after block: wraps, signs, index pulses, skipped counts; against the
motion that made them."""

from __future__ import annotations

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from frictool.documents.bench import Bench, Encoder
from frictool.documents.quantity import Quantity
from frictool.logs.channels.encoder import EncoderCounter, folded, outside
from tests.support.example_logs import bench

REVOLUTION = 100
FASTEST = 12  # counts a sample: top speed
PERIOD = 0.001


def rig(**encoder: object) -> Bench:
    """100 counts a revolution, at most 12 counts a sample."""
    one, sensor = bench({}), Encoder(counts_per_revolution=REVOLUTION, **encoder)
    speed = Quantity(FASTEST * sensor.resolution / PERIOD, unit="rad/s")
    return msgspec.structs.replace(
        one, encoder=sensor, mechanics=msgspec.structs.replace(one.mechanics, top_speed=speed)
    )


def motion(seed: int, size: int = 1500) -> np.ndarray:
    """Whole counts of a smooth motion to and fro over several revolutions, up to top speed, with
    some ripple."""
    rng = np.random.default_rng(seed)
    phase = rng.uniform(0, 2 * np.pi, 3)
    k = np.arange(size)
    speed = FASTEST * (
        0.6 * np.sin(k / 300 + phase[0])
        + 0.3 * np.sin(k / 90 + phase[1])
        + 0.05 * np.sin(k / 11 + phase[2])
    )
    return np.rint(rng.integers(-500, 500) + np.cumsum(speed))


def follow(counter: EncoderCounter, raw: np.ndarray, cuts: list[int]) -> np.ndarray:
    """The counts of `raw`, in blocks that end at `cuts`."""
    time = np.arange(raw.size) * PERIOD
    blocks = np.split(np.arange(raw.size), sorted(cut % raw.size for cut in cuts))
    return np.concatenate([counter.follow(time[block], raw[block]) for block in blocks])


CUTS = st.lists(st.integers(0, 1500), max_size=4)


@given(bits=st.integers(8, 32), signed=st.booleans(), seed=st.integers(0, 1000), cuts=CUTS)
def test_a_counter_that_wraps_is_followed_wherever_blocks_end(
    bits: int, signed: bool, seed: int, cuts: list[int]
):
    counts = motion(seed)
    counter = EncoderCounter(rig(wrap_bits=bits))
    found = follow(counter, folded(counts, bits, signed), cuts)
    assert np.array_equal(np.diff(found), np.diff(counts))
    assert counter.findings() == ()


@given(
    bits=st.integers(10, 32),
    register=st.sampled_from([16, 24, 32]),
    seed=st.integers(0, 1000),
    signed=st.booleans(),
)
def test_a_negative_count_read_as_unsigned_of_a_wider_register(
    bits: int, register: int, seed: int, signed: bool
):
    """Two's complement, sign-extended to the register: each count may show as n or as n +
    2^register; `signed` says which it means."""
    bits = min(bits, register)
    counts = motion(seed)
    seen = folded(counts, bits, True)
    seen = np.where(seen < 0, seen + 2.0**register, seen)
    assert outside(seen, bits) is None
    found = follow(EncoderCounter(rig(wrap_bits=bits, signed=signed)), seen, [])
    assert np.array_equal(np.diff(found), np.diff(counts))
    assert found[0] == folded(counts[:1], bits, signed)[0]


def test_what_no_counter_of_so_many_bits_shows():
    assert outside(np.array([-128.0, 255.0, 0.0]), 8) is None
    assert outside(np.array([3.0, 256.0]), 8) == 1
    assert outside(np.array([3.0, -129.0]), 8) == 1
    assert outside(np.array([2.0**32 - 1]), 8) is None


def reset_by_index(counts: np.ndarray, start: float) -> np.ndarray:
    """Return the reading, count by count, of a counter that starts anywhere and is set to 0 at each
    multiple of a revolution."""
    shown, out = start, np.empty(counts.size)
    out[0] = shown
    for k in range(1, counts.size):
        way = int(np.sign(counts[k] - counts[k - 1]))
        for place in range(int(counts[k - 1]), int(counts[k]), way or 1):
            shown = 0.0 if (place + way) % REVOLUTION == 0 else shown + way
        out[k] = shown
    return out


@given(seed=st.integers(0, 1000), start=st.integers(-49, 49), cuts=CUTS)
def test_index_resets_are_undone_wherever_blocks_end(seed: int, start: int, cuts: list[int]):
    """Up to the step in which the first pulse came, which nobody saw, the motion is found; from
    there on exactly."""
    counts = motion(seed)
    raw = reset_by_index(counts, float(start))
    counter = EncoderCounter(rig(index_reset=True))
    found = follow(counter, raw, cuts)
    error = np.diff(found - counts)
    off = np.flatnonzero(error)
    assert np.abs(found - found[0] - counts + counts[0]).max() <= 4 * FASTEST
    assert counter.findings() == ()
    assert counter.resets > 5
    assert off.size <= 3  # the first pulse, and one that changed too little to be told from motion


def test_lost_counts_are_made_good_by_the_next_pulse():
    counts = np.arange(0.0, 1500.0, 3.0)
    shown = counts.copy()
    shown[225:] -= 40.0  # counts lost, in one sample
    true_revolution = np.floor(counts / REVOLUTION)
    raw = np.where(
        true_revolution == true_revolution[225],
        shown - REVOLUTION * true_revolution,
        counts - REVOLUTION * true_revolution,
    )
    counter = EncoderCounter(rig(index_reset=True))
    found = follow(counter, raw, [])
    assert found[-1] - found[0] == pytest.approx(counts[-1], abs=3)
    lost, jump = counter.findings()
    assert "lost 40 counts" in lost
    assert "jumps once, at 0.225 s, by 37 counts; are counts lost?" in jump


def test_resets_that_the_bench_does_not_know_are_reported_and_left():
    counts = np.arange(0.0, 1500.0, 3.0)
    raw = np.mod(counts, REVOLUTION)
    counter = EncoderCounter(rig())
    assert np.array_equal(follow(counter, raw, [100]), raw)
    (finding,) = counter.findings()
    assert "jumps 14 times" in finding
    assert "encoder.index_reset: true" in finding


@given(bits=st.sampled_from([8, 12]), known=st.booleans(), cuts=CUTS)
def test_a_wrap_that_the_bench_does_not_know_is_reported_with_its_bits(
    bits: int, known: bool, cuts: list[int]
):
    counts = np.cumsum(np.tile([1.0, 2.0, 3.0, 2.0], 2**bits)) + 5.0
    counter = EncoderCounter(rig() if known else bench({}))
    follow(counter, folded(counts, bits, False), [cut + 5 for cut in cuts])
    (finding,) = counter.findings()
    assert f"set encoder.wrap_bits, here to {bits}" in finding


@pytest.mark.parametrize("seed", range(20))
def test_a_noisy_motion_without_top_speed_shows_no_jump(seed: int):
    rng = np.random.default_rng(seed)
    noise = np.rint(rng.normal(0.0, rng.uniform(0.3, 200.0), 1500))
    counter = EncoderCounter(bench({}))
    follow(counter, motion(seed) + noise, [])
    assert counter.findings() == ()


def test_a_gap_in_time_lets_the_axis_move_further():
    counter = EncoderCounter(rig())
    counter.follow(np.array([0.0, 0.001, 0.101]), np.array([0.0, 5.0, 900.0]))
    assert counter.findings() == ()
