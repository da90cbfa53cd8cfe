"""Weights: what is given is taken, what is not is derived and told, and what nothing tells is asked
for."""

from __future__ import annotations

import math

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from frictool.documents.design import Design
from frictool.documents.model import Model
from frictool.documents.quantity import Quantity
from frictool.documents.registry import load
from frictool.documents.spec import Spec
from frictool.documents.weights import NoiseFilter, Weights
from frictool.errors import FrictoolError
from frictool.plant.generalised_plant import FirstOrderWeight
from frictool.synth.weights import choose_weights, decade
from studies.rigs.clutch_model import ROOT, clutch_model

SPEC = load(ROOT / "configs/clutch/spec.yaml", Spec)
SPEED = load(ROOT / "configs/clutch/designs/speed.yaml", Design)
STEP = 2.0 * math.pi / 56.0


def design(weights: Weights, structure: str = "position") -> Design:
    law = SPEED.position_law if structure == "speed_cascade" else None
    return msgspec.structs.replace(SPEED, structure=structure, weights=weights, position_law=law)


def gain_at(weight: FirstOrderWeight, frequency: float) -> float:
    return float(abs(weight.system(0.0).response(frequency)[0, 0, 0]))


def test_everything_given_is_taken_and_nothing_told() -> None:
    given = Weights(
        bandwidth_rad_s=20.0,
        disturbance=0.1,
        drive=0.05,
        command=0.0,
        noise=Quantity(value=0.0, unit="rad"),
        modulus_margin=0.5,
        static_error=2 / 63,
    )
    chosen = choose_weights(clutch_model(), SPEC, design(given))
    assert chosen.derived == ()
    weights = chosen.weights
    assert (weights.disturbance, weights.drive, weights.command, weights.noise) == (
        0.1,
        0.05,
        0.0,
        FirstOrderWeight(0.0),
    )
    assert weights.error.pole == pytest.approx(
        20.0 * 0.5 * 2 / 63
    )  # the slow pole of 5.4.3.1, 0.3 rad/s


def test_an_empty_table_is_derived_from_the_specification_of_5_4_1() -> None:
    chosen = choose_weights(clutch_model(), SPEC, design(Weights()))
    weights, told = chosen.weights, {one.name: one for one in chosen.derived}
    assert set(told) == {
        f"weights.{name}"
        for name in (
            "modulus_margin",
            "static_error",
            "bandwidth_rad_s",
            "disturbance",
            "drive",
            "noise",
            "command",
        )
    }
    assert all(one.source for one in chosen.derived)
    assert weights.drive == pytest.approx(63.0 / 50.0)  # (5.58), the 1.26 of the text
    assert weights.error.gain == pytest.approx(63.0 / 2.0)
    assert gain_at(weights.error, 1e7) == pytest.approx(0.5, rel=1e-4)
    assert weights.error.zero == pytest.approx(3.0 / (0.5 * 0.22))
    # at gamma 1 full friction leaves the static error of the specification: 1/(W1 G2) = 2 rad
    assert 1.0 / (weights.disturbance * weights.error.gain) == pytest.approx(2.0)
    # and one count asks for the drive's limit
    assert STEP / (weights.command * weights.noise.gain) == pytest.approx(50.0)


def test_the_speed_loop_is_meant_for_the_top_speed_and_twice_as_fast() -> None:
    position, speed = (
        choose_weights(clutch_model(), SPEC, design(Weights(), name)).weights
        for name in ("position", "speed_cascade")
    )
    assert speed.drive == pytest.approx(400.0 / 50.0)
    assert speed.disturbance == pytest.approx(1.0 / 400.0)
    assert speed.error.zero == pytest.approx(2.0 * position.error.zero)


