"""The canonical log: golden file, round trips, other tools on our files, our reader on what other
tools make of them."""

from __future__ import annotations

import io
import struct
import tempfile
import zlib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mcap.reader import make_reader
from mcap.stream_reader import StreamReader
from mcap.writer import CompressionType, Writer
from mcap_ros2.decoder import DecoderFactory

from frictool.errors import LogError
from frictool.logs.canonical.mcap_format import read_mcap, write_mcap
from frictool.logs.canonical.mcap_layout import StreamHeader
from frictool.logs.canonical.mcap_writer import CanonicalWriter
from frictool.logs.canonical.sample_chunks import CHUNK_NS
from frictool.logs.log import Log, Stream
from tests.support.example_logs import GOLDEN, as_bytes, golden_log, measured, same


def read_bytes(data: bytes) -> Log:
    with tempfile.NamedTemporaryFile(suffix=".mcap") as file:
        file.write(data)
        file.flush()
        return read_mcap(Path(file.name))


def test_the_golden_file_reads_as_what_it_was_made_from():
    assert same(read_mcap(GOLDEN / "two_streams.mcap"), golden_log())


def test_the_golden_file_is_what_is_written_now():
    """Compared record by record: which bytes zstd makes of a chunk is up to its version, and
    offsets follow."""

    def records(data: bytes) -> list[str]:
        kinds = ("Header", "Schema", "Channel", "Message", "MessageIndex", "Metadata", "Statistics")
        return [
            repr(r)
            for r in StreamReader(io.BytesIO(data), validate_crcs=True).records
            if type(r).__name__ in kinds
        ]

    written = records(as_bytes(golden_log()))
    assert len(written) > 28
    assert written == records((GOLDEN / "two_streams.mcap").read_bytes())


def test_the_same_log_gives_the_same_bytes():
    assert as_bytes(golden_log()) == as_bytes(golden_log())


@given(
    start=st.integers(-3_000_000_000, 2_000_000_000),
    steps=st.lists(st.integers(1, 700_000_000), min_size=0, max_size=40),
    columns=st.lists(
        st.sampled_from(["position", "velocity", "current", "effort", "x_1"]),
        min_size=1,
        max_size=5,
        unique=True,
    ),
    seed=st.integers(0, 2**32 - 1),
)
def test_round_trip(start: int, steps: list[int], columns: list[str], seed: int):
    rng = np.random.default_rng(seed)
    time = np.cumsum([start, *steps]) / 1e9
    signals = {
        name: rng.normal(size=time.size) * 10.0 ** rng.integers(-300, 300) for name in columns
    }
    log = Log(
        (Stream("/axis", time, signals, dict.fromkeys(columns, "rad")),),
        {"note": {"text": "é [\n"}},
    )
    assert same(read_bytes(as_bytes(log)), log)


def test_times_of_unix_epoch_keep_what_a_float_holds():
    time = 1.7e9 + np.arange(5) / 1000.0
    log = Log((Stream("/axis", time, {"position": time * 0}, {"position": "rad"}),))
    assert np.abs(read_bytes(as_bytes(log)).main.time - time).max() <= np.spacing(1.7e9)


def test_the_mcap_library_decodes_the_messages():
    log = golden_log()
    reader = make_reader(
        io.BytesIO(as_bytes(log)), validate_crcs=True, decoder_factories=[DecoderFactory()]
    )
    found = list(reader.iter_decoded_messages())
    for stream in log.streams:
        messages = [
            (message, decoded)
            for _, channel, message, decoded in found
            if channel.topic == stream.topic
        ]
        assert [message.log_time for message, _ in messages] == np.rint(
            (stream.time + 0.75) * 1e9
        ).astype(int).tolist()
        for name, values in stream.signals.items():
            assert [getattr(decoded, name) for _, decoded in messages] == values.tolist()
    assert [message.log_time for _, _, message, _ in found] == sorted(
        message.log_time for _, _, message, _ in found
    )


def test_the_mcap_library_seeks_and_finds_the_metadata():
    data = as_bytes(golden_log())
    reader = make_reader(io.BytesIO(data), validate_crcs=True)
    late = list(reader.iter_messages(topics=["/axis"], starting_at=6_000_000_000))
    assert len(late) == 5  # the times from 5.25 to 6.25 s, shifted by 0.75 s
    assert reader.get_header().profile == "ros2"
    metadata = {record.name: record.metadata for record in reader.iter_metadata()}
    assert metadata["units"] == {
        "/axis.position": "rad",
        "/axis.current": "A",
        "/axis/force.effort": "N m",
    }
    assert metadata["time"] == {"shift_ns": "750000000"}
    summary = reader.get_summary()
    assert summary is not None
    assert summary.statistics is not None
    assert summary.statistics.message_count == 15
    assert all(
        index.message_end_time - index.message_start_time < CHUNK_NS
        for index in summary.chunk_indexes
    )


def test_every_crc_is_checked_by_the_library_too():
    assert (
        sum(1 for _ in StreamReader(io.BytesIO(as_bytes(golden_log())), validate_crcs=True).records)
        > 15
    )


