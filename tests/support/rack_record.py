"""Measured stroke of a rack, identified by the published pipeline."""

from __future__ import annotations

import json
from pathlib import Path

from studies.command_line import run as command
from studies.rigs.identification_rigs import ROOT
from tests.support.measured_data import data

RACK = ROOT / "configs" / "rack" / "bench.yaml"


def stroke(folder: Path, *part: str) -> Path:
    """The rack's two exports on one grid, as `make -C configs/rack` makes it."""
    target = folder / "stroke.mcap"
    raw = [data("rack", "a3MR.csv"), data("rack", "a3NI.csv")]
    assert (
        command(
            "ingest", *raw, "--bench", RACK, "--resample", "0.000666667", *part, "-o", target
        ).code
        == 0
    )
    return target


def published_rack(folder: Path) -> dict[str, dict[str, float]]:
    """Return the parameters of the published pipeline on the published part of the stroke, by name;
    skip without the data."""
    log = stroke(folder, "--from", "0.034", "--to", "0.27")
    published = ("--method", "friction-force", "--cutoff-hz", "30", "--filter-order", "2")
    result = command("identify", log, "--bench", RACK, *published, "--json")
    assert result.code == 0, result.stderr
    found: dict[str, dict[str, float]] = json.loads(result.stdout)["parameters"]
    return found
