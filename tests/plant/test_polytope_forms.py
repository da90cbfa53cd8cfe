"""Parameters that may be scheduled, regimes of speed, and the linearised vertices."""

from __future__ import annotations

import itertools
import math

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog

from frictool.adapters.model_polytope import polytope
from frictool.adapters.parameter_intervals import intervals
from frictool.documents.laws import Laws, Regime
from frictool.documents.quantity import Estimate, Quantity
from frictool.errors import FrictoolError, NoSolutionError
from frictool.plant.linearised_vertices import rates_of, vertex_rates
from frictool.plant.polytope import PARAMETERS, Parameter, PlantPoint, Polytope
from studies.rigs.annex_model import KNEE, annex_model
from studies.rigs.clutch_model import clutch_model

ALL: tuple[Parameter, ...] = (*PARAMETERS, "regime")


@pytest.mark.parametrize(
    "scheduled", [names for size in range(1, 6) for names in itertools.combinations(ALL, size)]
)
def test_any_choice_of_parameters_spans_its_own_vertices(scheduled: tuple[Parameter, ...]) -> None:
    box = polytope(annex_model(), scheduled)
    assert box.scheduled == scheduled
    assert len(box.vertices) == len({v.name for v in box.vertices})
    assert len(box.vertices) <= 2 ** len(scheduled)
    if not {"regime", "viscous"} <= set(
        scheduled
    ):  # below the knee there is no slope whose ends could differ
        assert len(box.vertices) == 2 ** len(scheduled)
    middle = {name: 0.5 * sum(ends) for name, ends in intervals(annex_model()).items()}
    for name in {"inertia", "constant"} - set(scheduled):
        assert {getattr(v, name) for v in box.vertices} == {middle[name]}
    if "regime" not in scheduled:
        for name in set(PARAMETERS) - set(scheduled):
            assert {getattr(v, name) for v in box.vertices} == {middle[name]}


def test_thirty_two_vertices_where_there_is_viscous_friction_below_the_knee_too() -> None:
    model = annex_model()
    slow = Estimate(value=1e-4, low=0.5e-4, high=1.5e-4, unit="N m s/rad", source="identified")
    model = msgspec.structs.replace(
        model, parameters=msgspec.structs.replace(model.parameters, viscous=slow)
    )
    assert len(polytope(model, ALL).vertices) == 32


def test_annex_31() -> None:
    box = polytope(annex_model(), ("regime",))
    slow, fast = box.vertices
    assert (slow.viscous, slow.coulomb) == (0.0, 0.127)
    assert (fast.viscous, fast.coulomb) == (7.6e-4, pytest.approx(0.127 - 7.6e-4 * KNEE))
    assert box.centre.viscous == pytest.approx(3.8e-4)


@given(
    slopes=st.lists(st.floats(0.0, 1e-3), min_size=2, max_size=4),
    gaps=st.lists(st.floats(1.0, 200.0), min_size=3, max_size=3),
    force=st.floats(0.01, 0.2),
)
def test_each_regimes_tangent_is_the_friction_there(
    slopes: list[float], gaps: list[float], force: float
) -> None:
    """Continuous at every knee, and on each tangent between them: the friction law as the engine
    has it."""
    knees = list(itertools.accumulate(gaps[: len(slopes) - 1]))
    model = clutch_model(coulomb=(force, force, force))
    found = [Estimate(value=s, unit="N m s/rad", source="identified") for s in slopes]
    regimes = tuple(
        Regime(above=Quantity(value=v, unit="rad/s"), viscous=s)
        for v, s in zip(knees, found[1:], strict=True)
    )
    bench = msgspec.structs.replace(
        model.bench,
        mechanics=msgspec.structs.replace(
            model.bench.mechanics, coulomb=Quantity(value=force, unit="N m")
        ),
    )
    model = msgspec.structs.replace(
        model,
        bench=bench,
        parameters=msgspec.structs.replace(model.parameters, viscous=found[0]),
        laws=Laws(regimes=regimes),
    )
    friction, speeds = force, [0.0, *knees, knees[-1] + 50.0]
    tangents = {(v.viscous, v.coulomb) for v in polytope(model, ("regime",)).vertices}
    for slope, begin, end in zip(slopes, speeds, speeds[1:], strict=False):
        friction_at_begin, friction = friction, friction + slope * (end - begin)
        on = [
            math.isclose(f + s * begin, friction_at_begin, abs_tol=1e-9)
            and math.isclose(f + s * end, friction, abs_tol=1e-9)
            for s, f in tangents
        ]
        assert any(on)


