"""`ingest` of what is long, damaged, piped, or too large for the disk."""

from __future__ import annotations

import io
import json
import os
import pty
import resource
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from frictool.cli import progress
from frictool.logs.canonical.mcap_format import read_mcap
from frictool.runtime.kernels import FOLDER
from studies.command_line import CommandResult, run
from tests.support.command_line import refused
from tests.support.example_logs import ROOT, as_bytes, golden_log
from tests.support.peak_memory import peak_mb

CLUTCH = ROOT / "configs" / "clutch" / "bench.yaml"
HEADER = "time [s],encoder [count],current [A]\n"
COMMAND = [sys.executable, "-m", "frictool.cli.main", "ingest"]


def rows(n: int) -> str:
    return HEADER + "".join(f"{k / 1000:.3f},{k // 7},{k % 13}\n" for k in range(n))


@pytest.fixture
def raw(tmp_path: Path) -> Path:
    path = tmp_path / "raw.csv"
    path.write_text(rows(3000))
    return path


def test_a_damaged_log_is_refused_or_salvaged(raw: Path, tmp_path: Path):
    log, cut, saved = tmp_path / "log.mcap", tmp_path / "cut.mcap", tmp_path / "saved.mcap"
    assert run("ingest", raw, "--bench", CLUTCH, "-o", log).code == 0
    cut.write_bytes(log.read_bytes()[: log.stat().st_size * 6 // 10])
    refused(
        run("ingest", cut, "--bench", CLUTCH, "-o", saved),
        3,
        "cut.mcap: is damaged or cut off",
        "--salvage",
    )
    assert not saved.exists()
    done = run("ingest", cut, "--bench", CLUTCH, "-o", saved, "--salvage", "--json")
    assert done.code == 3
    assert done.stderr.startswith("error: ")
    assert done.stderr.count("\n") == 1
    assert "saved.mcap contains the readable data and lists the losses" in done.stderr
    lost = json.loads(done.stdout)["lost"]
    assert lost[0]["channels"] == ["/axis.position", "/axis.current", "/axis.effort"]
    facts = run("info", saved, "--json")
    assert facts.code == 0
    assert json.loads(facts.stdout)["lost"] == lost
    assert np.array_equal(
        read_mcap(saved).main.signals["position"],
        read_mcap(log).main.signals["position"][: lost_from(lost)],
    )


def lost_from(lost: list[dict[str, float]]) -> int:
    return round(lost[0]["start_s"] * 1000.0) + 1


def test_bad_rows_are_salvaged_and_counted(raw: Path, tmp_path: Path):
    text = raw.read_text().splitlines()
    text[100] = "0.099,n/a,1"
    text[200] = "0.199,1"
    raw.write_text("\n".join(text) + "\n")
    refused(
        run("ingest", raw, "--bench", CLUTCH, "-o", tmp_path / "x.mcap"), 3, "raw.csv:101:", "'n/a'"
    )
    done = run("ingest", raw, "--bench", CLUTCH, "-o", tmp_path / "x.mcap", "--salvage")
    assert done.code == 3
    assert "data were lost while reading: 2 samples in 2 places" in done.stderr
    assert read_mcap(tmp_path / "x.mcap").main.time.size == 2998


def test_nothing_to_salvage_is_nothing_written(tmp_path: Path):
    path = tmp_path / "x.mcap"
    path.write_bytes(as_bytes(golden_log())[:300])
    done = run("ingest", path, "--bench", CLUTCH, "-o", tmp_path / "y.mcap", "--salvage")
    refused(done, 3, "x.mcap")
    assert list(tmp_path.iterdir()) == [path]


def test_a_part_of_a_log(raw: Path, tmp_path: Path):
    target = tmp_path / "part.mcap"
    assert (
        run("ingest", raw, "--bench", CLUTCH, "--from", "0.5", "--to", "1.25", "-o", target).code
        == 0
    )
    log = read_mcap(target)
    assert (log.main.time[0], log.main.time[-1]) == (0.5, 1.25)
    assert (
        log.metadata["provenance"]["command"]
        == "frictool ingest raw.csv --bench bench.yaml --from 0.5 --to 1.25"
    )
    part = json.loads(
        run("info", raw, "--bench", CLUTCH, "--from", "0.5", "--to", "1.25", "--json").stdout
    )
    assert part["duration_s"] == pytest.approx(0.75)
    refused(
        run("ingest", raw, "--bench", CLUTCH, "--from", "50", "-o", target),
        3,
        "has no samples from 50 s",
    )
    assert run("ingest", raw, "--bench", CLUTCH, "--from", "2", "--to", "1", "-o", target).code == 2


def test_another_period_only_where_asked(raw: Path, tmp_path: Path):
    target = tmp_path / "slow.mcap"
    assert run("ingest", raw, "--bench", CLUTCH, "--resample", "0.004", "-o", target).code == 0
    log = read_mcap(target)
    assert np.diff(log.main.time) == pytest.approx(0.004)
    assert log.main.signals["current"].tolist() == [(4 * k) % 13 for k in range(750)]
    assert log.metadata["resampled"]["/axis.current"] == "held"
    assert run("ingest", raw, "--bench", CLUTCH, "--resample", "0", "-o", target).code == 2


def test_standard_input(raw: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    def piped(data: bytes, *names: str) -> CommandResult:
        monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(data)))
        return run("ingest", *names, "--bench", CLUTCH, "-o", one)

    one, other = tmp_path / "one.mcap", tmp_path / "other.mcap"
    assert piped(raw.read_bytes(), "-").code == 0
    assert run("ingest", raw, "--bench", CLUTCH, "-o", other).code == 0
    assert np.array_equal(
        read_mcap(one).main.signals["position"], read_mcap(other).main.signals["position"]
    )
    assert (
        read_mcap(one).metadata["provenance"]["command"] == "frictool ingest - --bench bench.yaml"
    )
    assert read_mcap(one).metadata["provenance"]["input_1"].startswith("stdin sha256:")
    assert piped(b"", "-", "-").code == 2
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(one.read_bytes())))
    assert json.loads(run("info", "-", "--json").stdout)["duration_s"] == pytest.approx(2.999)
    refused(piped(b"", "-"), 3, "stdin: is empty")


