"""A method of identification that is added by the recipe alone writes a model."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from frictool.documents.model import Model
from frictool.documents.registry import load
from studies.rigs.identification_rigs import CLUTCH
from studies.rigs.sample_logs import TRUTH
from tests.support.recipes import follow, frictool, frictool_each
from tests.support.short_logs import first_part

IDENTIFY = ("identify", "sines.csv", "--bench", CLUTCH, "--method", "squared-speed")


@pytest.fixture(scope="module")
def overlay(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("method")
    follow("An identification method", folder)
    (folder / "sines.csv").write_text(first_part("sines.csv"))
    return folder


def test_identify_writes_a_model_by_the_method(overlay: Path) -> None:
    target = overlay / "model.yaml"
    done = frictool(overlay, *IDENTIFY, "--window", "41", "--json", "-o", target)
    assert done.returncode == 0, done.stderr
    assert load(target, Model).method == "squared-speed"
    found = json.loads(done.stdout)
    assert found["details"]["window"] == 41
    for name in ("viscous", "coulomb"):
        interval = found["parameters"][name]
        assert interval["low"] <= getattr(TRUTH, name) <= interval["high"]


def test_help_messages_and_info_know_the_method(overlay: Path) -> None:
    help_text, refused, tried = frictool_each(
        overlay,
        ["identify", "--help"],
        [*IDENTIFY, "--skip", "3"],
        ["info", "sines.csv", "--bench", CLUTCH],
    )
    shown = help_text.stdout
    assert "least squares, weighted by the square of the speed" in shown
    assert re.search(
        r"--windowINTEGERRANGE[\w(,-]*squared-speed[\w,-]*:numberofsamples", "".join(shown.split())
    )
    assert refused.returncode == 2
    assert "--skip belongs to --method inverse-dynamic, not to squared-speed." in refused.stderr
    assert "squared-speed" in tried.stdout
