"""Text of the proof of rest for the output of `synth` and `verify`."""

from __future__ import annotations

from frictool.documents.certificate import Certificate, RestCheck
from frictool.documents.controller import Controller
from frictool.documents.quantity import Axis, si_unit
from frictool.verify.rest_proof import prove_rest

# quantity of the figures of each check, and its wording
WORDS = {
    "breakaway": ("effort", "least friction of the box {value}, above {limit}"),
    "band": ("position", "band {value}, one encoder count {limit}"),
    "released_effort": (
        "effort",
        "effort of the released drive {value}, half of the friction {limit}",
    ),
    "count_pulse": (
        "effort",
        "effort of the released drive after one count {value}, limit {limit}",
    ),
    "frozen_integrator": (None, "integrators are held while the drive is released"),
    "arrival_speed": (
        "velocity",
        "speed of arrival {value}; the axis stops in the band if this is at most {limit}",
    ),
    "stable_loop": (None, "largest sensitivity of the linear loop: below {value} (proved)"),
}
BEYOND = "the axis may cross the band before it rests"


def rest_lines(controller: Controller, certificate: Certificate) -> list[str]:
    """Return the proof of rest, its hypotheses, and the limit cycle as lines of text."""
    cycle, rest, axis = certificate.cycle, certificate.rest, controller.axis
    position, speed, effort = (si_unit(name, axis) for name in ("position", "velocity", "effort"))
    if cycle is not None:
        return [
            f"rest: REFUTED: the nominal plant cycles at the reference {cycle.reference:.4g} "
            f"{position}: amplitude {cycle.amplitude:.4g} {position}, period {cycle.period_s:.4g} s"
        ]
    if rest is None:
        if prove_rest(controller, certificate) is not None:
            return ["rest: this document states no proof for its band; run `frictool synth` again"]
        return ["rest: no band in which the drive is released, so that nothing is proved"]
    if rest.verdict == "proved":
        head = (
            "rest: proved for every plant of the box: an axis at rest in the band stays there for "
            f"disturbances below {rest.disturbance:.4g} {effort}"
        )
        lines = [head]
        if rest.speed > 0.0:
            lines.append(
                f"  an axis released at the target at up to {rest.speed:.4g} {speed} stops in the "
                f"band within {rest.stop_time_s:.3g} s, for disturbances up to "
                f"{rest.stopping_disturbance:.4g} {effort}"
            )
    else:
        lines = ["rest: undecided"]
    return [*lines, *(_check(check, axis) for check in rest.checks)]


def _check(check: RestCheck, axis: Axis) -> str:
    quantity, words = WORDS[check.name]
    unit = f" {si_unit(quantity, axis)}" if quantity else ""
    figures = words.format(value=f"{check.value:.4g}{unit}", limit=f"{check.limit:.4g}{unit}")
    more = f": {BEYOND}" if check.name == "arrival_speed" and check.state != "holds" else ""
    return f"  {check.state}: {figures}{more}"