def test_a_fifo_is_refused_at_once(tmp_path: Path):
    fifo = tmp_path / "fifo"
    os.mkfifo(fifo)
    refused(
        run("ingest", fifo, "--bench", CLUTCH, "-o", tmp_path / "x.mcap"),
        3,
        "is not a regular file",
        "`frictool ingest -`",
    )


def test_a_full_disk_leaves_nothing_behind(raw: Path, tmp_path: Path):
    """A limit on the size of files stands for the disk: both refuse a write in the middle of the
    log."""

    def limit() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000))

    folder = tmp_path / "out"
    folder.mkdir()
    line = [*COMMAND, raw, "--bench", CLUTCH, "-o", folder / "log.mcap"]
    done = subprocess.run(line, capture_output=True, text=True, check=False, preexec_fn=limit)
    assert done.returncode == 3
    assert "log.mcap: cannot be written: File too large" in done.stderr
    assert done.stderr.count("\n") == 1
    assert list(folder.iterdir()) == []


def test_a_wait_for_the_compiler_is_told_once_on_a_terminal(raw: Path, tmp_path: Path):
    """Whichever command meets it, here `info`: no command asks for it."""
    line = [*map(str, COMMAND[:-1]), "info", str(raw), "--bench", str(CLUTCH)]
    told = []
    assert run(*line[3:]).code == 0  # compiles all kernels that are not kept yet
    assert FOLDER is not None
    cache = tmp_path / "cache"
    shutil.copytree(FOLDER, cache / FOLDER.name)
    environment = os.environ | {"NUMBA_CACHE_DIR": str(cache)}
    for is_kept in (False, True):
        if not is_kept:  # one kernel has to be compiled again
            indices = list(cache.rglob("read_rows-*.nbi"))
            for index in indices:
                index.unlink()
        ours, theirs = pty.openpty()
        subprocess.run(line, stderr=theirs, stdout=subprocess.DEVNULL, env=environment, check=True)
        os.write(theirs, b".")  # else there is nothing to read where nothing was told
        told.append(os.read(ours, 100_000).count(b"once per installation"))
        os.close(theirs)
        os.close(ours)
    assert told == [1, 0]
    assert any(index.exists() for index in indices)


