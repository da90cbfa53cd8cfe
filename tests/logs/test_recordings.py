"""Recordings of messages as tables: each container and encoding, times, names, damage."""

from __future__ import annotations

import sqlite3
import struct
import sys
import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mcap.writer import CompressionType, IndexType

from frictool.documents.bench import Column, Layout
from frictool.errors import LogError
from frictool.logs.canonical.mcap_records import FileRecord, FileRecords
from frictool.logs.log_reader import read_log
from frictool.logs.raw_table import DataLoss, RawTable
from frictool.logs.recordings.recording_files import are_parts, parts_of, sources
from frictool.logs.recordings.recording_format import sniff, tables, tables_of_parts
from tests.logs.tables import columns, times
from tests.support.example_logs import GOLDEN, bench, measured
from tests.support.recordings import (
    DELAY,
    GOLDEN_POSITION,
    PERIOD,
    START,
    Sent,
    float64s,
    idl_mcap,
    in_order,
    joint_states,
    json_mcap,
    ros1_bag,
    ros1_mcap,
    ros2_bag,
    ros2_mcap,
)

ARM = "/joint_states.position[arm]"
CDR_HEAD = b"\0\1\0\0"
POSITION = (np.arange(500) * 0.37).tolist()


def opened(data: bytes, clock: str | None = None) -> dict[str, RawTable]:
    """The tables of a recording by their topics. The file stays as long as the process of the tests
    does."""
    with tempfile.NamedTemporaryFile(suffix=".mcap", delete=False, dir=FOLDER.name) as file:
        file.write(data)
    return {table.topic: table for table in tables(Path(file.name), Layout(clock=clock))}


FOLDER = tempfile.TemporaryDirectory()


def stamps(count: int, delay: int = 0) -> list[int]:
    return [START + k * PERIOD + delay for k in range(count)]


@pytest.mark.parametrize("name", ["joint_states.mcap", "joint_states.db3", "joint_states.bag"])
def test_golden_recordings_of_joint_states(name: str):
    table = next(table for table in tables(GOLDEN / name, None) if table.topic == "/joint_states")
    assert sniff((GOLDEN / name).read_bytes()[:4096], GOLDEN / name)
    assert table.clock == "header.stamp"
    found = columns(table, [ARM, "/joint_states.position[leg]", "/joint_states.velocity[1]"])
    assert found[ARM].tolist() == GOLDEN_POSITION
    assert found["/joint_states.position[leg]"].tolist() == [1.0] * 4
    assert found["/joint_states.velocity[1]"].tolist() == [0.5, 1.5, 2.5, 3.5]
    assert times(table).tolist() == stamps(4)


def test_the_golden_recording_in_protobuf():
    (table,) = tables(GOLDEN / "drive.mcap", None)
    assert table.clock == "timestamp"
    found = columns(table)
    assert {
        name.removeprefix("/drive."): values.tolist()
        for name, values in found.items()
        if "timestamp" not in name
    } == {
        "angle": GOLDEN_POSITION,
        "state": [3.0] * 4,
        "phases[0].current": [0.5] * 4,
        "phases[1].current": [0.0, 1.0, 2.0, 3.0],
        "counts[0]": [0.0, 1.0, 2.0, 3.0],
        "counts[1]": [0.0, -1.0, -2.0, -3.0],
    }
    assert times(table).tolist() == stamps(4)


OPTIONS = {
    "zstd": {"compression": CompressionType.ZSTD},
    "lz4": {"compression": CompressionType.LZ4},
    "plain": {"compression": CompressionType.NONE},
    "unchunked": {"use_chunking": False},
    "small chunks": {"chunk_size": 300},
    "no summary": {
        "index_types": IndexType.NONE,
        "use_statistics": False,
        "use_summary_offsets": False,
        "repeat_channels": False,
        "repeat_schemas": False,
    },
    "data crc": {"enable_data_crcs": True},
}


