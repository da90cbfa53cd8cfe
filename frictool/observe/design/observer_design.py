"""Design of an observer of any kind in one call, without files."""

from __future__ import annotations

from typing import Literal, get_args

from frictool.documents.model import Model
from frictool.documents.observer import Observer
from frictool.documents.provenance import Provenance, provenance_of_call
from frictool.errors import FrictoolError
from frictool.observe.design import additive, multiplicative
from frictool.observe.design.switched_settings import SwitchedObserverSettings
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
    """Design an observer from a model and verify it.

    Parameters
    ----------
    model : Model
        model of the axis and its bench
    kind : {"multiplicative", "additive", "tracking"}
        kind of the observer
    settings : SwitchedObserverSettings, optional
        settings of a multiplicative or additive observer
    bandwidth_rad_s : float, optional
        bandwidth [rad/s] of a tracking observer; by default computed by `tracking.bandwidth_of`
    drive_noise : float, optional
        standard deviation of the measured drive [A or V], for a tracking observer only
    inertia : float, optional
        inertia [kg m2 or kg], for a tracking observer only; by default the model's inertia
    provenance : Provenance, optional
        provenance of the document; by default it names this function

    Returns
    -------
    Observer
        document of the observer

    Raises
    ------
    FrictoolError
        if `kind` is unknown, or if a setting is impossible with this model
    NoSolutionError
        if there is no observer for these settings, or if it fails the verification
    """
    if kind not in get_args(Kind):
        raise FrictoolError(f"kind: found {kind!r}; allowed: {', '.join(get_args(Kind))}")
    origin = provenance or provenance_of_call("frictool.observe.design_observer", model=model)
    if kind == "tracking":
        return design_tracking(model, origin, bandwidth_rad_s, drive_noise, inertia=inertia)
    design = multiplicative.design if kind == "multiplicative" else additive.design
    return design(model, settings or SwitchedObserverSettings(), origin)
