"""Chapter 6 on the SIMULATED clutch: the tests of 6.3.2 and 6.4.2, by frictool's commands.

The figures are 6.1, 6.2 and 6.4 to 6.10.
"""

from __future__ import annotations

import math
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from frictool.documents.model import Model
from frictool.documents.observer import Observer
from frictool.documents.registry import load
from frictool.documents.writing import to_yaml
from frictool.logs.log_reader import read_log
from frictool.observe.design.friction_map import friction_at, friction_map
from frictool.observe.observer_run import ObserverOutput
from frictool.typing import Vector
from studies.clutch.rig import CLUTCH, controller
from studies.command_line import run_checked
from studies.observers.switched_observers import (
    DESIGNS,
    OPTIONS,
    PLANTS,
    First,
    Second,
    Truth,
    first,
    found_in,
    second,
    slipping,
    truth,
)
from studies.thesis.drawing import Curve, Row, draw
from studies.thesis.results import Part

LOOPS = {"first": "rst", "second": "linear"}
KINDS = ("multiplicative", "additive")
SLOWER = 2.0  # ratio of the speed errors (second to first test) that counts as "larger"
WITHIN = 0.05
INTERVALS = 20  # of the position, of the observer that is drawn
ZOOM = (4.5, 7.0)  # s, about the onset of the wear


@dataclass(frozen=True)
class Ran:
    """Results of one observer along the log of a test."""

    figures: First | Second
    known: Truth
    found: ObserverOutput
    position: Vector
    observer: Observer


def observers() -> Part:
    """Return the part with both tests: both observers, and the theorem as printed."""
    part = Part()
    ran = {test: _played(test) for test in LOOPS}
    _first(part, ran["first"])
    _second(part, ran["second"], ran["first"])
    _map(part)
    _draw(part, ran)
    return part


