"""Two logs of one scenario compared: what counts as the same response, and what does not. And the
clutch's own, in the loop."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from frictool.documents.writing import to_yaml
from frictool.logs.log import Stream
from frictool.reduce.loop_comparison import in_loop
from studies.command_line import run
from studies.rigs.clutch_model import ROOT, clutch_model

TIME = np.arange(2000) * 1e-3
RIG = ROOT / "configs/clutch"


def log(lag: float, offset: float = 0.0) -> Stream:
    """A step of 10 rad at 0.5 s, answered by a first-order lag."""
    reference = np.where(TIME < 0.5, 0.0, 10.0)
    position = np.where(TIME < 0.5, 0.0, 10.0 * -np.expm1(-(TIME - 0.5) / lag) + offset)
    return Stream(
        "/axis",
        TIME,
        {"reference": reference, "position_true": position},
        {"reference": "rad", "position_true": "rad"},
    )


def test_response_times_are_those_of_each() -> None:
    found = in_loop(log(0.1), log(0.102), resolution=0.1, play=0.5, tolerance=0.05)
    assert found.refused is None
    step = found.steps[-1]
    assert step.whole_s == pytest.approx(0.1 * np.log(20.0), rel=2e-2)
    assert step.reduced_s == pytest.approx(1.02 * step.whole_s, rel=1e-2)
    assert (step.origin, step.target) == (0.0, 10.0)


@pytest.mark.parametrize(
    ("other", "words"),
    [
        (log(0.1, 1.2), "positions differ by 1.2; allowed: at most 1"),
        (log(0.107), "response time"),
        (log(100.0), "positions differ by"),
    ],
)
def test_what_is_beyond_is_refused_with_the_step(other: Stream, words: str) -> None:
    refused = in_loop(log(0.1), other, resolution=0.1, play=0.5, tolerance=0.05).refused
    assert refused is not None
    assert refused.startswith("step at 0.5 s: ")
    assert words in refused


def test_the_exhaustive_clutch_and_its_one_inertia_take_a_step_alike(tmp_path: Path) -> None:
    """Two steps of 5.4 under the design of the speed loop: rotors within the backlash, response
    times within 5 %."""
    (tmp_path / "model.yaml").write_text(to_yaml(clutch_model()))
    arguments = [
        "--spec",
        RIG / "spec.yaml",
        "--design",
        RIG / "designs/speed.yaml",
        "--vertices-only",
        "--no-play",
        "-o",
        tmp_path / "controller.yaml",
    ]
    assert run("synth", tmp_path / "model.yaml", *arguments).code == 0
    scenario = "\n".join(
        [
            "format: scenario/1",
            "name: two steps",
            "axis: rotary",
            "start: {value: 5, unit: rad}",
            "steps:",
            "  - {reference: {value: 55, unit: rad}, duration_s: 1.1}",
            "  - {reference: {value: 15, unit: rad}, duration_s: 1.1}",
        ]
    )
    (tmp_path / "steps.yaml").write_text(scenario + "\n")
    both = ["--controller", tmp_path / "controller.yaml", "--scenario", tmp_path / "steps.yaml"]
    result = run("reduce", RIG / "mechanism.yaml", *both, "-o", tmp_path / "reduced.yaml", "--json")
    assert result.code == 0, result.stderr
    told = json.loads(result.stdout)
    assert told["in_loop"]["agree"]
    for step in told["in_loop"]["steps"]:
        assert step["distance"] < 3.0
        assert abs(step["reduced_s"] / step["whole_s"] - 1.0) < 0.05
    # of the way of each run, there and back
    assert told["steps"][-1]["measured"]["share"] < 0.01
