"""Every key that `identify --json` prints for breakaway ramps is described in docs/formats.md."""

from __future__ import annotations

import json

from studies.command_line import run
from tests.support.documentation_pages import ROOT


def test_each_key_of_identify_is_described() -> None:
    result = run(
        "identify",
        ROOT / "sample_logs/ramp.csv",
        "--bench",
        ROOT / "configs/clutch/bench.yaml",
        "--json",
    )
    printed = json.loads(result.stdout)
    ramp = printed["ramp"]
    keys = [
        *printed,
        *(f"ramp.{name}" for name in ramp),
        *(f"ramp.fall.{name}" for name in ramp["fall"]),
    ]
    section = (
        (ROOT / "docs/formats.md")
        .read_text()
        .partition("### `identify --json`")[2]
        .partition("\n## ")[0]
    )
    assert [key for key in keys if f"`{key}`" not in section] == []
