"""The forms of a stored controller are of one controller: a changed section, continuous coefficient
or anti-windup gain is refused."""

from __future__ import annotations

from collections.abc import Callable

import msgspec
import numpy as np
import pytest

from frictool.documents.controller import LinearController
from frictool.errors import NoSolutionError
from frictool.verify.recheck import recheck
from frictool.verify.stored_forms import check_forms, sections_response
from tests.support.clutch_speed_controller import clutch_speed_controller

replace = msgspec.structs.replace


def _sections(linear: LinearController, row: int, column: int, factor: float) -> LinearController:
    rows = [list(section) for section in linear.sos]
    rows[row][column] *= factor
    return replace(linear, sos=tuple(tuple(section) for section in rows))


def _continuous(linear: LinearController, factor: float) -> LinearController:
    ((d,),) = linear.continuous.d
    return replace(linear, continuous=replace(linear.continuous, d=((factor * d,),)))


CHANGES: dict[str, tuple[Callable[[LinearController], LinearController], str]] = {
    "gain of a section": (lambda linear: _sections(linear, 0, 0, 1.2), "linear.sos is not"),
    "gain of a section, a little": (
        lambda linear: _sections(linear, 0, 0, 1.0 + 1e-4),
        "linear.sos is not",
    ),
    "sign of a pole": (lambda linear: _sections(linear, 1, 4, -1.0), "linear.sos is not"),
    "section left out": (lambda linear: replace(linear, sos=linear.sos[:-1]), "linear.sos is not"),
    "continuous": (lambda linear: _continuous(linear, 1.2), "linear.continuous is not"),
    "anti-windup": (
        lambda linear: replace(linear, anti_windup=(1e6,) * len(linear.anti_windup)),
        "linear.anti_windup",
    ),
}


def test_what_is_stored_agrees() -> None:
    check_forms(clutch_speed_controller())


@pytest.mark.parametrize("name", CHANGES)
def test_a_changed_form_is_refused(name: str) -> None:
    change, words = CHANGES[name]
    controller = clutch_speed_controller()
    with pytest.raises(NoSolutionError, match=words):
        recheck(replace(controller, linear=change(controller.linear)))


def test_what_rounding_changes_is_not() -> None:
    controller = clutch_speed_controller()
    check_forms(replace(controller, linear=_sections(controller.linear, 0, 0, 1.0 + 1e-12)))
    check_forms(replace(controller, linear=_continuous(controller.linear, 1.0 + 1e-12)))


def test_sections_are_their_quotients() -> None:
    angles = np.array([0.1, 1.0, 3.0])
    z = np.exp(1j * angles)
    expected = (2.0 + 3.0 / z) / (1.0 - 0.5 / z) * (1.0 / z**2)
    found = sections_response(
        ((2.0, 3.0, 0.0, 1.0, -0.5, 0.0), (0.0, 0.0, 1.0, 1.0, 0.0, 0.0)), angles
    )
    np.testing.assert_allclose(found, expected, rtol=1e-14)


def test_a_section_of_five_numbers_is_no_section() -> None:
    linear = clutch_speed_controller().linear
    with pytest.raises(ValueError, match=r"sos\[0\]: found .* b0, b1, b2, a0, a1, a2"):
        replace(linear, sos=(linear.sos[0][:5], *linear.sos[1:]))
