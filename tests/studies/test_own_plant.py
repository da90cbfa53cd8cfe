"""The exported C in a plant of its own: the motion is Newton's, and the README shows the table."""

from __future__ import annotations

import ctypes

import numpy as np
import pytest

from studies import own_plant
from studies.actuators.native import Controller
from tests.support.documentation_pages import ROOT, blocks
from tests.support.documentation_player import first_missing

STEP = ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_void_p, ctypes.c_double, ctypes.c_double)
CORNER = own_plant.Corner(inertia=95.0, viscous=200.0, coulomb=20.0, offset=3.0)
BREAKAWAY = 22.0


def constant_drive(volts: float) -> Controller:
    init = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_double)(lambda state, position: None)
    return Controller(init, STEP(lambda state, reference, position: volts), bytes(8), {})


def test_a_constant_drive_gives_the_exponential_of_the_viscous_friction() -> None:
    positions, _ = own_plant.play(CORNER, BREAKAWAY, constant_drive(2.0))
    start = own_plant.PERIOD  # the command acts one sample late
    time = np.arange(positions.size) * own_plant.PERIOD - start
    push = own_plant.CONSTANT * 2.0 - CORNER.offset - CORNER.coulomb
    lag = CORNER.inertia / CORNER.viscous
    moved = push / CORNER.viscous * (time - lag * (1.0 - np.exp(-time / lag)))
    expected = own_plant.LEVELS[-1] + np.where(time > 0.0, moved, 0.0)
    assert positions == pytest.approx(expected, rel=2e-4, abs=2 * own_plant.COUNT)


@pytest.mark.parametrize("push", [0.99, 1.01])
def test_the_axis_moves_above_the_breakaway_only(push: float) -> None:
    volts = (push * BREAKAWAY + CORNER.offset) / own_plant.CONSTANT
    positions, _ = own_plant.play(CORNER, BREAKAWAY, constant_drive(volts))
    assert (positions[-1] > positions[0]) == (push > 1.0)


def test_every_verdict_is_as_predicted_and_the_readme_shows_the_table(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert own_plant.main() == 0
    shown = next(block for block in blocks(ROOT / "README.md", "text"))
    assert first_missing(capsys.readouterr().out.splitlines(), shown.lines, solved=True) is None