def test_regimes_that_the_model_has_not_are_refused() -> None:
    with pytest.raises(FrictoolError, match=r"has no laws.regimes"):
        polytope(clutch_model(), ("inertia", "regime"))


@pytest.mark.parametrize("scheduled", [(), ("inertia", "inertia")])
def test_an_empty_or_doubled_list_is_refused(scheduled: tuple[Parameter, ...]) -> None:
    with pytest.raises(ValueError, match="allowed: 1 to 5 different names"):
        polytope(clutch_model(), scheduled)


@settings(max_examples=30, deadline=None)
@given(where=st.tuples(*[st.floats(0.0, 1.0)] * 4))
def test_every_plant_of_the_box_is_in_the_hull_of_the_exact_vertices(
    where: tuple[float, ...],
) -> None:
    box = intervals(clutch_model())
    inside = PlantPoint(
        "p",
        *(
            low + share * (high - low)
            for share, (low, high) in zip(where, box.values(), strict=True)
        ),
    )
    corners = np.array(
        [[r.drive, r.viscous, r.friction] for r in vertex_rates(polytope(clutch_model()))]
    ).T
    scale = corners.max(axis=1, keepdims=True)
    wanted = (
        np.array([[inside.rates.drive], [inside.rates.viscous], [inside.rates.friction]]) / scale
    )
    found = linprog(
        np.zeros(corners.shape[1]),
        A_eq=np.vstack([corners / scale, np.ones(corners.shape[1])]),
        b_eq=np.append(wanted[:, 0], 1.0),
        bounds=(0, None),
    )
    assert found.success


def test_the_linearised_vertices_are_the_exact_ones_to_second_order() -> None:
    """(5.49) and (5.50): halving the deviation divides the error by four, and only (5.50) is
    affine."""
    centre = PlantPoint("centre", 1.32e-5, 3.81e-4, 0.099, 0.0134)

    def moved(share: float) -> PlantPoint:
        scale = 1.0 + 0.2 * share
        return PlantPoint(
            "p",
            centre.inertia * scale,
            centre.viscous * scale**3,
            centre.coulomb / scale,
            centre.constant / scale**2,
        )

    for form in ("inertia", "first_order"):
        far, near = (
            abs(rates_of(moved(s), centre, form).drive / moved(s).rates.drive - 1.0)
            for s in (0.2, 0.1)
        )
        assert 3.4 < far / near < 4.6
    box = polytope(clutch_model())
    affine = np.array([[r.drive, r.viscous, r.friction] for r in vertex_rates(box, "first_order")])
    mean = np.array([box.centre.rates.drive, box.centre.rates.viscous, box.centre.rates.friction])
    assert affine.mean(axis=0) == pytest.approx(mean, rel=1e-12)
    products = np.array([r.viscous for r in vertex_rates(box, "inertia")])
    exact = np.array([r.viscous for r in vertex_rates(box)])
    assert products == pytest.approx(
        exact, rel=0.026
    )  # (dJ/J0)^2 = 0.0253 at the ends of table 5.2
    assert not np.allclose(products, exact, rtol=0.02)


def test_an_inertia_that_more_than_doubles_cannot_be_linearised() -> None:
    light, heavy = PlantPoint("v1", 1.0, 0.1, 0.1, 1.0), PlantPoint("v2", 12.0, 0.1, 0.1, 1.0)
    box = Polytope(PlantPoint("centre", 5.9, 0.1, 0.1, 1.0), (light, heavy))
    with pytest.raises(NoSolutionError, match="too wide"):
        vertex_rates(box, "first_order")
    assert vertex_rates(box)[1].drive == pytest.approx(1.0 / 12.0)