@pytest.mark.parametrize(
    "compression", [CompressionType.ZSTD, CompressionType.LZ4, CompressionType.NONE]
)
@pytest.mark.parametrize("chunked", [True, False])
def test_what_another_tool_rewrites_is_read(compression: CompressionType, chunked: bool):
    """Both streams in one chunk, schemas and channels inside it, another order of records: as a
    filter or merge would leave them."""
    log = golden_log()
    out = io.BytesIO()
    writer = Writer(
        out, compression=compression, use_chunking=chunked, chunk_size=300, enable_data_crcs=True
    )
    writer.start("ros2")
    reader = make_reader(io.BytesIO(as_bytes(log)))
    for record in reader.iter_metadata():
        writer.add_metadata(record.name, record.metadata)
    channels: dict[int, int] = {}
    for schema, channel, message in reader.iter_messages():
        if channel.id not in channels:
            identity = writer.register_schema(schema.name, schema.encoding, schema.data)
            channels[channel.id] = writer.register_channel(
                channel.topic, channel.message_encoding, identity
            )
        writer.add_message(
            channels[channel.id],
            message.log_time,
            message.data,
            message.publish_time,
            message.sequence,
        )
    writer.finish()
    assert same(read_bytes(out.getvalue()), log)


@pytest.mark.parametrize("step", [41, pytest.param(7, marks=pytest.mark.accept)])
def test_every_cut_is_refused(step: int):
    data = as_bytes(golden_log())
    for length in range(1, len(data), step):
        with pytest.raises(LogError, match=r"damaged or cut off|no MCAP file"):
            read_bytes(data[:length])


@pytest.mark.parametrize("step", [29, pytest.param(3, marks=pytest.mark.accept)])
def test_every_flipped_byte_is_refused(step: int):
    """All bytes lie under a CRC, are one, or are the frame around them: no flip passes, none raises
    anything else."""
    data = as_bytes(golden_log())
    for position in range(0, len(data), step):
        damaged = bytearray(data)
        damaged[position] ^= 0x41
        with pytest.raises(LogError):
            read_bytes(bytes(damaged))


def test_a_huge_declared_length_is_refused_before_it_is_allocated():
    data = as_bytes(golden_log())
    for length in (2**40, 2**63, 2**64 - 1, 1 << 29):
        with pytest.raises(LogError, match="declared"):
            read_bytes(data[:9] + struct.pack("<Q", length) + data[17:])


def test_a_chunk_that_declares_more_than_it_holds_is_refused():
    plain = b"\0" * 1000
    from frictool.logs.canonical.mcap_chunk import chunk_data

    def body(size: int, compression: bytes, packed: bytes) -> bytes:
        head = struct.pack("<QQQII", 0, 0, size, zlib.crc32(plain), len(compression))
        return head + compression + struct.pack("<Q", len(packed)) + packed

    assert chunk_data(body(1000, b"", plain)) == plain
    import lz4.frame
    import zstandard

    for compression, packed in (
        (b"zstd", zstandard.compress(plain)),
        (b"lz4", lz4.frame.compress(plain)),
    ):
        assert chunk_data(body(1000, compression, packed)) == plain
        for size in (10, 999, 1001, 10**12):
            with pytest.raises(ValueError, match="declare"):
                chunk_data(body(size, compression, packed))
        with pytest.raises(ValueError, match=r"."):
            chunk_data(body(1000, compression, packed[:-5]))
    with pytest.raises(ValueError, match="unknown compression"):
        chunk_data(body(1000, b"rar", plain))


@pytest.mark.parametrize("shift", ["--5", "1.5", "", "9" * 30])
def test_a_shift_that_is_no_number_is_refused(shift: str):
    out = io.BytesIO()
    writer = CanonicalWriter(out, (StreamHeader("/axis", ("position",), ("rad",)),), {})
    writer.describe("time", {"shift_ns": shift})
    writer.chunk(0, np.array([1, 2]), [np.array([0.0, 1.0])])
    writer.finish()
    with pytest.raises(LogError, match=r"shift_ns: found .*; allowed: a whole number"):
        read_bytes(out.getvalue())


def test_a_log_without_its_units_is_refused():
    out = io.BytesIO()
    writer = CanonicalWriter(out, (StreamHeader("/axis", ("position",), ("rad",)),), {})
    writer.describe("units", {"/axis.speed": "rad/s"})  # the later record counts
    writer.chunk(0, np.array([1, 2]), [np.array([0.0, 1.0])])
    writer.finish()
    with pytest.raises(LogError, match=r"metadata 'units' has no '/axis.position'"):
        read_bytes(out.getvalue())


def test_an_mcap_with_other_messages_is_named():
    with pytest.raises(LogError, match="is not a canonical log: channel"):
        read_mcap(measured("formats/ros2_talker.mcap"))


def test_repeated_time_is_refused():
    stream = Stream(
        "/axis", np.array([0.0, 1e-10, 1.0]), {"position": np.zeros(3)}, {"position": "rad"}
    )
    with pytest.raises(LogError, match="sample 2"):
        write_mcap(Log((stream,)), io.BytesIO())


@pytest.mark.parametrize(
    ("time", "value", "message"),
    [
        ([0.0, np.nan], [1.0, 2.0], "time: sample 2 is nan"),
        ([0.0, 1.0], [1.0, np.inf], "position: sample 2 is inf"),
        ([], [], "no samples"),
    ],
)
def test_what_is_no_log_is_not_written(time: list[float], value: list[float], message: str):
    stream = Stream("/axis", np.array(time), {"position": np.array(value)}, {"position": "rad"})
    with pytest.raises(LogError, match=message):
        write_mcap(Log((stream,)), io.BytesIO())


@pytest.mark.parametrize(
    ("topic", "signal"),
    [("/joint", "position"), ("/axis/a b", "position"), ("/axis", "Position"), ("/axis", "a__b")],
)
def test_names_that_ros_refuses_are_refused(topic: str, signal: str):
    stream = Stream(topic, np.array([0.0]), {signal: np.array([0.0])}, {signal: "rad"})
    with pytest.raises(ValueError, match="allowed"):
        write_mcap(Log((stream,)), io.BytesIO())