def _played(test: str) -> dict[str, Ran]:
    """Return the results of each design of configs/clutch/Makefile along the test's log."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        model, law, log = folder / "model.yaml", folder / "controller.yaml", folder / "run.mcap"
        model.write_bytes(PLANTS[test].read_bytes())
        law.write_text(to_yaml(controller(LOOPS[test])))
        run_checked(
            "simulate",
            model,
            "--controller",
            law,
            "--scenario",
            CLUTCH / f"observers/{test}.yaml",
            "-o",
            log,
        )
        stream, found = read_log(log).streams[0], {}
        known = truth(load(model, Model), stream)
        for kind, options in DESIGNS.items():
            design, estimates = folder / f"{kind}.yaml", folder / f"{kind}.mcap"
            run_checked(
                "observe",
                "design",
                model,
                *options,
                *OPTIONS[test],
                "-o",
                design,
            )
            run_checked("observe", "run", model, log, "--observer", design, "-o", estimates)
            observer, along = load(design, Observer), found_in(read_log(estimates))
            figures = (
                first(known, along, observer) if test == "first" else second(known, along, observer)
            )
            found[kind] = Ran(figures, known, along, stream.signals["position_true"], observer)
        return found


def _first(part: Part, ran: dict[str, Ran]) -> None:
    for kind in KINDS:
        found = ran[kind].figures
        assert isinstance(found, First)
        part.add(
            "section_6_3_2",
            {f"{kind}.first": "converges" if math.isfinite(found.settled) else "does not"},
        )
        printed = ran[f"{kind}_printed"].figures
        assert isinstance(printed, First)
        settled = "never" if math.isinf(printed.settled) else f"after {printed.settled:.2f} s"
        part.say(
            "section_6_3_2",
            f"{kind}: within {100 * WITHIN:g} % after {found.settled:.2f} s, friction's error "
            f"{found.friction:.1f} %; with the theorem's "
            f"inequalities alone, without a decay: {settled}, friction's error "
            f"{printed.friction:.0f} %.",
        )
    factor = ran["multiplicative"].figures
    assert isinstance(factor, First)
    part.add("section_6_3_2", {"alpha_before": factor.before, "alpha_after": factor.after})


def _second(part: Part, ran: dict[str, Ran], before: dict[str, Ran]) -> None:
    for kind in KINDS:
        larger = ran[kind].figures.velocity > SLOWER * before[kind].figures.velocity
        part.add("section_6_3_2", {f"{kind}.speed": "larger" if larger else "not larger"})
        part.say(
            "section_6_3_2",
            f"{kind}, speed's error: {before[kind].figures.velocity:.2f} rad/s in the first test, "
            f"{ran[kind].figures.velocity:.1f} in the second.",
        )
    factor, added = (ran[kind].figures for kind in KINDS)
    assert isinstance(factor, Second)
    assert isinstance(added, Second)
    off = max(abs(mean - 1.0) for mean in factor.series)
    part.add("section_6_3_2", {"alpha_second": "not 1" if off > 0.02 else "1"})
    part.add("section_6_4_2", {"alpha_low": added.low, "alpha_high": added.high})
    part.add("section_6_4_2", {"friction": "wrong" if added.friction > 10.0 else "right"})
    part.say(
        "section_6_3_2",
        f"Second test: alpha is {factor.series[0]:.3f} and {factor.series[1]:.3f} in the two "
        "series of steps, and moves between "
        f"{factor.low:.3f} and {factor.high:.3f}.",
    )
    part.say("section_6_4_2", f"Second test: friction's error {added.friction:.0f} % rms.")


def _map(part: Part) -> None:
    """Draw figures 6.1 and 6.2: the friction f, and its levels in the cells of the observer."""
    model = load(PLANTS["first"], Model)
    known, theta = friction_map(model), np.linspace(0.0, 63.0, 631)
    forward, backward = (np.asarray(friction_at(known, side, theta)) for side in (1, -1))
    part.draw(
        "6.1",
        f"Forward {forward.min():.3f} to {forward.max():.3f} N m, backward {backward.min():.3f} "
        f"to {backward.max():.3f} N m.",
        draw(
            "friction f",
            "theta, rad",
            [("f, N m", [Curve(theta, forward, "forward"), Curve(theta, -backward, "backward")])],
        ),
    )
    edges = np.linspace(theta[0], theta[-1], INTERVALS + 1)
    middles = 0.5 * (edges[:-1] + edges[1:])
    steps = np.repeat(np.asarray(friction_at(known, 1, middles)), 2)
    ends = np.column_stack((edges[:-1], edges[1:])).ravel()
    level = steps[::2][np.minimum(np.searchsorted(edges, theta, side="right") - 1, INTERVALS - 1)]
    part.draw(
        "6.2",
        f"{INTERVALS} levels forward, each f at its interval's middle: at most "
        f"{float(np.max(np.abs(level - forward))):.4f} N m off.",
        draw(
            "levels of f",
            "theta, rad",
            [("f_m, N m", [Curve(theta, forward, "f"), Curve(ends, steps, "f_m")])],
            thin=False,
        ),
    )


def _draw(part: Part, ran: dict[str, dict[str, Ran]]) -> None:
    for state, errors, test, kind in (
        ("6.4", "6.5", "first", "multiplicative"),
        ("6.6", "6.7", "second", "multiplicative"),
    ):
        _states(part, state, ran[test][kind], "alpha")
        _frictions(part, errors, test, ran[test][kind])
    _states(part, "6.8", ran["first"]["additive"], "alpha, N m")
    _states(part, "6.9", ran["second"]["additive"], "alpha, N m")
    _frictions(part, "6.10", "second", ran["second"]["additive"])


def _states(part: Part, number: str, ran: Ran, label: str) -> None:
    known, found = ran.known, ran.found
    assert found.wear is not None
    speed = found.velocity - known.velocity
    rows: list[Row] = [
        ("theta, rad", [Curve(known.time, ran.position)]),
        ("e_omega, rad/s", [Curve(known.time, speed)]),
        (label, [Curve(known.time, found.wear)]),
    ]
    caption = (
        f"Speed's error {float(np.sqrt(np.mean(speed**2))):.2f} rad/s rms; alpha "
        f"{found.wear[-1]:.3f} at the end"
    )
    part.draw(
        number,
        f"{caption}, between {found.wear.min():.3f} and {found.wear.max():.3f}.",
        draw(f"figure {number}", "t, s", rows),
    )


def _frictions(part: Part, number: str, test: str, ran: Ran) -> None:
    known, found = ran.known, ran.found
    shown = (known.time >= ZOOM[0]) & (known.time <= ZOOM[1])
    both = shown & slipping(known, found, ran.observer)
    error = 100.0 * float(
        np.sqrt(
            np.mean((found.friction - known.friction)[both] ** 2)
            / np.mean(known.friction[both] ** 2)
        )
    )
    curves = [
        Curve(known.time[shown], found.friction[shown], "estimated"),
        Curve(known.time[shown], known.friction[shown], "simulated"),
    ]
    part.draw(
        number,
        f"Friction estimated where the axis slips: {error:.0f} % rms off in these "
        f"{ZOOM[1] - ZOOM[0]:g} s of the {test} test.",
        draw(f"figure {number}", "t, s", [("f, N m", curves)]),
    )