@pytest.mark.parametrize("option", OPTIONS)
def test_every_way_of_writing_mcap_gives_the_same(option: str):
    found = opened(
        ros2_mcap(in_order(joint_states(POSITION), float64s(POSITION)), **OPTIONS[option])
    )
    assert list(found) == ["/joint_states", "/motor"]
    assert columns(found["/joint_states"], [ARM])[ARM].tolist() == POSITION
    assert columns(found["/motor"]) == {"/motor.data": pytest.approx(POSITION, abs=0)}
    assert found["/motor"].clock == "log time"
    assert times(found["/motor"]).tolist() == stamps(500, DELAY)


@given(
    st.lists(st.tuples(st.booleans(), st.floats(allow_nan=False)), min_size=1, max_size=60),
    st.sampled_from(list(OPTIONS)),
)
def test_round_trip_of_interleaved_topics(rows: list[tuple[bool, float]], option: str):
    sent = [
        (
            joint_states([value], start=START + k * PERIOD)
            if joint
            else float64s([value], start=START + k * PERIOD)
        )[0]
        for k, (joint, value) in enumerate(rows)
    ]
    found = opened(ros2_mcap(sent, **OPTIONS[option]))
    for topic, name, joint in (("/joint_states", ARM, True), ("/motor", "/motor.data", False)):
        wanted = [value for one, value in rows if one == joint]
        assert (topic in found) == bool(wanted)
        if wanted:
            assert np.array_equal(columns(found[topic], [name])[name], wanted)
            assert times(found[topic], [name]).tolist() == [
                START + k * PERIOD + (0 if joint else DELAY)
                for k, (one, _) in enumerate(rows)
                if one == joint
            ]


@pytest.mark.parametrize("schema", [True, False])
def test_json(schema: bool):
    rows = [
        {
            "timestamp": {"sec": k, "nsec": 5},
            "motor": {"position": k * 0.5, "on": True, "name": "x"},
            "taps": [k, 2.5],
            "none": None,
        }
        for k in range(1, 5)
    ]
    (table,) = opened(
        json_mcap(
            [Sent("/rig", "rig.Motor", "", k * 10**9, row) for k, row in enumerate(rows, start=1)],
            schema,
        )
    ).values()
    assert (table.clock, times(table).tolist()) == (
        "timestamp",
        [k * 10**9 + 5 for k in range(1, 5)],
    )
    found = columns(table)
    assert found["/rig.motor.position"].tolist() == [0.5, 1.0, 1.5, 2.0]
    assert found["/rig.motor.on"].tolist() == [1.0] * 4
    assert found["/rig.taps[0]"].tolist() == [1.0, 2.0, 3.0, 4.0]
    assert not any("none" in name or "name" in name for name in found)


def test_cdr_that_is_defined_in_idl():
    (table,) = opened(idl_mcap(POSITION)).values()
    found = columns(table, ["/joint.angle", "/joint.count", "/joint.taps[3]"])
    assert found["/joint.angle"].tolist() == POSITION
    assert found["/joint.count"].tolist() == list(range(500))
    assert np.isfinite(found["/joint.taps[3]"]).tolist() == [k % 5 == 4 for k in range(500)]


def test_messages_of_ros_1_in_mcap():
    (table,) = opened(ros1_mcap(POSITION)).values()
    assert columns(table, [ARM])[ARM].tolist() == POSITION
    assert (table.clock, times(table).tolist()) == ("header.stamp", stamps(500))


@pytest.mark.parametrize("compression", ["none", "bz2", "lz4"])
def test_ros_1_bags(tmp_path: Path, compression: str):
    ros1_bag(tmp_path / "x.bag", POSITION, compression, chunk_bytes=5000)
    (table,) = tables(tmp_path / "x.bag", None)
    assert columns(table, [ARM])[ARM].tolist() == POSITION
    assert times(table).tolist() == stamps(500)


