"""The fleet's logs are the engine's own runs, and each kind of wear is where it says."""

from __future__ import annotations

import numpy as np

from frictool.adapters.axis_model import axis_of
from frictool.adapters.controller_composition import controller_program
from frictool.control.compiled_program import compile_program, start_at
from frictool.engine.closed_loop import MEASURED, RECORD_SIZE, TRUE_DRIVE
from frictool.engine.closed_loop import run as run_loop
from frictool.engine.disturbances_and_faults import FRICTION, neutral
from frictool.engine.status_codes import OK
from frictool.plant.axis import rest
from studies.rigs.clutch_fleet import (
    EDGE,
    Unit,
    axis,
    clutch,
    controller,
    run,
    spread,
    steps,
    targets,
)

SHORT = 2.0  # s


def test_a_log_is_the_run_of_the_engine() -> None:
    # the model's own axis under the same conditions
    reference, document = steps(SHORT), controller("speed")
    conditions = neutral(reference.size)
    conditions[1000:, FRICTION] = 1.5
    record = np.zeros((reference.size, RECORD_SIZE))
    plain = axis_of(clutch()).as_array()
    running = compile_program(controller_program(document))
    start_at(running, 0.0)
    status = run_loop(
        plain,
        rest(),
        running,
        reference,
        1e-3,
        document.delay_samples,
        record,
        np.empty(0),
        conditions,
    )
    assert status == OK
    piece = run(Unit(wear=1.5, since=1.0), reference, 0, noise=0.0).pieces[0]
    np.testing.assert_allclose(piece.position, record[:, MEASURED], atol=1e-9)
    np.testing.assert_allclose(piece.effort, 13.4e-3 * record[:, TRUE_DRIVE], rtol=1e-6, atol=1e-9)


def test_wear_is_where_it_says() -> None:
    def friction(unit: Unit, position: float, forward: bool) -> float:
        own = axis(unit)
        assert own.laws.shape is not None
        curve = own.laws.shape.coulomb[0 if forward else 1]
        return float(np.polynomial.Polynomial(curve)(position))

    for place in (2.0, 25.0, 60.0):
        new = [friction(Unit(), place, forward) for forward in (True, False)]
        added = [friction(Unit(added=0.03), place, forward) for forward in (True, False)]
        np.testing.assert_allclose(np.subtract(added, new), 0.03, rtol=1e-9)
        sided = [
            friction(Unit(forward=1.3, backward=0.9), place, forward) for forward in (True, False)
        ]
        np.testing.assert_allclose(np.divide(sided, new), [1.3, 0.9], rtol=1e-9)


def test_a_worn_zone_takes_more_effort_and_the_rest_does_not() -> None:
    reference = np.repeat([20.0, 50.0, 20.0, 50.0], 600)
    new, worn = (run(Unit(zone=zone), reference, 0, noise=0.0) for zone in (1.0, 1.4))
    low = slice(0, 600)  # the first step ends below EDGE: the two are the same until then
    assert np.all(worn.pieces[0].position[low] < EDGE)
    np.testing.assert_array_equal(new.pieces[0].effort[low], worn.pieces[0].effort[low])
    work = [float(np.sum(one.pieces[0].effort * one.velocity)) for one in (new, worn)]
    assert work[1] > 1.1 * work[0]


def test_draws_are_repeated_and_late_current_is_late() -> None:
    assert spread(3, wear=1.2) == spread(3, wear=1.2)
    assert spread(3) != spread(4)
    reference = targets(5, SHORT)
    first, again, late = (
        run(Unit(late=late), reference, 5, "linear", noise=0.0).pieces[0] for late in (0, 0, 1)
    )
    np.testing.assert_array_equal(first.effort, again.effort)
    np.testing.assert_array_equal(first.effort[:-1], late.effort[1:])
    np.testing.assert_array_equal(first.position, late.position)