@given(share=st.floats(0.05, 5.0), effort=st.floats(1e-3, 1.0), disturbance=st.floats(1e-3, 1.0))
def test_what_one_count_asks_for_stays_bounded_however_far_the_effort_is_relaxed(
    share: float, effort: float, disturbance: float
) -> None:
    chosen = choose_weights(clutch_model(), SPEC, design(Weights(count_share=share)))
    relaxed = chosen.relaxed(disturbance, effort)
    assert relaxed.command * relaxed.noise.gain * share * 50.0 == pytest.approx(STEP)
    assert relaxed.drive == pytest.approx(chosen.weights.drive * effort)
    assert relaxed.disturbance == pytest.approx(chosen.weights.disturbance * disturbance)


def test_a_given_command_and_noise_are_relaxed_as_given() -> None:
    given = Weights(command=0.5, noise=Quantity(value=0.01, unit="rad"))
    relaxed = choose_weights(clutch_model(), SPEC, design(given)).relaxed(1.0, 0.1)
    assert relaxed.command == pytest.approx(0.05)
    assert relaxed.noise == FirstOrderWeight(0.01)


def test_the_annex_filters_in_both_readings() -> None:
    """(25) as printed falls by ten from f4 on, its reciprocal rises by ten; W5 (26) is one at rest
    and a tenth beyond."""
    for reading, high in (("as printed", 0.1), ("reciprocal", 10.0)):
        given = Weights(
            noise=Quantity(value=0.001, unit="rad"),
            noise_filter=NoiseFilter(796.0, reading),
            uncertainty_hz=1.6e-3,
        )
        weights = choose_weights(clutch_model(), SPEC, design(given)).weights
        assert gain_at(weights.noise, 1e-2) == pytest.approx(0.001, rel=1e-3)
        assert gain_at(weights.noise, 1e8) == pytest.approx(0.001 * high, rel=1e-3)
        corner = 2.0 * np.pi * 796.0
        assert gain_at(weights.noise, corner) == pytest.approx(
            0.001 * (2**-0.5 if high < 1 else 2**0.5), rel=1e-2
        )
        assert weights.uncertainty == decade(1.0, 1.6e-3)
    assert gain_at(decade(1.0, 1.6e-3), 1e3) == pytest.approx(0.1, rel=1e-3)


def _without(model: Model, key: str) -> Model:
    mechanics = msgspec.structs.replace(model.bench.mechanics, **{key: None})
    return msgspec.structs.replace(
        model, bench=msgspec.structs.replace(model.bench, mechanics=mechanics)
    )


@pytest.mark.parametrize(
    ("missing", "structure", "weights", "message"),
    [
        ("travel", "position", Weights(static_error=0.03), "mechanics.travel"),
        ("top_speed", "speed_cascade", Weights(static_error=0.03), "mechanics.top_speed"),
        ("travel", "position", Weights(), "static_error"),
        (None, "position", Weights(noise=Quantity(value=0.0, unit="rad")), "weights.command"),
    ],
)
def test_what_nothing_tells_is_asked_for(
    missing: str | None, structure: str, weights: Weights, message: str
) -> None:
    model = clutch_model() if missing is None else _without(clutch_model(), missing)
    with pytest.raises(FrictoolError, match=message):
        choose_weights(model, SPEC, design(weights, structure))


@pytest.mark.parametrize(
    ("key", "message"),
    [("modulus_margin", "modulus_margin"), ("response_time_95_s", "bandwidth_rad_s")],
)
def test_a_specification_that_is_silent(key: str, message: str) -> None:
    with pytest.raises(FrictoolError, match=message):
        choose_weights(
            clutch_model(), msgspec.structs.replace(SPEC, **{key: None}), design(Weights())
        )


def test_the_specifications_peak_of_the_drive_counts_where_it_is_lower() -> None:
    spec = msgspec.structs.replace(SPEC, drive_peak=Quantity(value=25.0, unit="A"))
    assert choose_weights(clutch_model(), spec, design(Weights())).weights.drive == pytest.approx(
        63.0 / 25.0
    )
