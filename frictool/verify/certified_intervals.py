"""Check whether a plant and its bench are among those for which a controller was verified."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from frictool.adapters.parameter_intervals import bench_intervals, intervals
from frictool.documents.bench import Bench
from frictool.documents.controller import Controller
from frictool.documents.model import Model
from frictool.documents.name_list import listed
from frictool.plant.polytope import PARAMETERS
from frictool.verify.document_box import box_of
from frictool.verify.loop_wording import plant_units
from frictool.verify.rig_facts import ROUNDING, different_facts, different_stiffness, facts_of

MARGIN_PARAMETERS = (
    "inertia",
    "viscous",
    "constant",
)  # a margin depends on these parameters only; a norm also depends on Coulomb friction

LONGEST_PHRASES = 80  # largest number of characters of all phrases in a warning
Interval = tuple[float, float]


def differences(
    controller: Controller, facts: Mapping[str, float], ranges: Mapping[str, Interval]
) -> tuple[str, ...]:
    """Return a phrase for each property of an axis that a controller's verification does not cover.

    - Facts (verify/rig_facts.py), for example the sample period, must be equal to the facts of the
      controller's bench.
    - The loops must have been verified with the stiffness of the spring.
    - The interval of each parameter in `ranges` [SI] must be inside the verified interval.
    """
    bench, stiffness = controller.bench, facts.get("stiffness", 0.0)
    return (
        *different_facts(bench, facts),
        *different_stiffness(bench, controller.stiffness, (stiffness, stiffness)),
        *parameters_outside(controller, ranges),
    )


def model_differences(controller: Controller, model: Model) -> tuple[str, ...]:
    """Return a phrase for each property of `model` that the verification does not cover."""
    load = None if model.laws is None else model.laws.load
    spring = None if load is None else load.stiffness
    ends = (0.0, 0.0) if spring is None else spring.interval
    return (
        *different_stiffness(controller.bench, controller.stiffness, ends),
        *differences(controller, facts_of(model.bench), intervals(model)),
    )


def bench_differences(controller: Controller, bench: Bench) -> tuple[str, ...]:
    """Return a phrase for each property of `bench` that the verification does not cover."""
    ours = controller.bench.actuator.drive
    theirs = bench.actuator.drive
    if ours != theirs:
        return (f"drive {theirs}, verified {ours}",)
    return differences(controller, facts_of(bench), bench_intervals(bench))


def parameters_outside(controller: Controller, ranges: Mapping[str, Interval]) -> tuple[str, ...]:
    """Return a phrase for each parameter whose interval [SI] is not inside the verified interval.

    An interval with an end NaN counts as outside. An example of a phrase is `inertia 4.9e-06 to
    1.53e-05 kg m^2, certified 1.11e-05 to 1.53e-05`.
    """
    known = controller.certificate is not None or bool(controller.verified.vertices)
    box = box_of(controller) if known else {}
    units = plant_units(controller.bench)
    verb = "certified" if controller.certificate is not None else "verified"
    outside = []
    for name in PARAMETERS:
        if name not in ranges or name not in box:
            continue
        (low, high), (least, most) = ranges[name], box[name]
        tolerance = ROUNDING * max(abs(least), abs(most))
        if not (least - tolerance <= low <= high <= most + tolerance):
            shown = f"{low:.6g}" if low == high else f"{low:.6g} to {high:.6g}"
            outside.append(f"{name} {shown} {units[name]}, {verb} {least:.6g} to {most:.6g}")
    return tuple(outside)


def outside_message(controller: str, names: Iterable[str]) -> str:
    """Return a warning with the phrases `names`, without its subject, which the caller adds.

    The warning contains the first phrases and the number of omitted phrases; `verify --model`
    prints all phrases.
    """
    phrases = listed(list(names), LONGEST_PHRASES, "; ")
    return (
        f"is outside the range for which {controller} was verified: {phrases}; the margins do not "
        "apply: run frictool synth again"
    )
