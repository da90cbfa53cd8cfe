"""The advice of a refusal passes, and a little beyond it does not."""

from __future__ import annotations

import re
from pathlib import Path

import msgspec
import numpy as np
import pytest

from frictool.adapters.mechanism.assembly import assemble
from frictool.documents.mechanism import Curve, Mechanism, Spring
from frictool.documents.quantity import Series, Span
from frictool.documents.registry import load
from frictool.documents.writing import to_yaml
from frictool.errors import NoSolutionError
from frictool.reduce.advice import parts_of_travel, passing_bandwidth
from frictool.reduce.partial_travel import restrict_travel
from frictool.reduce.reduction_chain import chain
from studies.command_line import run
from tests.support.small_mechanisms import belt, coulomb, lossy_train, mechanism, rotor


def _error(bandwidth: float) -> float:
    return next(
        step.report.predicted
        for step in chain(belt(), bandwidth).steps
        if step.report.step == "compliance"
    )


@pytest.mark.parametrize("tolerance", [0.01, 0.05, 0.2])
def test_the_bandwidth_told_is_the_largest_that_passes(tolerance: float) -> None:
    passing = passing_bandwidth(belt(), tolerance)
    assert passing is not None
    assert _error(passing) <= tolerance < _error(1.02 * passing)


def test_a_mechanism_that_does_not_yield_has_none() -> None:
    assert passing_bandwidth(lossy_train(), 0.05) is None


def returned(low: float, high: float) -> Mechanism:
    """A rotor between two springs that change at 0.2 rad, by more than friction holds."""
    force = Curve(Series((-1.0, 0.19, 0.21, 2.0), "rad"), Series((-0.6, -0.5, 0.5, 0.7), "N m"))
    links = {"springs": Spring(("plate", "ground"), force=force), "shaft": coulomb("plate", 0.05)}
    return mechanism({"plate": rotor(1e-3)}, links, "plate", "plate", travel=(low, high))


def test_a_kink_is_refused_with_both_sides_of_it_that_pass() -> None:
    with pytest.raises(NoSolutionError, match=r"the best law of model\.yaml") as caught:
        chain(returned(-1.0, 2.0), None)
    told = re.findall(r"--travel (\S+) (\S+?)[ ,]", str(caught.value))
    assert len(told) == 2
    (low, below), (above, high) = [tuple(map(float, one)) for one in told]
    assert (low, high) == (-1.0, 2.0)
    assert 0.0 <= below <= 0.19 < 0.21 <= above <= 0.4  # the curve is smooth between its points
    for ends, load_, at in (((low, below), -0.6, low), ((above, high), 0.7, high)):
        part = chain(restrict_travel(returned(-1.0, 2.0), ends), None).one
        assert part.residual.at(np.array([at]))[0] == pytest.approx(
            load_, abs=0.05
        )  # but for what friction holds of it
        assert part.travel == ends
    with pytest.raises(NoSolutionError):
        chain(restrict_travel(returned(-1.0, 2.0), (0.0, high)), None)


def test_a_part_that_is_little_of_the_travel_is_not_told() -> None:
    x = np.linspace(0.0, 1.0, 101)
    assert parts_of_travel(x, lambda part: x[part][-1] - x[part][0] < 0.05) == []


def test_steps_before_the_one_that_cannot_be_made_are_told_and_written(tmp_path: Path) -> None:
    (tmp_path / "mechanism.yaml").write_text(to_yaml(returned(-1.0, 2.0)))
    result = run(
        "reduce",
        tmp_path / "mechanism.yaml",
        "--reduced",
        tmp_path / "reduced.yaml",
        "-o",
        tmp_path / "model.yaml",
    )
    assert result.code == 4
    assert "resisting curve" in result.stdout
    assert (
        "the mechanism after the step 'resisting curve', not checked by simulation; no model is "
        "written" in result.stderr
    )
    assert not (tmp_path / "model.yaml").exists()
    assert list(assemble(load(tmp_path / "reduced.yaml", Mechanism)).blocks) == ["plate"]


def test_the_tolerance_told_passes(tmp_path: Path) -> None:
    short = msgspec.structs.replace(lossy_train(0.6), travel=Span(-4.0, 4.0, "rad"))
    path = tmp_path / "mechanism.yaml"
    path.write_text(to_yaml(short))
    result = run("reduce", path)
    assert result.code == 4
    found = re.search(r"try --tolerance (\S+)$", result.stderr.strip())
    assert found is not None, result.stderr
    assert run("reduce", path, "--tolerance", found[1]).code == 0
    assert run("reduce", path, "--tolerance", f"{float(found[1]) - 0.015:g}").code == 4


def test_a_link_that_yields_is_told_the_bandwidth_at_which_it_may_be_rigid(tmp_path: Path) -> None:
    (tmp_path / "mechanism.yaml").write_text(to_yaml(belt()))
    result = run("reduce", tmp_path / "mechanism.yaml")
    assert result.code == 2
    assert (
        f"up to --bandwidth {passing_bandwidth(belt(), 0.05):g}, rigid links change the gain by at "
        "most 5 %" in result.stderr
    )