@pytest.mark.parametrize("storage", ["sqlite3", "mcap"])
def test_the_folder_of_a_ros_2_bag(tmp_path: Path, storage: str):
    ros2_bag(tmp_path / "bag", POSITION, storage)
    (table,) = tables_of_parts(parts_of(tmp_path / "bag"), None)
    assert columns(table, [ARM])[ARM].tolist() == POSITION
    assert times(table).tolist() == stamps(500)


def test_a_bag_before_iron_carries_no_definitions(tmp_path: Path):
    ros2_bag(tmp_path / "bag", POSITION)
    with sqlite3.connect(tmp_path / "bag" / "bag.db3") as connection:
        connection.execute("DROP TABLE message_definitions")
    connection.close()
    (table,) = tables(tmp_path / "bag" / "bag.db3", None)
    assert columns(table, [ARM])[ARM].tolist() == POSITION
    with sqlite3.connect(tmp_path / "bag" / "bag.db3") as connection:
        connection.execute("UPDATE topics SET type = 'rig_msgs/msg/Own'")
    connection.close()
    with pytest.raises(
        LogError,
        match="rig_msgs/msg/Own cannot be read: the recording lacks it, and frictool knows "
        "only common types",
    ):
        tables(tmp_path / "bag" / "bag.db3", None)


def split_bag(folder: Path) -> list[Path]:
    folder.mkdir()
    names = [f"run_{number}.mcap" for number in (0, 1, 2)]
    for number, name in enumerate(names):
        part = joint_states(
            POSITION[number * 100 : (number + 1) * 100], start=START + number * 100 * PERIOD
        )
        (folder / name).write_bytes(ros2_mcap(part))
    lines = [
        "rosbag2_bagfile_information:",
        "  version: 5",
        "  relative_file_paths:",
        *(f"  - {name}" for name in names),
    ]
    (folder / "metadata.yaml").write_text("\n".join(lines) + "\n")
    return [folder / name for name in names]


def test_a_split_bag_is_one_recording(tmp_path: Path):
    parts = split_bag(tmp_path / "run")
    assert are_parts(parts)
    assert are_parts(parts[::-1])
    assert not are_parts([parts[0], parts[2]])
    assert not are_parts(parts[1:])
    other = tmp_path / "other.mcap"
    other.write_bytes(parts[0].read_bytes())
    assert sources([tmp_path / "run", other]) == [tuple(parts), (other,)]
    assert sources([other, *parts[::-1]]) == [(other,), tuple(parts)]
    assert sources(parts[1:]) == [(parts[1],), (parts[2],)]
    (table,) = tables_of_parts(parts, None)
    assert columns(table, [ARM])[ARM].tolist() == POSITION[:300]
    assert times(table, [ARM]).tolist() == stamps(300)
    parts[1].unlink()
    with pytest.raises(LogError, match=r"lacks the files run_1.mcap, which metadata.yaml names"):
        sources([tmp_path / "run"])


@pytest.mark.parametrize(
    "text",
    [
        "",
        "a: [",
        "rosbag2_bagfile_information: 3\n",
        "rosbag2_bagfile_information: {relative_file_paths: []}\n",
    ],
)
def test_a_folder_that_is_no_bag(tmp_path: Path, text: str):
    (tmp_path / "metadata.yaml").write_text(text)
    with pytest.raises(LogError, match=r"metadata\.yaml"):
        sources([tmp_path])


def test_a_part_that_is_cut_is_named(tmp_path: Path):
    parts = split_bag(tmp_path / "run")
    parts[1].write_bytes(parts[1].read_bytes()[:-100])
    (table,) = tables_of_parts(parts, None)
    with pytest.raises(LogError, match=r"run_1.mcap is damaged or cut off"):
        columns(table, [ARM])
    losses: list[DataLoss] = []
    assert columns(table, [ARM], losses)[ARM].tolist() == POSITION[:300]
    assert [loss.samples for loss in losses] == [
        0
    ]  # the messages are whole; what is cut is the summary


