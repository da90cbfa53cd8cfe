"""A damaged canonical log: what is whole is recovered as it was, and every sample that is not is
counted as lost."""

from __future__ import annotations

import io
import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mcap.writer import CompressionType, Writer

from frictool.errors import LogError
from frictool.logs.canonical.mcap_format import read_mcap
from frictool.logs.canonical.mcap_layout import schema_text
from frictool.logs.log import Log, Stream
from frictool.logs.log_assembly import assemble, write
from frictool.logs.losses import LossList, loss_lines, loss_text, losses_of
from frictool.logs.raw_table import DataLoss
from tests.support.example_logs import as_bytes

CHUNKS = 5
TIME = np.arange(CHUNKS * 100) / 25.0  # a hundred samples in each chunk, fifty of the other stream
LOG = Log(
    (
        Stream(
            "/axis",
            TIME,
            {"position": np.sin(TIME), "current": np.cos(7.0 * TIME)},
            {"position": "rad", "current": "A"},
        ),
        Stream(
            "/axis/force",
            np.rint(TIME[::2] * 1000.0 + 3.0) / 1000.0,
            {"effort": TIME[::2] ** 2},
            {"effort": "N m"},
        ),
    ),
    {"log": {"kind": "measured"}},
)
WHOLE = as_bytes(LOG)


def salvaged(data: bytes) -> tuple[Log, list[DataLoss]]:
    """Return the log that `ingest --salvage` makes of the bytes, and the losses that it lists."""
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder, "damaged.mcap"), Path(folder, "log.mcap")
        source.write_bytes(data)
        made = assemble([source], None, salvage=True)
        with target.open("wb") as stream:
            write(made, stream, {})
        log = read_mcap(target)
        told = losses_of(log.metadata, target)
        assert told == made.losses
        return log, told


def is_part(found: Stream, whole: Stream) -> bool:
    """Return True if the samples are some of the whole's, bit for bit."""
    at = np.searchsorted(whole.time, found.time)
    same_time = bool((at < whole.time.size).all()) and np.array_equal(whole.time[at], found.time)
    return same_time and all(
        np.array_equal(values, whole.signals[name][at]) for name, values in found.signals.items()
    )


def stream_of(log: Log, topic: str) -> Stream | None:
    return next((stream for stream in log.streams if stream.topic == topic), None)


def test_a_whole_log_loses_nothing():
    log, lost = salvaged(WHOLE)
    assert lost == []
    assert "lost" not in log.metadata
    assert all(
        is_part(one, other) and one.time.size == other.time.size
        for one, other in zip(log.streams, LOG.streams, strict=True)
    )


def test_everything_before_a_cut_is_recovered():
    """Wherever the file is cut: all chunks that are whole, and no sample of the others that is not
    right."""
    ends = [
        WHOLE.index(b"\x07" + (6 + 16 * n).to_bytes(8, "little")) for n in (50, 100)
    ]  # message indexes stand behind their chunks
    assert min(ends) < len(WHOLE) // 2
    before = 0
    for length in range(min(ends) + 2000, len(WHOLE), 997):
        log, lost = salvaged(WHOLE[:length])
        count = sum(stream.time.size for stream in log.streams)
        assert count >= before
        before = count
        assert lost
        assert "at byte" in lost[-1].reason, lost
        if count < sum(stream.time.size for stream in LOG.streams):
            assert lost[-1].end_s is None
            assert lost[-1].start_s == pytest.approx(max(stream.time[-1] for stream in log.streams))
        for stream in log.streams:
            whole = stream_of(LOG, stream.topic)
            assert whole is not None
            assert is_part(stream, whole)
            assert np.array_equal(stream.time, whole.time[: stream.time.size])
    assert before == sum(stream.time.size for stream in LOG.streams)


def chunk_bodies() -> list[tuple[int, int]]:
    """Where the bodies of the chunks begin and end."""
    found, position = [], 8
    while position < len(WHOLE) - 8:
        opcode, length = (
            WHOLE[position],
            int.from_bytes(WHOLE[position + 1 : position + 9], "little"),
        )
        if opcode == 0x06:
            found.append((position + 9, position + 9 + length))
        position += 9 + length
    return found


