"""No control character of a file or of its name reaches the terminal, whichever command prints
it."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

from frictool.cli.terminal_escapes import printable, printable_json
from frictool.logs.log import Log, Stream
from studies.command_line import CommandResult, run
from tests.support.example_logs import ROOT, as_bytes

CLUTCH = ROOT / "configs" / "clutch" / "bench.yaml"
EVIL = "\x1b]0;title\x07\x1b[31m\x9b2J\u202e\x7f"
UNSAFE = re.compile("[^\n\t -~\u00a0-\u200d\u2010-\u2027\u2030-\u2065\u206a-\uffff]")


def safe(result: CommandResult) -> None:
    assert result.code in (0, 1, 2, 3, 4)
    for text in (result.stdout, result.stderr):
        assert UNSAFE.search(text) is None, ascii(text)


@pytest.fixture
def files(tmp_path: Path) -> dict[str, Path]:
    """A raw log, a canonical log, a damaged one and a bench, whose names and contents would command
    a terminal."""
    folder = tmp_path / f"x{EVIL}y"
    folder.mkdir()
    raw, canonical, damaged, bench = (
        folder / f"{name}{EVIL}" for name in ("raw.csv", "log.mcap", "cut.mcap", "bench.yaml")
    )
    time = np.arange(400) / 1000.0
    rows = "".join(f"{t:.3f},{np.sin(9 * t):.6f},{np.cos(9 * t):.6f},1\n" for t in time)
    raw.write_text(f"time [s],angle {EVIL} [rad],current [A],{EVIL}\n{rows}")
    notes = {
        "provenance": {"command": f"frictool {EVIL}"},
        "log": {"test": f"sines{EVIL}", "unit": EVIL},
        EVIL: {EVIL: EVIL},
    }
    signals = {"position": np.sin(9 * time), "current": np.cos(9 * time)}
    canonical.write_bytes(
        as_bytes(Log((Stream("/axis", time, signals, {"position": "rad", "current": "A"}),), notes))
    )
    damaged.write_bytes(canonical.read_bytes()[:700])
    bench.write_text(CLUTCH.read_text().replace("name: ", f'name: "{json.dumps(EVIL)[1:-1]}" # '))
    return {
        "raw": raw,
        "canonical": canonical,
        "damaged": damaged,
        "bench": bench,
        "folder": folder,
        "missing": folder / EVIL,
    }


COMMANDS = [
    *(
        "info {raw}",
        "info {raw} --json",
        "info {canonical}",
        "info {canonical} --json",
        "info {damaged}",
        "info {missing}",
    ),
    *(
        "info {raw} --bench {bench}",
        "ingest {raw} --bench {bench} -o {folder}/a.mcap",
        "ingest {raw} --guess -o {folder}/b.yaml",
    ),
    *(
        "ingest {damaged} --salvage -o {folder}/c.mcap",
        "ingest {raw} --guess -o -",
        "ingest {canonical} -o {folder}/d.mcap --json",
    ),
    *(
        "init {folder}/rig --from {raw}",
        "init {folder}/rig --from {raw} --json",
        "convert {canonical} -o {folder}/e.csv",
    ),
    *(
        "identify {canonical} --bench {bench}",
        "identify {raw} --bench {missing}",
        "validate {bench} {canonical}",
        "validate {raw} {bench}",
    ),
    *(
        "info {canonical} {missing}",
        "{missing}",
        "info --{missing}",
        "convert {canonical} -o {missing}",
        "verify {canonical}",
    ),
    *(
        "observe run {bench} {canonical}",
        "report {canonical} --spec {bench}",
        "simulate {bench} --scenario {raw} -o {folder}/f.mcap",
    ),
]


@pytest.mark.parametrize("words", COMMANDS)
def test_control_characters_are_escaped(words: str, files: dict[str, Path]):
    safe(run(*(word.format(**files) for word in words.split())))


def test_json_keeps_the_value(files: dict[str, Path]):
    facts = json.loads(
        run("ingest", files["raw"], "--guess", "-o", files["folder"] / "g.yaml", "--json").stdout
    )
    assert facts["columns"]["position"] == [f"angle {EVIL}", "rad"]


def test_what_is_escaped():
    assert printable("a\tb\nc\r\nd é 🙂") == "a\tb\nc\r\nd é 🙂"
    assert printable("\x1b[0m\r\x85\u202e") == "\\x1b[0m\\x0d\\x85\\u202e"
    assert json.loads(printable_json(json.dumps({"a": EVIL}, ensure_ascii=False))) == {"a": EVIL}
