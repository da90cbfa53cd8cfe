"""An observer of any kind: what `frictool observe design` does, on values in memory."""

from __future__ import annotations

from typing import Literal, get_args

from frictool.documents.model import Model
from frictool.documents.observer import Observer
from frictool.documents.provenance import Provenance, provenance_of_call
from frictool.errors import FrictoolError
from frictool.observe.design import additive, multiplicative
from frictool.observe.design.settings import SwitchedObserverSettings
from frictool.observe.design.tracking import design_tracking

Kind = Literal["multiplicative", "additive", "tracking"]


def design_observer(
    model: Model,
    kind: Kind,
    *,
    settings: SwitchedObserverSettings | None = None,
    bandwidth_rad_s: float | None = None,
    drive_noise: float = 0.0,
    inertia: float | None = None,
    provenance: Provenance | None = None,
) -> Observer:
    """The observer of a model, verified.

    settings: of the switched kinds, multiplicative and additive. bandwidth_rad_s, drive_noise [A |
    V], inertia [kg m2 | kg]: of tracking. Raises FrictoolError where there is no such kind,
    NoSolutionError where there is no observer, or it is not verified.
    """
    if kind not in get_args(Kind):
        raise FrictoolError(f"kind: found {kind!r}; allowed: {', '.join(get_args(Kind))}")
    origin = provenance or provenance_of_call("frictool.observe.design_observer", model=model)
    if kind == "tracking":
        return design_tracking(model, origin, bandwidth_rad_s, drive_noise, inertia=inertia)
    design = multiplicative.design if kind == "multiplicative" else additive.design
    return design(model, settings or SwitchedObserverSettings(), origin)
