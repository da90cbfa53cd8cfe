"""Formats are told by content; several files of a rig become one log."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import scipy.io

from frictool.documents.bench import Bench, Column
from frictool.documents.name_list import listed
from frictool.documents.registry import load
from frictool.errors import LogError
from frictool.logs.log_assembly import assemble, write
from frictool.logs.log_reader import read_log
from tests.support.example_logs import ROOT, as_bytes, bench, golden_log, measured, same

COLUMNS = {"time": Column("t", "s"), "position": Column("x", "count"), "current": Column("i", "A")}
VALUES = {"t": np.arange(20) / 1000.0, "x": np.arange(20.0), "i": np.arange(20.0) / 10.0}


def write_csv(path: Path) -> None:
    np.savetxt(
        path,
        np.column_stack(list(VALUES.values())),
        delimiter=";",
        header=";".join(VALUES),
        comments="",
        fmt="%.17g",
    )


def test_the_content_decides_and_not_the_name(tmp_path: Path):
    as_csv, as_mat, as_mcap = tmp_path / "a.mat", tmp_path / "b.mcap", tmp_path / "c.csv"
    write_csv(as_csv)
    scipy.io.savemat(tmp_path / "b.mat", VALUES)
    (tmp_path / "b.mat").rename(as_mat)
    as_mcap.write_bytes(as_bytes(golden_log()))
    one, other = read_log(as_csv, bench(COLUMNS)), read_log(as_mat, bench(COLUMNS))
    assert one.metadata.pop("layout").keys() == {as_csv.name}
    assert same(one, other)
    assert one.main.signals["effort"] == pytest.approx(2.0 * VALUES["i"])
    assert same(read_log(as_mcap, bench(COLUMNS)), golden_log())


def test_several_files_are_one_log(tmp_path: Path):
    files = [tmp_path / name for name in ("sines.csv", "2nd run.csv", "2nd_run.csv")]
    for file in files:
        write_csv(file)
    path = tmp_path / "log.mcap"
    with path.open("wb") as stream:
        write(assemble(files, bench(COLUMNS)), stream, {})
    log = read_log(path)
    assert [stream.topic for stream in log.streams] == [
        "/axis",
        "/axis/_2nd_run",
        "/axis/_2nd_run_2",
    ]
    assert log.metadata["columns"]["/axis/_2nd_run_2.current"] == "i [A]"
    assert log.streams[2].signals["position"].tolist() == log.main.signals["position"].tolist()


def test_a_raw_file_needs_the_bench(tmp_path: Path):
    write_csv(tmp_path / "a.csv")
    with pytest.raises(LogError, match="is a raw log file; give --bench"):
        read_log(tmp_path / "a.csv")


def test_other_binaries_are_named(tmp_path: Path):
    path = tmp_path / "x.mat"
    path.write_bytes(b"\x7fELF\0\0")
    with pytest.raises(LogError, match="is binary and of unknown format"):
        read_log(path, bench(COLUMNS))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (
            "# the model\nformat: model/1\nname: clutch\n",
            r"is a document \(model/1\); a log file is expected",
        ),
        ("<!DOCTYPE html>\n<p>1, 2</p>\n", r"is an HTML page; a log file is expected"),
    ],
)
def test_a_document_and_a_page_are_no_logs(tmp_path: Path, text: str, words: str):
    path = tmp_path / "x.csv"
    path.write_text(text)
    for told in (None, bench(COLUMNS)):
        with pytest.raises(LogError, match=words):
            read_log(path, told)


@pytest.mark.parametrize("name", ["sines", "ramp", "steps"])
def test_the_sample_logs_are_read_with_their_bench(name: str):
    log = read_log(
        ROOT / "sample_logs" / f"{name}.csv",
        load(ROOT / "configs" / "clutch" / "bench.yaml", Bench),
    )
    assert set(log.main.signals) == {"position", "current", "effort"}
    assert log.warnings == ()
    counts = log.main.signals["position"] / (2 * np.pi / 56)
    assert np.abs(counts - np.rint(counts)).max() < 1e-9


def test_the_measured_machine_is_read_with_its_bench():
    log = read_log(
        measured("emps/DATA_EMPS.mat"), load(ROOT / "configs" / "emps" / "bench.yaml", Bench)
    )
    assert log.main.time.size == 24841
    assert log.main.signals["effort"] == pytest.approx(35.15065 * log.main.signals["voltage"])
    assert log.warnings == ()


def test_names_in_a_message_fit_a_line():
    names = [f"/a/topic/with/a/long/name.and_a_path[{k}].value" for k in range(50)]
    shown = listed(names)
    assert len(shown) < 300
    assert shown.endswith(f" and {50 - shown.count('.value')} more")
    assert listed(["", "x" * 400]) == "'' and 1 more"
