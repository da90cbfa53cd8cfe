"""Comparison of a plant's parameters with the intervals for which a controller was verified."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from frictool.documents.controller import Controller
from frictool.plant.polytope import PARAMETERS
from frictool.verify.stated_box import box_of
from frictool.verify.words import plant_units

ROUNDING = 1e-9  # relative: the ends of intervals are sums and products of a document's numbers
MARGIN_PARAMETERS = ("inertia", "viscous", "constant")  # a margin depends on these alone; a norm depends on Coulomb friction too

Interval = tuple[float, float]


def parameters_outside(controller: Controller, intervals: Mapping[str, Interval], names: Iterable[str] = PARAMETERS) -> tuple[str, ...]:
    """Return a phrase for each of `names` whose interval [SI] reaches beyond the controller's.

    An example is `inertia 4.9e-06 to 1.53e-05 kg m^2, certified 1.11e-05 to 1.53e-05`.
    """
    known = controller.certificate is not None or bool(controller.verified.vertices)
    box, units = box_of(controller) if known else {}, plant_units(controller.bench)
    verb = "certified" if controller.certificate is not None else "verified"
    found = []
    for name in names:
        if name not in intervals or name not in box:
            continue
        (low, high), (least, most) = intervals[name], box[name]
        room = ROUNDING * max(abs(least), abs(most))
        if low < least - room or high > most + room:
            shown = f"{low:.6g}" if low == high else f"{low:.6g} to {high:.6g}"
            found.append(f"{name} {shown} {units[name]}, {verb} {least:.6g} to {most:.6g}")
    return tuple(found)


def outside_message(controller: str, found: Iterable[str]) -> str:
    """Return the predicate of a warning about these phrases of `parameters_outside`; the model is its subject."""
    return f"lies outside the intervals of {controller}, so that its margins are not proved for it: {'; '.join(found)}; synthesise it anew"
