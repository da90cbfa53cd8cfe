"""The load that friction does not hold: which law it becomes, and that the one inertia then moves
as the mechanism does."""

from __future__ import annotations

import math
from pathlib import Path

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.documents.mechanism import Curve, Gear, Mechanism, Spring
from frictool.documents.model import Model
from frictool.documents.quantity import Quantity, Series
from frictool.documents.registry import load
from frictool.documents.writing import to_yaml
from frictool.errors import NoSolutionError
from frictool.reduce.residual_load import LoadUnits, ResidualLoad, fit_residual_load
from frictool.reduce.resistance_curves import DirectedResistance
from studies.command_line import run
from tests.support.small_mechanisms import coulomb, mechanism, rotor

WORDS = LoadUnits("drawn", "N m", "rad")


def arm(ratio: float, weight: float = 3.0, friction: float = 0.02) -> Mechanism:
    """A motor that turns an unbalanced arm by a gear: weight sin(q) over the arm's angle q."""
    q = np.linspace(-2.0, 2.0, 81)
    force = Curve(
        Series(tuple(q.tolist()), "rad"), Series(tuple((weight * np.sin(q)).tolist()), "N m")
    )
    links = {
        "gear": Gear(("motor", "arm"), ratio, internal=True),
        "gravity": Spring(("arm", "ground"), force=force),
        "bearing": coulomb("motor", friction),
    }
    return mechanism(
        {"motor": rotor(4e-5), "arm": rotor(0.1)},
        links,
        "motor",
        "motor",
        travel=(-2.0 / ratio, 2.0 / ratio),
    )


def held(x: np.ndarray, mean: np.ndarray, half: float) -> DirectedResistance:
    return DirectedResistance(mean + half, mean - half, mean + half, mean - half, (), 0.0)


def test_more_than_the_drive_gives_is_played_too(tmp_path: Path) -> None:
    """The arm outweighs the motor over a part of its travel: there nothing moves forward, and
    nothing is divided by no speed."""
    (tmp_path / "mechanism.yaml").write_text(to_yaml(arm(1.0, weight=3.0)))
    assert run("reduce", tmp_path / "mechanism.yaml").code in (0, 4)


@pytest.mark.parametrize("ratio", [0.05, 1.0])
def test_gravity_through_a_gear_is_the_law_that_model_yaml_has(
    tmp_path: Path, ratio: float
) -> None:
    weight = 0.5 / ratio**0.5
    (tmp_path / "mechanism.yaml").write_text(to_yaml(arm(ratio, weight)))
    result = run("reduce", tmp_path / "mechanism.yaml", "-o", tmp_path / "model.yaml")
    assert result.code == 0, result.stderr  # which plays both
    laws = load(tmp_path / "model.yaml", Model).laws
    assert laws is not None
    assert laws.load is not None
    law = laws.load.gravity if ratio == 1.0 else laws.load.ripple
    assert law is not None
    assert law.sine.value == pytest.approx(weight * ratio, rel=1e-3)
    assert law.cosine.value == pytest.approx(0.0, abs=1e-6)
    if laws.load.ripple is not None:
        assert (
            2.0 * math.pi * laws.load.ripple.cycles / laws.load.ripple.per.value
            == pytest.approx(ratio, rel=1e-12)
        )
    assert "load in addition to friction: " in result.stdout


def test_the_interval_of_what_gravity_is_felt_as(tmp_path: Path) -> None:
    """Friction alone is uncertain: gravity has no interval of it, whichever law each end would have
    taken by itself."""
    whole = arm(0.05)
    bearing = msgspec.structs.replace(
        whole.links["bearing"], parameters={"coulomb": Quantity(0.02, 0.01, 0.2, "N m")}
    )
    (tmp_path / "mechanism.yaml").write_text(
        to_yaml(msgspec.structs.replace(whole, links={**whole.links, "bearing": bearing}))
    )
    result = run("reduce", tmp_path / "mechanism.yaml", "-o", tmp_path / "model.yaml")
    assert result.code == 0, result.stderr
    model = load(tmp_path / "model.yaml", Model)
    assert model.laws is not None
    assert model.laws.load is not None
    assert model.laws.load.ripple is not None
    assert model.laws.load.ripple.sine.low is None
    assert model.parameters.coulomb.interval == pytest.approx((0.01, 0.2), rel=1e-3)


@settings(max_examples=15, deadline=None)
@given(st.floats(0.3, 3.0), st.floats(-2.0, 2.0), st.floats(-2.0, 2.0), st.floats(-1.0, 1.0))
def test_a_harmonic_of_any_number_is_found(
    cycles: float, sine: float, cosine: float, offset: float
) -> None:
    x = np.linspace(-3.0, 4.0, 241)
    number = 2.0 * math.pi * cycles / 7.0
    mean = offset + sine * np.sin(number * x) + cosine * np.cos(number * x)
    if np.ptp(mean) < 0.1:
        return
    found = fit_residual_load(
        x, held(x, mean, 0.02), (), WORDS, lambda one: float(np.max(np.abs(one.at(x) - mean)))
    )
    np.testing.assert_allclose(found.at(x), mean, atol=0.02 * (1.0 + 1e-6))


def test_friction_that_holds_all_of_it_leaves_none() -> None:
    x = np.linspace(0.0, 1.0, 50)
    assert (
        fit_residual_load(x, held(x, 0.3 * np.sin(x), 0.3), (1.0,), WORDS, lambda one: 0.0)
        == ResidualLoad()
    )


def test_cogging_that_friction_holds_is_told_beside_it_where_no_polynomial_is_it() -> None:
    x = np.linspace(0.0, 1.0, 241)
    mean = 0.01 * np.sin(40.0 * x)
    found = fit_residual_load(
        x,
        held(x, mean, 0.05),
        (),
        WORDS,
        lambda one: float(np.max(np.abs(one.at(x) - mean))) / 0.05,
    )
    assert found.number == pytest.approx(40.0, rel=1e-6)
    assert math.hypot(found.sine, found.cosine) == pytest.approx(0.01, rel=1e-6)


def test_a_corner_is_no_law() -> None:
    x = np.linspace(-1.0, 1.0, 201)
    with pytest.raises(
        NoSolutionError,
        match=r"friction holds only .*; try --travel -1 \S+ and --travel \S+ 1, with one "
        r"model for each part",
    ):
        fit_residual_load(x, held(x, np.sign(x + 1e-6), 0.01), (), WORDS, lambda one: 0.0)
