"""The two tests of thesis 6.3.2 and 6.4.2 by the product's commands, as make -C configs/clutch
observers does, and the three estimators of wear side by side.

    python -m tests.accept build/accept.json "6.3.2: first test" "6.3.2: second test" "6.3.2: the
    three compared"
"""

from __future__ import annotations

import math
import tempfile
from dataclasses import asdict
from pathlib import Path
from typing import Any

from studies.clutch.rig import CLUTCH, identify_model
from studies.command_line import run_checked
from studies.observers.estimator_comparison import LOOPS, WEARS, Row, compared
from studies.observers.switched_observers import DESIGNS, OPTIONS, PLANTS, First, Second, figures

LAWS = {"rst": "designs/rst.yaml", "linear": "laws/linear.yaml", "speed": "designs/speed.yaml"}
SOON, WITHIN = 1.0, 0.05  # s; relative
SEEDS = 20
RATIO = 5.0  # by which the estimator of `observe run` is better, at least


def played(test: str, loops: tuple[str, ...]) -> dict[str, dict[str, First | Second]]:
    """Each design's figures in each loop of a test."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        own, model = folder / test, identify_model(folder)
        own.mkdir()
        (own / "model.yaml").write_bytes(PLANTS[test].read_bytes())
        for kind, options in DESIGNS.items():
            run_checked(
                "observe",
                "design",
                own / "model.yaml",
                *options,
                *OPTIONS[test],
                "-o",
                own / f"{kind}.yaml",
            )
        for loop in loops:
            controller, log = own / f"{loop}_controller.yaml", own / loop / "run.mcap"
            log.parent.mkdir()
            run_checked(
                "synth",
                model,
                "--spec",
                CLUTCH / "spec.yaml",
                "--design",
                CLUTCH / LAWS[loop],
                "--no-play",
                "-o",
                controller,
            )
            scenario = CLUTCH / f"observers/{test}.yaml"
            run_checked(
                "simulate",
                own / "model.yaml",
                "--controller",
                controller,
                "--scenario",
                scenario,
                "-o",
                log,
            )
            for kind in DESIGNS:
                estimates = own / loop / f"{kind}.mcap"
                run_checked(
                    "observe",
                    "run",
                    own / "model.yaml",
                    log,
                    "--observer",
                    own / f"{kind}.yaml",
                    "-o",
                    estimates,
                )
        return {
            loop: {kind: figures(folder, test, loop, kind) for kind in DESIGNS} for loop in loops
        }


def first_test() -> dict[str, Any]:
    """alpha and f + alpha within 5 % of 1.5 and of 1.5 f, within a second, under the RST and under
    a PID; as printed neither."""
    found, passed = played("first", ("rst", "linear")), True
    for loop in found.values():
        factor, decayed, added = (
            loop["multiplicative"],
            loop["multiplicative_decay"],
            loop["additive"],
        )
        for one in (factor, decayed):
            assert isinstance(one, First)
            passed &= one.settled <= SOON and abs(one.after / 1.5 - 1.0) <= WITHIN
        assert isinstance(added, First)
        passed &= added.settled <= SOON and added.friction <= 100.0 * WITHIN
        printed = [loop[f"{kind}_printed"] for kind in ("multiplicative", "additive")]
        passed &= all(
            isinstance(one, First) and math.isinf(one.settled) and one.friction > 300.0 * WITHIN
            for one in printed
        )
    return {"passed": passed, **_told(found)}


def _told(found: dict[str, dict[str, First | Second]]) -> dict[str, Any]:
    """The figures; None where it never settles."""

    def told(one: First | Second) -> dict[str, Any]:
        return {name: None if value == math.inf else value for name, value in asdict(one).items()}

    return {loop: {kind: told(one) for kind, one in each.items()} for loop, each in found.items()}


def second_test() -> dict[str, Any]:
    """Figures 6.6 to 6.10: the speed's error is larger than in the first test, alpha is off 1 and
    moves, an additive one between about -0.1 and 0.15 N m, friction is wrong by tens of per cent;
    gains for a perfect encoder let alpha drift to its bound."""
    found, ideal = played("second", ("linear", "speed")), played("first", ("linear",))["linear"]
    passed = True
    for loop in found.values():
        factor, added = loop["multiplicative"], loop["additive"]
        assert isinstance(factor, Second)
        assert isinstance(added, Second)
        passed &= (
            factor.velocity > 2.0 * ideal["multiplicative"].velocity
            and added.velocity > 2.0 * ideal["additive"].velocity
        )
        passed &= (
            factor.low < 0.95
            and factor.high > 1.05
            and max(abs(mean - 1.0) for mean in factor.series) > 0.02
        )
        passed &= -0.15 < added.low < -0.05 < 0.05 < added.high < 0.2 and added.friction > 10.0
        for kind in ("multiplicative_decay", "additive_decay"):
            passed &= loop[kind].friction > 100.0
    return {"passed": passed, **_told(found)}


def the_three_compared() -> dict[str, Any]:
    """On the second test the estimator's wear is nearer than that of the two switched observers,
    and so are its velocity and friction."""
    passed, rows = True, {}
    for loop in LOOPS:
        for wear in WEARS:
            found = {row.name: row for row in compared(loop, wear, SEEDS)}
            rows |= {f"{loop} {wear:g} {name}": asdict(row) for name, row in found.items()}
            passed &= all(
                _better(found["observe run"], row)
                for name, row in found.items()
                if name != "observe run"
            )
    return {"passed": passed, **rows}


def _better(own: Row, other: Row) -> bool:
    return (
        RATIO * max(abs(own.bias), own.deviation) < abs(other.bias)
        and own.velocity < other.velocity
        and own.friction < other.friction
    )


CHECKS = {
    "6.3.2: first test": first_test,
    "6.3.2: second test": second_test,
    "6.3.2: the three compared": the_three_compared,
}
