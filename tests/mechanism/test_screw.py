"""The screw and its nut of thesis 2.1.6 against its own equations by scipy; reversible and
irreversible; both forms of friction."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.support.mechanism_motion import play
from tests.support.screw_reference import SCREW, Screw

FOLDER = Path(__file__).parents[2] / "configs" / "screw"
EXAMPLES = settings(max_examples=25)
STEEP, MU = st.floats(0.03, 0.8), st.floats(0.01, 0.5)


def moved(steep: float, mu: float, form: str, torque: float) -> float:
    """Return the speed of the screw some milliseconds after rest, against 100 N."""
    return float(
        play(SCREW.format(angle=math.atan(steep), mu=mu, form=form), [[torque]] * 3).speed("screw")[
            -1
        ]
    )


@pytest.mark.parametrize("form", ["angle", "thesis"])
@pytest.mark.parametrize(
    ("name", "lead", "mu"), [("irreversible", 4.0, 0.15), ("reversible", 12.0, 0.1)]
)
def test_the_engine_does_what_the_free_bodies_say(
    name: str, lead: float, mu: float, form: str
) -> None:
    """0.4 N m, then 0.2, then none: pressed together, held, let go; in the reversible one the
    spring drives the screw back and it rings."""
    mu_line = f"friction_coefficient: {mu:g}"
    text = (
        (FOLDER / f"{name}.yaml")
        .read_text()
        .replace(mu_line, f"{mu_line}\n    friction_form: {form}")
    )
    text = text.replace(
        "low: {value: 0, unit: mm}", "low: {value: -18, unit: mm}"
    )  # it may swing past where the spring is relaxed
    found = play(text, [[8.0]] * 300 + [[4.0]] * 200 + [[0.0]] * 500)
    by_hand = Screw(
        2e-5, 0.2, 6e-3, lead / (2.0 * math.pi * 6.0), mu, 20e3, thesis=form == "thesis"
    )
    steps = ((0.3, 0.4), (0.5, 0.2), (math.inf, 0.0))
    theta, speed = by_hand.trajectory(
        lambda t: next(u for end, u in steps if t < end), 0.0, found.time, (0.3, 0.5)
    )
    np.testing.assert_allclose(found.position("screw"), theta, atol=1e-6 * np.abs(theta).max())
    np.testing.assert_allclose(found.speed("screw"), speed, atol=1e-5 * np.abs(speed).max())
    np.testing.assert_allclose(
        found.position("nut"), by_hand.way * found.position("screw"), rtol=1e-9, atol=1e-15
    )
    left = np.abs(found.position("nut")[-1]) / np.abs(found.position("nut")).max()
    assert (left == 1.0) == (name == "irreversible")


@given(STEEP, MU)
@EXAMPLES
def test_without_torque_the_spring_drives_the_screw_back_where_mu_is_below_tan_alpha(
    steep: float, mu: float
) -> None:
    for form in ("angle", "thesis"):
        speed = moved(steep, mu, form, 0.0)
        assert speed < 0.0 if mu < steep else speed == 0.0


@given(STEEP, MU)
@EXAMPLES
def test_the_square_thread_raises_and_lowers_as_in_textbooks(steep: float, mu: float) -> None:
    """r tan(alpha + phi) F to raise, r tan(alpha - phi) F to lower, F = 100 N; at rest between the
    two."""
    alpha, phi = math.atan(steep), math.atan(mu)
    raising, lowering = 0.6 * math.tan(alpha + phi), 0.6 * math.tan(alpha - phi)
    margin = 1e-6 * raising
    assert (
        moved(steep, mu, "angle", raising + margin)
        > 0.0
        == moved(steep, mu, "angle", raising - margin)
    )
    assert (
        moved(steep, mu, "angle", lowering - margin)
        < 0.0
        == moved(steep, mu, "angle", lowering + margin)
    )


@given(STEEP, MU)
@EXAMPLES
def test_the_printed_form_has_another_efficiency_than_the_text_says(
    steep: float, mu: float
) -> None:
    """Against F, (2.12) as printed starts at u = r F (tan(alpha) + mu)/(1 + mu tan(alpha)).

    That is an efficiency of tan(alpha) (1 + mu tan(alpha))/(tan(alpha) + mu). The square thread has
    tan(alpha) (1 - mu tan(alpha))/(tan(alpha) + mu): (2.12) with a plus between its terms. The
    text's 1 - mu tan(alpha) is what is left where mu r f is neglected (2.14), near neither.
    """
    starts = 0.6 * (steep + mu) / (1.0 + mu * steep)
    assert (
        moved(steep, mu, "thesis", starts * (1.0 + 1e-6))
        > 0.0
        == moved(steep, mu, "thesis", starts * (1.0 - 1e-6))
    )
    printed, square = (
        0.6 * steep / starts,
        math.tan(math.atan(steep)) / math.tan(math.atan(steep) + math.atan(mu)),
    )
    assert printed == pytest.approx(steep * (1.0 + mu * steep) / (steep + mu), rel=1e-12)
    assert square == pytest.approx(steep * (1.0 - mu * steep) / (steep + mu), rel=1e-12)


def test_a_self_locking_screw_starts_from_its_end_and_leaves_it() -> None:
    """A stop only holds against what presses onto it: behind it the thread is not wedged. 360 N of
    spring let go with 0.093 N m."""
    text = (FOLDER / "irreversible.yaml").read_text()
    seat = "  seat: {kind: stop, on: nut, low: {value: 0, unit: mm}, high: {value: 18, unit: mm}}\n"
    text = text.replace("\nsources:", seat + "\nsources:", 1)
    by_hand = Screw(2e-5, 0.2, 6e-3, 4.0 / (2.0 * math.pi * 6.0), 0.15, 20e3)
    lets_go = -by_hand.driven * 360.0 / 0.05  # A
    found = play(
        text, [[14.0]] * 100 + [[0.0]] * 50 + [[-0.99 * lets_go]] * 50 + [[-1.5 * lets_go]] * 300
    )
    end = 0.018 / by_hand.way
    np.testing.assert_allclose(found.position("screw")[[100, 150, 200]], end, rtol=1e-9)
    assert found.position("screw")[-1] == pytest.approx(0.0, abs=1e-8)
