"""A controller document that no longer is what was verified is refused, by whoever is to rely on
it."""

from __future__ import annotations

from pathlib import Path

import msgspec
import pytest

from frictool.documents.controller import Controller
from frictool.documents.writing import to_yaml
from frictool.errors import NoSolutionError
from frictool.verify.recheck import recheck
from studies.command_line import run
from tests.support.clutch_speed_controller import clutch_speed_controller
from tests.support.command_line import refused


def _claiming(controller: Controller, margin: float) -> Controller:
    first = controller.verified.vertices[0]
    vertices = (
        msgspec.structs.replace(first, modulus_margin=margin),
        *controller.verified.vertices[1:],
    )
    return msgspec.structs.replace(
        controller, verified=msgspec.structs.replace(controller.verified, vertices=vertices)
    )


def _with_coefficient(controller: Controller, factor: float) -> Controller:
    speed, ((d,),) = controller.linear, controller.linear.discrete.d
    discrete = msgspec.structs.replace(speed.discrete, d=((d * factor,),))
    return msgspec.structs.replace(
        controller, linear=msgspec.structs.replace(speed, discrete=discrete)
    )


def test_what_was_verified_passes() -> None:
    recheck(clutch_speed_controller())


@pytest.mark.parametrize(
    "changed", [lambda c: _claiming(c, 0.99), lambda c: _with_coefficient(c, 1.05)]
)
def test_a_margin_that_the_coefficients_do_not_give_is_refused(changed: object) -> None:
    with pytest.raises(NoSolutionError, match=r"vertex v01 .* margin of 0\.\d+"):
        recheck(changed(clutch_speed_controller()))


def test_an_unstable_loop_is_refused() -> None:
    with pytest.raises(NoSolutionError, match="unstable with"):
        recheck(_with_coefficient(clutch_speed_controller(), 20.0))


def test_a_controller_without_vertices_is_refused() -> None:
    controller = clutch_speed_controller()
    empty = msgspec.structs.replace(
        controller, verified=msgspec.structs.replace(controller.verified, vertices=())
    )
    with pytest.raises(NoSolutionError, match="names no vertex"):
        recheck(empty)


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("axis", "linear"),
        ("drive", "voltage"),
        ("sample_period_s", 0.0011),
        ("delay_samples", 0),
        ("delay_samples", 2),
    ],
)
def test_a_document_that_is_not_of_its_bench_is_refused(key: str, value: object) -> None:
    with pytest.raises(
        NoSolutionError, match=f"{key}: found {value}, but the document's bench has"
    ):
        recheck(msgspec.structs.replace(clutch_speed_controller(), **{key: value}))


def test_a_specified_margin_that_it_does_not_hold_is_refused() -> None:
    controller = clutch_speed_controller()
    claiming = msgspec.structs.replace(controller.verified, modulus_margin_specified=0.99)
    with pytest.raises(
        NoSolutionError, match=r"the modulus margin is 0\.\d+, below the specified 0.99"
    ):
        recheck(msgspec.structs.replace(controller, verified=claiming))


def test_coefficients_at_the_end_of_the_range_are_refused() -> None:
    with pytest.raises(NoSolutionError, match="cannot be evaluated"):
        recheck(_with_coefficient(clutch_speed_controller(), 1e300))


def test_export_refuses_it_and_writes_nothing(tmp_path: Path) -> None:
    path = tmp_path / "controller.yaml"
    path.write_text(to_yaml(_with_coefficient(clutch_speed_controller(), 1.2)))
    refused(run("export", path, "-o", tmp_path / "c"), 4, "not verified", "vertex v01")
    assert not (tmp_path / "c").exists()
