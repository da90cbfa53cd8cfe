"""Sections 5.2.4, 5.2.5 and annex C.3: loops of table 5.1 on a mass, simulated by frictool.

The figures are 5.3 to 5.9 and C.2 to C.4.
"""

from __future__ import annotations

import math
from functools import cache

import msgspec
import numpy as np

from frictool.documents.registry import load
from frictool.documents.scenario import Scenario
from frictool.logs.log import Log
from frictool.simulate.closed_loop import simulate_closed_loop
from studies.table_5_1.product_loops import HERE, RIG, controller, model
from studies.table_5_1.published_figures import LOOPS, figures
from studies.thesis.drawing import Curve, Row, draw
from studies.thesis.results import Part

SECONDS = 600.0  # duration of the hold, long enough for a cycle of 36 s
TITLES = {
    "pid": "PID",
    "pid_limiter": "PID and limiter",
    "pi_p": "PI and P",
    "pi_root": "PI and square root",
    "smooth_limiter": "limiter, little friction",
    "smooth_limiter_virtual": "limiter, and virtual friction",
    "smooth_root": "square root, little friction",
    "smooth_root_virtual": "square root, and virtual friction",
}
CYCLE = 1e-4  # m: smallest amplitude of a limit cycle
FIGURES = {  # number: loops, seconds shown
    "5.3": (("pid",), 120.0),
    "5.4": (("pid_limiter",), 10.0),
    "5.5": (("pid_limiter", "pid"), 10.0),
    "5.6": (("pi_p",), 6.0),
    "5.7": (("pi_root",), 6.0),
    "5.8": (("smooth_limiter", "smooth_limiter_virtual"), 8.0),
    "5.9": (("smooth_root", "smooth_root_virtual"), 8.0),
    "C.2": (("pi_p",), 3.0),
    "C.3": (("pi_root",), 3.0),
    "C.4": (("smooth_root", "smooth_root_virtual"), 6.0),
}


@cache
def log_of(name: str) -> Log:
    """Return the log of a step of 1 m under a loop, held for SECONDS."""
    scenario = load(RIG / "step.yaml", Scenario)
    (step,) = scenario.steps
    scenario = msgspec.structs.replace(
        scenario, steps=(msgspec.structs.replace(step, duration_s=SECONDS),)
    )
    return simulate_closed_loop(model(name), controller(name), scenario, HERE)


def mass_loops() -> Part:
    """Return the part with the text's statements about each loop, and its figures."""
    part = Part()
    for name in LOOPS:
        found = figures(log_of(name).streams[0].signals["position_true"])
        part.add("section_5_2_4", {f"{name}.overshoot": _overshoot(found["overshoot_percent"])})
        part.add(
            "section_5_2_4",
            {f"{name}.cycle": "cycles" if found["amplitude_m"] > CYCLE else "rests"},
        )
        part.say("section_5_2_4", f"{TITLES[name]}: {_told(found)}.")
    responses = {
        name: figures(log_of(name).streams[0].signals["position_true"])["response_95_s"]
        for name in LOOPS
    }
    for kind in ("limiter", "root"):
        faster = responses[f"smooth_{kind}_virtual"] < responses[f"smooth_{kind}"]
        part.add("section_5_2_5", {f"{kind}": "faster" if faster else "not faster"})
    for number, (names, seconds) in FIGURES.items():
        part.draw(
            number,
            " ".join(f"{TITLES[name]}: {_told(_figures(name))}." for name in names),
            _drawn(number, names, seconds),
        )
    return part


def _figures(name: str) -> dict[str, float]:
    return figures(log_of(name).streams[0].signals["position_true"])


def _overshoot(percent: float) -> str:
    return "none" if percent < 0.05 else "small" if percent < 5.0 else "large"


def _told(found: dict[str, float]) -> str:
    response = (
        "never settles"
        if math.isinf(found["response_95_s"])
        else f"response {found['response_95_s']:.2f} s"
    )
    cycle = (
        f"cycles ±{found['amplitude_m']:.4f} m, {found['period_s']:.2f} s"
        if found["amplitude_m"] > CYCLE
        else "rests"
    )
    return (
        f"overshoot {found['overshoot_percent']:.1f} %, {response}, {cycle}, largest error at "
        f"the end {found['static_error_m']:.4f} m"
    )


def _drawn(number: str, names: tuple[str, ...], seconds: float) -> str:
    rows: list[Row] = [("x, m", []), ("v, m/s", [])]
    if number.startswith("C"):
        rows.append(("u, N", []))
    for name in names:
        stream = log_of(name).streams[0]
        shown = stream.time <= seconds
        time, signals = stream.time[shown], stream.signals
        label = TITLES[name] if len(names) > 1 else ""
        rows[0][1].append(Curve(time, signals["position_true"][shown], label))
        rows[1][1].append(Curve(time, signals["velocity"][shown]))
        if len(rows) > 2:
            rows[2][1].append(Curve(time, signals["effort"][shown]))
    rows[0][1].append(Curve(np.array([0.0, seconds]), np.ones(2), "reference", "reference"))
    return draw(f"figure {number}", "t, s", rows)
