"""`model.yaml` with laws: what it may say, its golden text, what is refused."""

from __future__ import annotations

from pathlib import Path

import pytest

from frictool.documents.model import Model
from frictool.documents.registry import json_schema, load
from frictool.documents.writing import to_yaml
from tests.documents.edited_documents import refusal

GOLDEN = Path(__file__).parent / "golden" / "model.yaml"


def test_the_golden_model_is_read_and_written_byte_for_byte() -> None:
    model = load(GOLDEN, Model)
    assert to_yaml(model) == GOLDEN.read_text()
    assert model.laws is not None
    assert (model.laws.restitution, model.laws.stribeck_exponent) == (0.3, 1.5)
    assert model.laws.dwell is not None
    assert (model.laws.dwell.fresh, model.laws.dwell.rise_time_s) == (0.9, 0.25)
    assert [regime.above.value for regime in model.laws.regimes] == [150.0, 260.0]
    assert model.parameters.stribeck_velocity is not None
    assert model.laws.load is not None
    assert model.laws.load.ripple is not None
    assert model.laws.load.ripple.cycles == 7.0


def test_the_schema_describes_the_laws() -> None:
    described = json_schema("model")["$defs"]
    assert set(described["Laws"]["properties"]) == {
        "backward",
        "regimes",
        "position",
        "stribeck_exponent",
        "dwell",
        "restitution",
        "load",
        "temperature",
    }


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("law: stribeck", "law: coulomb", ["law: found coulomb", "stribeck_velocity"]),
        ("restitution: 0.3", "restitution: 1.0", ["laws.restitution", "1.0", "<= 0.95"]),
        ("restitution: 0.3", "restituton: 0.3", ["laws.restituton", "did you mean 'restitution'?"]),
        (
            "value: 150.0",
            "value: 300.0",
            ["regimes: found above 260 after above 300; allowed: rising values of above"],
        ),
        (
            "reference: {value: 45.0, unit: degC}",
            "reference: {value: 363.15, unit: K}",
            ["reference: found 90 degC; allowed: 30 to 80 degC"],
        ),
        ("fresh: 0.9", "fresh: 0.0", ["laws.dwell.fresh", "> 0"]),
        ("rise_time_s: 0.25", "rise_time_s: 0", ["laws.dwell.rise_time_s", "> 0"]),
        ("stribeck_exponent: 1.5", "stribeck_exponent: 9", ["laws.stribeck_exponent", "9", "<= 4"]),
        ("cycles: 7.0", "cycles: 0", ["laws.load.ripple.cycles", "> 0"]),
        (
            "forward: [1.0, 0.004]",
            "forward: []",
            ["laws.position.coulomb", "found 0 coefficients; allowed: 1 to 8"],
        ),
        (
            "forward: [1.0, 0.004]",
            "forward: [-1.0, 0.004]",
            [
                "laws.position",
                "coulomb.forward: found a mean of -0.88 over the travel",
                "allowed: > 0",
            ],
        ),
        (
            "forward: [1.0, 0.004]",
            "forward: [1.0, 1e308]",
            ["laws.position", "coulomb.forward: found a mean of inf"],
        ),
        (
            "forward: [1.0, 0.004]",
            "forward: [1.0, x]",
            ["laws.position.coulomb.forward[1]", "'x'", "a number"],
        ),
        ("rad_s: 966.1", "rad_s: 0", ["resonances.poles[0].rad_s", "> 0"]),
        (
            "real_poles_rad_s: [4000.0]",
            "real_zeros_rad_s: [0, 1]",
            ["resonances.real_zeros_rad_s", "found twice"],
        ),
        (
            "real_zeros_rad_s: [10000.0]",
            "real_zeros_rad_s: [1.0, 2.0]",
            ["found 4 zeros and 3 poles; allowed: no more zeros than poles"],
        ),
        (
            "low: 0.0, high: 60.0, unit: rad",
            "low: 0.0, high: 60.0, unit: m",
            ["laws.position.over.unit", "'m'", "rad"],
        ),
    ],
)
def test_a_wrong_line_is_named(old: str, new: str, words: list[str], tmp_path: Path) -> None:
    message = str(refusal(GOLDEN, old, new, Model, tmp_path))
    for word in words:
        assert word in message
