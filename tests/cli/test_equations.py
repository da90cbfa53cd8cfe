"""`frictool equations`: what it prints and writes, and how a wrong mechanism is refused at the
command line."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from studies.command_line import run
from studies.rigs.clutch_model import ROOT
from tests.support.command_line import also_called, refused
from tests.support.mechanism_documents import TRAIN


@pytest.fixture
def train(tmp_path: Path) -> Path:
    path = tmp_path / "train.yaml"
    path.write_text(TRAIN)
    return path


def test_text_latex_and_data(train: Path, tmp_path: Path) -> None:
    printed = run("equations", train)
    assert printed.code == 0
    assert (
        "  J_motor omega_motor' = K_drive i_drive - F_bearing - p_reducer lambda_reducer"
        in printed.stdout
    )
    assert re.search(
        r"^  K_drive +0.02 +N m/A +sources.drive.constant$", printed.stdout, re.MULTILINE
    )
    written = run("equations", train, "--latex", "-o", tmp_path / "train.tex", "--json")
    assert written.code == 0
    assert json.loads(written.stdout)["name"] == "train"
    assert (
        r"J_{\mathrm{motor}}\,\dot{\omega}_{\mathrm{motor}} &= "
        in (tmp_path / "train.tex").read_text()
    )
    assert run("equations", train, "--json").stdout == written.stdout
    assert run("equations", train).stdout == printed.stdout
    refused(
        run("equations", train, "-o", also_called(train, ".txt")), 3, "is an input of this command"
    )


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("ratio: 0.25", "ratio: 0", ("train.yaml:8: links.reducer.ratio: found 0; allowed: > 0",)),
        (
            "[cart, ground]",
            "[cart]",
            (
                "train.yaml:10: links.spring.between: found one end, [cart]; allowed: two; the "
                "frame is an end too",
            ),
        ),
        (
            "unit: N/mm",
            "unit: N m/rad",
            (
                "train.yaml:10: links.spring.stiffness.unit: found a multiple of N m/rad; "
                "allowed: N/m",
            ),
        ),
        (
            "  rack:",
            "  chain: {kind: belt, between: [motor, shaft], radius_a: {value: 1, unit: cm}, "
            "radius_b: {value: 3, unit: cm}}\n  rack:",
            (
                "train.yaml:9: links.chain: moves shaft 0.333333 times as far as motor, but "
                "the link reducer moves shaft -0.25 times as far",
            ),
        ),
        (
            "format: mechanism/1",
            "format: model/1",
            ("train.yaml:1: format: found 'model/1'; allowed: mechanism/1",),
        ),
    ],
)
def test_a_wrong_mechanism_is_one_line(
    old: str, new: str, words: tuple[str, ...], train: Path
) -> None:
    assert old in TRAIN
    train.write_text(TRAIN.replace(old, new, 1))
    refused(run("equations", train), 3, *words)


def test_equal_places_leave_no_offset() -> None:
    """200 deg x 0.05 is 10 deg: what rounding makes of their difference is no parameter."""
    printed = run("equations", ROOT / "configs/throttle/mechanism.yaml").stdout
    assert "o_gear" not in printed
    assert "e-17" not in printed


def test_a_missing_file() -> None:
    refused(run("equations", "nothing.yaml"), 3, "nothing.yaml: no such file")
