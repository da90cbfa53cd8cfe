"""`observer.yaml`: its golden text, what is refused."""

from __future__ import annotations

from pathlib import Path

import pytest

from frictool.documents.observer import Observer
from frictool.documents.registry import json_schema, load
from frictool.documents.writing import to_yaml
from tests.documents.edited_documents import refusal

GOLDEN = Path(__file__).parent / "golden" / "observer.yaml"


def test_the_golden_observer_is_read_and_written_byte_for_byte() -> None:
    observer = load(GOLDEN, Observer)
    assert to_yaml(observer) == GOLDEN.read_text()
    assert observer.kind == "multiplicative"
    assert observer.switched is not None
    assert [mode.index for mode in observer.switched.modes] == list(range(-4, 5))
    assert {len(mode.gains[0]) for mode in observer.switched.modes if mode.direction} == {1}
    assert observer.switched.modes[4].over is None


def test_the_schema_describes_the_observers() -> None:
    described = json_schema("observer")["$defs"]
    assert {"gamma", "decay", "transitions", "motion_after_rest_s"} <= set(
        described["Switched"]["properties"]
    )
    assert {"gains", "over", "spectral_radius"} <= set(described["Mode"]["properties"])
    assert "bandwidth_rad_s" in described["Tracking"]["properties"]


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (
            "wear: multiplicative",
            "wear: multiplied",
            [
                "switched.wear",
                "'multiplied'",
                "multiplicative | additive",
                "did you mean 'multiplicative'?",
            ],
        ),
        (
            "value: 10.0, unit: rad/s",
            "value: 0.0, unit: rad/s",
            ["switched.switch_speed.value", "> 0"],
        ),
        (
            "value: 10.0, unit: rad/s",
            "value: 10.0, unit: m",
            ["switched.switch_speed.unit", "rad/s"],
        ),
        ("  - index: -3", "  - index: -2", ["switched", "each index once"]),
        (
            "  - [0, 0]",
            "  - [0, 9]",
            ["switched", "transitions: found [0, 9]; allowed: pairs of the modes' indices"],
        ),
        ("  decay: ", "  decay: 1", ["switched.decay", "<= 1"]),
        ("  gamma: ", "  gamma: -", ["switched.gamma", "> 0"]),
        ("switched:", "swiched:", ["swiched", "did you mean 'switched'?"]),
    ],
)
def test_a_wrong_line_is_named(old: str, new: str, words: list[str], tmp_path: Path) -> None:
    message = str(refusal(GOLDEN, old, new, Observer, tmp_path))
    for word in words:
        assert word in message
