"""`ingest` of text files: what was found of their layout, a bench to check, the rack's two
exports."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

from frictool.documents.bench import Bench
from frictool.documents.registry import load
from frictool.logs.canonical.mcap_format import read_mcap
from studies.command_line import run
from tests.support.command_line import refused
from tests.support.example_logs import ROOT, measured

RACK = ROOT / "configs" / "rack" / "bench.yaml"
EXPORT = "Motor test\nTime;Angle;Amps;State\nms;deg;A;\n" + "".join(
    f"{k},0;{k},5;-0,{k % 10};run\n" for k in range(40)
)


def test_a_guess_is_written_to_be_checked_and_loads(tmp_path: Path):
    raw, bench, log = tmp_path / "export.csv", tmp_path / "bench.yaml", tmp_path / "log.mcap"
    raw.write_text(EXPORT)
    result = run("ingest", "--guess", raw, "-o", bench)
    assert result.code == 0
    assert (
        "time is 'Time' [ms], position is 'Angle' [deg], current is 'Amps' [A]; check"
        in result.stdout
    )
    text = bench.read_text()
    assert text.count("# guessed from export.csv: check") >= 4
    document = load(bench, Bench)
    assert (document.axis, document.sample_period_s) == ("rotary", 0.001)
    ingested = run("ingest", raw, "--bench", bench, "-o", log)
    examples, layout = ingested.stderr.splitlines()[:2]
    assert ingested.code == 0
    assert examples.startswith("warning: example values of `frictool init` are not replaced yet: ")
    assert (
        layout
        == "export.csv: UTF-8, semicolon between cells, decimal comma, header in line 2, units in "
        "line 3, numbers from line 4"
    )
    assert read_mcap(log).metadata["layout"]["export.csv"].startswith("UTF-8, semicolon")


def test_a_guess_is_never_applied_unasked(tmp_path: Path):
    raw, out = tmp_path / "export.csv", tmp_path / "log.yaml"
    raw.write_text(EXPORT)
    missing = run("ingest", raw, "-o", out.with_suffix(".mcap"))
    assert missing.code == 2
    assert "use --guess, which proposes one" in missing.stderr
    assert run("ingest", "--guess", raw, raw, "-o", out).code == 2
    assert not out.exists()
    raw.write_text(EXPORT.replace("deg", "V").replace("Angle", "Level"))
    refused(run("ingest", "--guess", raw, "-o", out), 3, "give --axis rotary")
    facts = json.loads(
        run("ingest", "--guess", raw, "--axis", "linear", "-o", out, "--json").stdout
    )
    assert facts["axis"] == "linear"


@pytest.mark.parametrize(
    "option",
    [("--bench", RACK), ("--resample", "0.01"), ("--from", "0"), ("--unit", "U1"), ("--salvage",)],
)
def test_what_a_guess_would_leave_out_is_refused(option: tuple[str | Path, ...], tmp_path: Path):
    (tmp_path / "export.csv").write_text(EXPORT)
    result = run(
        "ingest", "--guess", tmp_path / "export.csv", *option, "-o", tmp_path / "bench.yaml"
    )
    assert result.code == 2
    assert f"leave out {option[0]}." in result.stderr
    assert not (tmp_path / "bench.yaml").exists()
    alone = run(
        "ingest",
        tmp_path / "export.csv",
        "--bench",
        RACK,
        "--axis",
        "rotary",
        "-o",
        tmp_path / "log.mcap",
    )
    assert (alone.code, "--axis belongs to --guess" in alone.stderr) == (2, True)


def test_a_period_that_leaves_one_sample_is_refused(tmp_path: Path):
    (tmp_path / "export.csv").write_text(
        "time,encoder,current\n" + "".join(f"{k / 1000:.3f},{k},1\n" for k in range(40))
    )
    words = [
        "ingest",
        tmp_path / "export.csv",
        "--bench",
        ROOT / "configs/clutch/bench.yaml",
        "-o",
        tmp_path / "log.mcap",
        "--resample",
    ]
    refused(run(*words, "10"), 3, "export.csv: is shorter than the resampling period of 10 s")
    assert not (tmp_path / "log.mcap").exists()
    assert run(*words, "0.039").code == 0


def test_the_rack_s_two_exports(tmp_path: Path):
    raw, log = [measured("rack/a3MR.csv"), measured("rack/a3NI.csv")], tmp_path / "stroke.mcap"
    result = run("ingest", *raw, "--bench", RACK, "-o", log)
    assert result.code == 0
    assert (
        "a3NI.csv: UTF-8, comma between cells, decimal point, header in line 3, units in line 4, "
        "numbers from line 5\n" in result.stderr
    )
    read = read_mcap(log)
    assert [stream.topic for stream in read.streams] == ["/axis", "/axis/force"]
    assert read.metadata["clock_offset"] == {"/axis": "0.004 s, given"}
    assert read.main.time[0] == -0.004


def test_whole_seconds_are_read_at_the_period_of_the_advice(tmp_path: Path):
    """50 rows share each time stamp; the advice reads all of them."""
    raw, bench, log = tmp_path / "trend.csv", tmp_path / "bench.yaml", tmp_path / "log.mcap"
    rows = [f"04.03.2026 09:12:{30 + k // 50};{k % 90};0,1" for k in range(230)]
    raw.write_text("\n".join(["Zeit;Winkel [deg];Strom [A]", *rows]) + "\n")
    assert run("ingest", "--guess", raw, "-o", bench).code == 0
    text = run("ingest", raw, "--bench", bench, "-o", log).stderr
    assert "1772615550 s after 1772615550 s; the times are too coarse" in text
    (period,) = re.findall(r"write layout\.period_s: (\S+) in bench\.yaml", text)
    bench.write_text(f"{bench.read_text()}layout: {{period_s: {period}}}\n")
    assert run("ingest", raw, "--bench", bench, "-o", log).code == 0
    assert np.allclose(read_mcap(log).main.time, 0.02 * np.arange(230))


@pytest.mark.parametrize("german", [False, True])
def test_a_row_for_each_value_is_refused_with_the_command_that_pivots_it(
    german: bool, tmp_path: Path
):
    pandas = pytest.importorskip("pandas")
    raw, bench = tmp_path / "trend.csv", tmp_path / "bench.yaml"
    raw.write_text(EXPORT)
    assert run("ingest", "--guess", raw, "-o", bench).code == 0
    header = "VarName;TimeString;VarValue;Validity" if german else "Tag,Timestamp,Value,Quality"
    row = (
        "{};2026-03-04T09:12:30.{:03d};{},5;1" if german else "{},2026-03-04T09:12:30.{:03d},{}.5,1"
    )
    tags = "angle [deg]", "amps [A]"
    lines = [header, *(row.format(tag, 50 * k, k) for k in range(20) for tag in tags)]
    raw.write_text("\n".join(lines) + "\n")
    text = run("init", tmp_path / "rig", "--from", raw).stderr
    found = run("ingest", raw, "--bench", bench, "-o", tmp_path / "log.mcap")
    assert found.stderr.endswith(f"\n{text}")
    assert len(text) - len(str(tmp_path)) < 230
    command = text.partition("pandas: ")[2].replace("FILE", repr(str(raw)))
    wide = tmp_path / "wide.csv"
    eval(f"pandas.{command.replace('wide.csv', str(wide))}", {"pandas": pandas})
    found = run("ingest", "--guess", wide, "-o", bench, "--json")
    assert json.loads(found.stdout)["columns"] == {
        "position": ["angle", "deg"],
        "current": ["amps", "A"],
    }


def test_a_row_that_lacks_several_numbers_is_lost_once(tmp_path: Path):
    raw, bench, log = tmp_path / "export.csv", tmp_path / "bench.yaml", tmp_path / "log.mcap"
    raw.write_text(EXPORT)
    assert run("ingest", "--guess", raw, "-o", bench).code == 0
    lines = EXPORT.splitlines(keepends=True)
    raw.write_text("".join([*lines[:20], lines[1], *lines[20:]]))
    found = run("ingest", raw, "--bench", bench, "-o", log, "--salvage", "--json")
    assert found.stderr.splitlines()[-1] == (
        f"error: {raw}: data were lost while reading: 1 sample in 1 place; log.mcap contains the "
        "readable data and lists the losses"
    )
    (lost,) = json.loads(found.stdout)["lost"]
    assert (lost["samples"], lost["reason"]) == (
        1,
        "column 'Time' has no finite number in this part of the log",
    )


@pytest.mark.parametrize(
    ("head", "words"),
    [
        (b"\x1f\x8b\x08\0", "packed with gzip"),
        (b"PK\x03\x04\x14\0[Content_Types].xml", "save the sheet as CSV"),
        (b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1", "save the sheet as CSV"),
        (b"", "binary and of unknown format"),
    ],
)
def test_what_only_holds_a_log_says_what_to_do(tmp_path: Path, head: bytes, words: str):
    (tmp_path / "raw").write_bytes(head + bytes(2000))
    refused(run("ingest", tmp_path / "raw", "--bench", RACK, "-o", tmp_path / "log.mcap"), 3, words)
    assert not (tmp_path / "log.mcap").exists()


def test_info_tells_an_odd_thing_once(tmp_path: Path):
    raw, bench = tmp_path / "export.csv", tmp_path / "bench.yaml"
    time = np.arange(2000) / 1000.0
    rows = zip(time, np.degrees(np.sin(9.0 * time)), -np.cos(9.0 * time), strict=True)
    raw.write_text(
        "time [s],angle [deg],current [A]\n"
        + "".join(f"{t:.3f},{angle:.4f},{amps:.4f}\n" for t, angle, amps in rows)
    )
    assert run("ingest", "--guess", raw, "-o", bench).code == 0
    result = run("info", raw, "--bench", bench)
    (examples,) = result.stderr.splitlines()  # of the guessed bench; nothing of the log
    assert examples.startswith("warning: example values of `frictool init` are not replaced yet: ")
    assert result.stdout.count("takes energy from the axis") == 1


def test_a_decimal_comma_in_quotes_between_commas(tmp_path: Path):
    """As a spreadsheet writes it where its language has a decimal comma and the delimiter is one
    too."""
    plain, quoted, bench = tmp_path / "plain.csv", tmp_path / "quoted.csv", tmp_path / "bench.yaml"
    rows = [(k / 1000.0, 0.25 * k, -1.5 + k % 3) for k in range(40)]
    plain.write_text(
        "time [s],angle [deg],current [A]\n" + "".join(f"{a},{b},{c}\n" for a, b, c in rows)
    )
    marked = (['"' + str(cell).replace(".", ",") + '"' for cell in row] for row in rows)
    quoted.write_text(
        '"time [s]","angle [deg]","current [A]"\n' + "".join(",".join(row) + "\n" for row in marked)
    )
    assert run("ingest", "--guess", plain, "-o", bench).code == 0
    read = []
    for raw in (plain, quoted):
        assert run("ingest", raw, "--bench", bench, "-o", tmp_path / "log.mcap").code == 0
        read.append(read_mcap(tmp_path / "log.mcap").main)
    assert np.array_equal(read[0].time, read[1].time)
    assert all(
        np.array_equal(read[0].signals[name], read[1].signals[name])
        for name in ("position", "current")
    )
    bench.write_text(bench.read_text() + "layout: {delimiter: comma, decimal: comma}\n")
    assert run("ingest", quoted, "--bench", bench, "-o", tmp_path / "log.mcap").code == 0


def test_a_canonical_log_is_cut_and_resampled_without_a_bench(tmp_path: Path):
    log, part = tmp_path / "log.mcap", tmp_path / "part.mcap"
    assert (
        run(
            "ingest",
            ROOT / "sample_logs" / "steps.csv",
            "--bench",
            ROOT / "configs" / "clutch" / "bench.yaml",
            "-o",
            log,
        ).code
        == 0
    )
    assert (
        run("ingest", log, "--from", "0.5", "--to", "1", "--resample", "0.01", "-o", part).code == 0
    )
    assert read_mcap(part).main.time.tolist() == pytest.approx(
        np.arange(0.5, 1.005, 0.01).tolist(), abs=1e-12
    )
    assert "input_2" not in read_mcap(part).metadata["provenance"]
