"""`identify --plot` and `--page`: what is drawn where, the same bytes each time, and that the
curves are those of the model that is simulated."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from frictool.adapters.axis_model import axis_of
from frictool.documents.model import Model
from frictool.documents.registry import load
from frictool.engine.axis_motion import advance
from frictool.identify.model_page.evidence import friction_over_speed
from frictool.plant.axis import VELOCITY, rest
from studies.command_line import run
from tests.support.command_line import also_called, refused
from tests.support.short_logs import first_part

ROOT = Path(__file__).parents[2]
BENCH, SAMPLES = ROOT / "configs" / "clutch" / "bench.yaml", ROOT / "sample_logs"
NONLINEAR = load(ROOT / "configs" / "clutch" / "nonlinear.yaml", Model)


@given(st.floats(1.0, 390.0), st.sampled_from([1.0, -1.0]))
def test_the_curve_over_speed_is_the_friction_that_the_engine_has(
    speed: float, side: float
) -> None:
    """The friction is the loss of the engine's speed in a microsecond without an effort, without
    the shape over the position."""
    axis = axis_of(NONLINEAR)
    axis = axis._replace(laws=axis.laws._replace(shape=None), backlash=0.0)
    p, state, period = axis.as_array(), rest(30.0), 1e-6
    state[VELOCITY] = side * speed
    assert advance(state, 0.0, p, period) == 0
    lost = axis.inertia * (speed - side * state[VELOCITY]) / period
    assert friction_over_speed(NONLINEAR, np.array([speed]), side)[0] == pytest.approx(
        lost, rel=1e-4
    )


def line(folder: Path) -> tuple[object, ...]:
    """Return the command that identifies the logs of a folder."""
    return ("identify", folder / "sines.csv", "--ramp", folder / "ramp.csv", "--bench", BENCH)


@pytest.fixture(scope="module")
def drawn(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the beginning of the sample logs, their model, its picture, its page and the
    text on standard output."""
    folder = tmp_path_factory.mktemp("drawn")
    for name in ("sines.csv", "ramp.csv"):
        (folder / name).write_text(first_part(name))
    views = ("--plot", folder / "model.svg", "--page", folder / "model.html")
    result = run(*line(folder), *views, "-o", folder / "model.yaml")
    assert result.code == 0
    (folder / "text").write_text(result.stdout)
    return folder


@pytest.mark.accept
def test_picture_and_page_are_the_same_bytes_twice(drawn: Path, tmp_path: Path) -> None:
    views = ("--plot", tmp_path / "model.svg", "--page", tmp_path / "model.html")
    assert run(*line(drawn), *views, "-o", tmp_path / "model.yaml").code == 0
    for name in ("model.svg", "model.html"):
        assert (tmp_path / name).read_bytes() == (drawn / name).read_bytes()


def test_text_and_stdout_and_the_model_s_bytes_twice(drawn: Path) -> None:
    piped = run(*line(drawn), "-o", "-")
    assert piped.out == (drawn / "model.yaml").read_bytes()
    for words in (
        "inertia by weak",
        "differences of samples by up to",
        "identified",
        "interval at 95 %",
        "onsets",
    ):
        assert words in (drawn / "text").read_text()
        assert words in piped.stderr


def test_sines_and_ramps_are_drawn_over_speed_and_position(drawn: Path) -> None:
    text = (drawn / "model.svg").read_text()
    for words in (
        "speed [rad/s]",
        "position [rad]",
        "breakaways backward",
        "friction in slip [N m]",
    ):
        assert words in text
    assert "velocity [rad/s]" not in text  # no map: friction is the same everywhere


def test_the_page_has_every_figure_and_no_request(drawn: Path) -> None:
    text = (drawn / "model.html").read_text()
    for title in (
        "Friction over speed",
        "Breakaway over position",
        "Residual over position",
        "Residual over time",
        "Spectrum of the residual",
        "Strokes left out of the fit: fit 9",
        "Intervals and the bench&#39;s ranges",
        "What was tried",
        "What to measure next",
    ):
        assert f">{title}" in text, title
    assert "Content-Security-Policy" in text
    assert "<link" not in text
    assert "Absolute interval" in text


def test_without_a_stroke_the_breakaways_are_drawn_and_no_map(tmp_path: Path) -> None:
    plot = tmp_path / "a.svg"
    command = ("identify", "--ramp", SAMPLES / "ramp.csv", "--bench", BENCH, "--plot", plot)
    assert run(*command).code == 0
    text = plot.read_text()
    assert "breakaways forward" in text
    assert "velocity [rad/s]" not in text


def test_a_log_is_not_overwritten_by_its_picture(tmp_path: Path) -> None:
    log = tmp_path / "sines.csv"
    log.write_bytes((SAMPLES / "sines.csv").read_bytes())
    refused(
        run("identify", log, "--bench", BENCH, "--plot", also_called(log, ".svg")), 3, "is an input"
    )
    assert log.read_bytes() == (SAMPLES / "sines.csv").read_bytes()