def test_the_engine_tells_of_its_compiler_in_a_log_too(capsys: pytest.CaptureFixture[str]):
    """No terminal here: only what asks to be told everywhere is, and once."""
    progress._note_once.cache_clear()
    progress.note_compiling()
    assert capsys.readouterr().err == ""
    for _ in range(2):
        progress.note_compiling(everywhere=True)
    told = capsys.readouterr().err
    assert told.startswith("compiling for this machine")
    assert told.count("\n") == 1


def test_what_holds_no_text_needs_no_compiler(tmp_path: Path):
    """An MCAP file is looked at and passed through without numba."""
    log = tmp_path / "log.mcap"
    log.write_bytes(as_bytes(golden_log()))
    code = (
        "import sys; from frictool.cli.main import main\ntry: main()\nexcept SystemExit as "
        "end: assert not end.code\n"
    )
    code += "assert 'numba' not in sys.modules"
    for words in (["info", log], ["ingest", log, "-o", tmp_path / "out.mcap"]):
        subprocess.run([sys.executable, "-c", code, *words], capture_output=True, check=True)


def _everything(terminal: int) -> bytes:
    """Return all that is written to a terminal until its other end is closed."""
    parts = []
    try:
        while part := os.read(terminal, 4096):
            parts.append(part)
    except OSError:  # Linux reports the closed end so
        pass
    return b"".join(parts)


def test_a_bar_on_a_terminal(raw: Path, tmp_path: Path):
    line = [*map(str, COMMAND), str(raw), "--bench", str(CLUTCH), "-o", str(tmp_path / "x.mcap")]
    ours, theirs = pty.openpty()
    with subprocess.Popen(line, stderr=theirs, stdout=subprocess.DEVNULL) as process:
        os.close(theirs)
        shown = _everything(ours).decode()
    os.close(ours)
    assert process.returncode == 0
    assert "ingest " in shown
    assert "100%" in shown


@pytest.mark.parametrize("source", [".csv", pytest.param(".mcap", marks=pytest.mark.accept)])
def test_memory_does_not_grow_with_the_log(source: str, tmp_path: Path):
    """Four times the log, 72 MB of samples, in the memory of one that fills every buffer. The 2 GB
    of it are in `make accept`."""
    block = rows(50_000).splitlines(keepends=True)[1:]
    bench = tmp_path / "bench.yaml"
    bench.write_text(
        "".join(
            line
            for line in CLUTCH.read_text().splitlines(keepends=True)
            if not line.startswith("  time:")
        )
    )
    short, long = tmp_path / "short", tmp_path / "long"
    forward = [line.split(",", 1)[1] for line in block]
    lines = "".join(
        forward + forward[::-1]
    )  # to and fro, so that blocks follow one another without a jump
    for path, times in ((short, 3), (long, 12)):
        path.with_suffix(".csv").write_text(HEADER.split(",", 1)[1] + lines * times)
        if source == ".mcap":
            raw, log = path.with_suffix(".csv"), path.with_suffix(source)
            assert run("ingest", raw, "--bench", bench, "-o", log).code == 0
    target = tmp_path / "target.mcap"
    base, found = (
        peak_mb("ingest", path.with_suffix(source), "--bench", bench, "-o", target)
        for path in (short, long)
    )
    assert found < base + 20.0