@pytest.mark.parametrize("place", range(2 * CHUNKS))
def test_one_bad_chunk_costs_only_itself_and_is_counted(place: int):
    begin, end = chunk_bodies()[place]
    damaged = bytearray(WHOLE)
    damaged[(begin + end) // 2] ^= 0x55
    with pytest.raises(
        LogError,
        match=r"damaged or cut off at byte .*; `ingest --salvage` keeps the readable part",
    ):
        salvage_refused(bytes(damaged))
    log, lost = salvaged(bytes(damaged))
    (loss,) = lost
    (short,) = [
        stream
        for stream in log.streams
        if stream.time.size < stream_of(LOG, stream.topic).time.size
    ]
    whole = stream_of(LOG, short.topic)
    assert (
        loss.samples == whole.time.size - short.time.size == (100 if short.topic == "/axis" else 50)
    )
    assert loss.channels == tuple(f"{short.topic}.{name}" for name in short.signals)
    missing = np.setdiff1d(whole.time, short.time)
    assert (loss.start_s, loss.end_s) == pytest.approx((missing[0], missing[-1]))


def salvage_refused(data: bytes) -> None:
    with tempfile.NamedTemporaryFile(suffix=".mcap") as file:
        file.write(data)
        file.flush()
        read_mcap(Path(file.name))


def test_zeros_over_the_frames_are_stepped_over():
    (_, end), (begin, _) = chunk_bodies()[3], chunk_bodies()[5]
    damaged = WHOLE[: end - 10] + bytes(begin - end + 20) + WHOLE[begin + 10 :]
    log, lost = salvaged(damaged)
    count = sum(stream.time.size for stream in log.streams)
    assert (
        sum(loss.samples or 0 for loss in lost)
        == sum(stream.time.size for stream in LOG.streams) - count
    )
    assert count > 0
    assert all(is_part(stream, stream_of(LOG, stream.topic)) for stream in log.streams)


@given(
    places=st.lists(st.integers(0, len(WHOLE) - 1), min_size=1, max_size=4),
    seed=st.integers(0, 2**32 - 1),
    width=st.integers(1, 400),
)
def test_whatever_is_damaged_no_wrong_sample_comes_through(
    places: list[int], seed: int, width: int
):
    rng = np.random.default_rng(seed)
    damaged = bytearray(WHOLE)
    for place in places:
        damaged[place : place + width] = rng.bytes(len(damaged[place : place + width]))
    if bytes(damaged) == WHOLE:
        return
    try:
        log, lost = salvaged(bytes(damaged))
    except LogError:
        return
    assert lost
    for stream in log.streams:
        whole = stream_of(LOG, stream.topic)
        assert whole is None or is_part(stream, whole)


@pytest.mark.parametrize(
    "compression", [CompressionType.LZ4, CompressionType.NONE, CompressionType.ZSTD]
)
@pytest.mark.parametrize("chunked", [True, False])
def test_the_logs_of_other_tools_are_salvaged_too(compression: CompressionType, chunked: bool):
    out = io.BytesIO()
    writer = Writer(out, compression=compression, use_chunking=chunked, chunk_size=2000)
    writer.start("ros2")
    writer.add_metadata("units", {"/axis.position": "rad"})
    schema = writer.register_schema(
        "frictool_msgs/msg/Axis", "ros2msg", schema_text(("position",)).encode()
    )
    channel = writer.register_channel("/axis", "cdr", schema)
    for number in range(300):
        writer.add_message(
            channel,
            number * 1_000_000,
            b"\0\1\0\0" + np.float64(number).tobytes(),
            number * 1_000_000,
        )
    writer.finish()
    log, lost = salvaged(out.getvalue()[: len(out.getvalue()) // 3])
    position = log.main.signals["position"]
    assert 20 < position.size < 300
    assert position.tolist() == list(range(position.size))
    assert lost[-1].start_s == pytest.approx((position.size - 1) / 1000.0)
    assert lost[-1].end_s is None


def test_what_an_earlier_salvage_lost_is_handed_on(tmp_path: Path):
    cut, once, twice = tmp_path / "cut.mcap", tmp_path / "once.mcap", tmp_path / "twice.mcap"
    cut.write_bytes(WHOLE[: len(WHOLE) // 2])
    with once.open("wb") as stream:
        write(assemble([cut], None, salvage=True), stream, {})
    made = assemble([once], None)
    with twice.open("wb") as stream:
        write(made, stream, {})
    assert made.losses == []
    assert read_mcap(twice).metadata["lost"] == read_mcap(once).metadata["lost"]


def test_losses_stay_bounded_and_lose_no_count():
    losses = LossList()
    for number in range(20_000):
        losses.append(
            DataLoss(("/axis.position",), f"line {number}", float(number), number + 0.5, 2)
        )
        losses.append(DataLoss(("/axis.current",), "nan", float(number), number + 0.5, 1))
    assert len(losses) < 1500
    assert sum(loss.samples or 0 for loss in losses) == 60_000
    assert max(loss.end_s or 0.0 for loss in losses) == 19_999.5


def test_many_losses_of_a_kind_are_one_line():
    rows = [DataLoss((), f"line {k}: has 2 cells", float(k), k + 1.0, 2) for k in range(50)]
    other = DataLoss(("/axis.current",), "nan", 7.0, 8.0, 1)
    *shown, rest, last = loss_lines([*rows[:9], other, *rows[9:]])
    assert shown == [f"2 samples from {k} to {k + 1} s: line {k}: has 2 cells" for k in range(3)]
    assert rest == "further losses: 94 samples in 47 places from 3 to 50 s, for the same reason"
    assert last == "1 sample of /axis.current from 7 to 8 s: nan"
    assert loss_lines(rows[:4]) == [loss_text(loss) for loss in rows[:4]]