def test_the_clock_is_the_stamp_or_the_log_time_as_asked():
    data = ros2_mcap(joint_states(POSITION))
    assert times(opened(data)["/joint_states"]).tolist() == stamps(500)
    late = opened(data, clock="log time")["/joint_states"]
    assert (late.clock, times(late).tolist()) == ("log time", stamps(500, DELAY))
    with pytest.raises(
        LogError, match=r"no topic has the clock 'stamp'; found: header.stamp, log time"
    ):
        opened(data, clock="stamp")


def test_a_clock_that_was_never_set_dates_no_stream_beside_the_log_time():
    """A simulator's stamps start at 0: they may date a log alone, and not beside topics that only
    the recorder dates."""
    simulated = [
        one._replace(time=one.time + START) for one in joint_states(POSITION, start=PERIOD)
    ]
    assert opened(ros2_mcap(simulated))["/joint_states"].clock == "header.stamp"
    both = opened(ros2_mcap(in_order(simulated, float64s(POSITION))))
    assert {table.clock for table in both.values()} == {"log time"}
    assert (
        opened(ros2_mcap(in_order(simulated, float64s(POSITION))), "header.stamp")[
            "/joint_states"
        ].clock
        == "header.stamp"
    )
    unset = [
        one._replace(
            content={**one.content, "header": {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": ""}}
        )
        for one in joint_states(POSITION)
    ]
    assert opened(ros2_mcap(unset))["/joint_states"].clock == "log time"


def test_several_publishers_of_one_topic():
    """Messages with none of the wanted joints are no rows; those with one of two have nan for the
    other."""
    sent = in_order(joint_states(POSITION), joint_states(POSITION, ("hip",), start=START + 1000))
    table = opened(ros2_mcap(sent))["/joint_states"]
    assert columns(table, [ARM])[ARM].tolist() == POSITION
    assert (
        columns(table, ["/joint_states.position[hip]"])["/joint_states.position[hip]"].tolist()
        == POSITION
    )
    both = columns(table, [ARM, "/joint_states.position[hip]"])
    assert np.isnan(both[ARM]).sum() == 500
    assert both[ARM].size == 1000


def test_the_talker_carries_no_numbers():
    with pytest.raises(
        LogError,
        match=r"has no topic with numbers; found: /rosout .*/topic \(std_msgs/msg/String\)",
    ):
        tables(measured("formats/ros2_talker.mcap"), None)


def test_without_the_extra_a_protobuf_topic_says_what_to_install(monkeypatch: pytest.MonkeyPatch):
    for name in [name for name in sys.modules if name.startswith("google.protobuf")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "google.protobuf", None)
    with pytest.raises(
        LogError,
        match=r"/drive \(needs google\.protobuf\S*, which is not installed: pip install "
        r"'frictool\[protobuf\]'\)",
    ):
        tables(GOLDEN / "drive.mcap", None)


def test_a_topic_of_texts_beside_one_of_numbers_is_named():
    texts = [Sent("/note", "std_msgs/msg/String", "string data\n", START, {"data": "x"})]
    found = opened(ros2_mcap(in_order(texts, float64s([1.0]))))
    assert found["/note"].names == ()
    with pytest.raises(LogError, match="topic /note has no numbers: std_msgs/msg/String"):
        found["/note"].find("/note.data")


def test_an_encoding_that_nobody_reads_is_named():
    found = ros2_mcap(float64s([1.0])).replace(b"\3\0\0\0cdr", b"\3\0\0\0cbr")
    with pytest.raises(
        LogError, match=r"/motor .*encoding 'cbr'; allowed: cdr, ros1, json, protobuf"
    ):
        opened(found)


CHUNKED = ros2_mcap(
    in_order(joint_states(POSITION), float64s(POSITION)),
    chunk_size=3000,
    compression=CompressionType.LZ4,
)


def chunks(data: bytes) -> list[FileRecord]:
    with tempfile.TemporaryFile() as file:
        file.write(data)
        file.seek(0)
        return [
            item
            for item in FileRecords(file, len(data))
            if isinstance(item, FileRecord) and item.opcode == 6
        ]


def test_a_damaged_chunk_costs_itself_and_its_index_counts_it():
    lost = chunks(CHUNKED)[4]
    damaged = bytearray(CHUNKED)
    damaged[lost.offset + 150] ^= 0x55
    found = opened(bytes(damaged))
    whole = opened(CHUNKED)
    for topic, name in (("/joint_states", ARM), ("/motor", "/motor.data")):
        with pytest.raises(
            LogError, match=rf"at byte {lost.offset} of {len(damaged)}: a chunk cannot be read"
        ):
            columns(found[topic], [name])
        losses: list[DataLoss] = []
        left = columns(found[topic], [name], losses)[name]
        (loss,) = losses
        assert loss.samples is not None
        assert 5 < loss.samples < 50
        assert left.size + loss.samples == 500
        every = columns(whole[topic], [name])[name]
        first = int(np.argmax(left != every[: left.size]))
        assert np.array_equal(left, np.delete(every, slice(first, first + loss.samples)))


@pytest.mark.parametrize(
    "data",
    [CHUNKED, ros2_mcap(in_order(joint_states(POSITION), float64s(POSITION)), use_chunking=False)],
)
def test_everything_before_a_cut_is_recovered(data: bytes):
    table = opened(data)["/motor"]
    before = 0
    for cut in range(3000, len(data), len(data) // 23):
        table = opened(data[:cut])["/motor"]
        losses: list[DataLoss] = []
        found = columns(table, ["/motor.data"], losses)["/motor.data"]
        assert losses
        assert found.tolist() == POSITION[: found.size]
        assert found.size >= before
        before = found.size
        with pytest.raises(LogError, match=r"damaged or cut off|cannot be read"):
            columns(table, ["/motor.data"])
    assert before > 450


def test_an_unpacked_chunk_gives_every_whole_message_before_a_cut():
    data = ros2_mcap(
        in_order(joint_states(POSITION), float64s(POSITION)),
        compression=CompressionType.NONE,
        chunk_size=4000,
    )
    ends = [data.index(CDR_HEAD + struct.pack("<d", value)) + 12 for value in POSITION]
    for cut in range(len(data) // 3, len(data) // 2, 501):
        losses: list[DataLoss] = []
        found = columns(opened(data[:cut])["/motor"], ["/motor.data"], losses)["/motor.data"]
        assert found.tolist() == POSITION[: sum(end <= cut for end in ends)]
        uncounted = [loss for loss in losses if loss.samples is None]
        assert len(uncounted) <= 1  # behind the cut; the head of its chunk holds no message
        assert all(loss.samples == 0 for loss in losses if loss not in uncounted)


def test_bombs_are_refused_before_they_are_opened():
    """A chunk that announces more than may be, and one whose frame holds more than it announces."""
    import zlib

    import lz4.frame
    import zstandard

    plain = bytes(50_000_000)
    for name, packed in (("zstd", zstandard.compress(plain)), ("lz4", lz4.frame.compress(plain))):
        for size in (1000, 1 << 40):
            body = (
                struct.pack("<QQQII", 0, 0, size, zlib.crc32(plain), len(name))
                + name.encode()
                + struct.pack("<Q", len(packed))
                + packed
            )
            at = chunks(CHUNKED)[2].offset
            data = CHUNKED[:at] + struct.pack("<BQ", 6, len(body)) + body + CHUNKED[at:]
            losses: list[DataLoss] = []
            found = columns(opened(data)["/motor"], ["/motor.data"], losses)["/motor.data"]
            assert found.tolist() == POSITION
            assert any("declare" in loss.reason or "unpacks" in loss.reason for loss in losses)


def test_fewer_messages_than_the_statistics_count():
    lost = chunks(CHUNKED)[4]
    data = CHUNKED[: lost.offset] + CHUNKED[lost.offset + 9 + len(lost.body) :]
    with pytest.raises(LogError, match=r"messages are present, but the file declares 500"):
        columns(opened(data)["/motor"])


@pytest.mark.parametrize("suffix", ["db3", "bag"])
def test_bags_that_are_cut(tmp_path: Path, suffix: str):
    if suffix == "db3":
        ros2_bag(tmp_path / "bag", POSITION)
        whole = (tmp_path / "bag" / "bag.db3").read_bytes()
    else:
        ros1_bag(tmp_path / "x.bag", POSITION, chunk_bytes=2000)
        whole = (tmp_path / "x.bag").read_bytes()
    path = tmp_path / f"cut.{suffix}"
    sizes = []
    for part in (0.4, 0.6, 0.8):
        path.write_bytes(whole[: int(len(whole) * part)])
        (table,) = tables(path, None)
        losses: list[DataLoss] = []
        found = columns(table, [ARM], losses)[ARM]
        assert losses
        assert np.isin(found, POSITION).all()
        assert (np.diff(found) > 0).all()
        sizes.append(found.size)
        with pytest.raises(LogError, match="cut off"):
            columns(table, [ARM])
    assert 20 < sizes[0] < sizes[1] < sizes[2] < 500


def test_a_bag_with_a_journal_beside_it_is_not_taken_for_whole(tmp_path: Path):
    ros2_bag(tmp_path / "bag", POSITION)
    (tmp_path / "bag" / "bag.db3-wal").write_bytes(b"x")
    (table,) = tables(tmp_path / "bag" / "bag.db3", None)
    with pytest.raises(
        LogError, match=r"was not closed: bag.db3-wal in its folder contains messages"
    ):
        columns(table, [ARM])


def test_an_sqlite_file_that_is_no_bag(tmp_path: Path):
    with sqlite3.connect(tmp_path / "x.db3") as connection:
        connection.execute("CREATE TABLE things (a, b)")
    connection.close()
    with pytest.raises(LogError, match="not a ROS 2 bag: it lacks the tables topics and messages"):
        tables(tmp_path / "x.db3", None)


def test_a_message_that_is_none_is_one_loss():
    sent = joint_states(POSITION)
    data = ros2_mcap(sent, compression=CompressionType.NONE, enable_crcs=False)
    at = data.index(struct.pack("<d", POSITION[251]))  # no velocity has it
    damaged = bytearray(data)
    damaged[at - 8] = 77  # how many positions there are; 4 bytes of alignment follow
    table = opened(bytes(damaged))["/joint_states"]
    with pytest.raises(LogError, match=r"message 252, recorded at .* declares"):
        columns(table, [ARM])
    losses: list[DataLoss] = []
    assert columns(table, [ARM], losses)[ARM].tolist() == POSITION[:251] + POSITION[252:]
    assert [loss.samples for loss in losses] == [1]


def test_columns_of_two_topics_become_two_streams_of_one_clock(tmp_path: Path):
    path = tmp_path / "x.mcap"
    path.write_bytes(ros2_mcap(in_order(joint_states(POSITION), float64s(POSITION))))
    log = read_log(
        path, bench({"current": Column("/motor.data", "A"), "position": Column(ARM, "deg")})
    )
    assert [stream.topic for stream in log.streams] == ["/axis", "/axis/motor"]
    assert log.streams[0].signals["position"] == pytest.approx(np.deg2rad(POSITION), rel=1e-15)
    assert log.streams[0].time[0] == 0.0
    assert log.streams[1].time[0] == DELAY / 1e9
    assert log.metadata["time"] == {
        "epoch_ns": str(START),
        "/axis": "header.stamp",
        "/axis/motor": "log time",
    }


def test_a_path_that_is_not_there_names_the_nearest(tmp_path: Path):
    path = tmp_path / "x.mcap"
    path.write_bytes(ros2_mcap(joint_states(POSITION)))
    with pytest.raises(
        LogError,
        match=r"has no column '/joint_states.position\[ram\]' \(did you mean "
        r"'/joint_states.position\[arm\]'\?\)",
    ):
        read_log(path, bench({"position": Column("/joint_states.position[ram]", "rad")}))
