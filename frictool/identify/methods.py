"""Identification methods by name, with the data that each one suits.

A method's module is imported only when the method runs, so that `--help` stays fast.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib import import_module
from typing import TYPE_CHECKING, cast

if TYPE_CHECKING:
    from frictool.documents.bench import Bench
    from frictool.identify.fit_result import Interval, SlidingFit
    from frictool.identify.motion_record import MotionRecord

DEFAULT = "auto"


@dataclass(frozen=True)
class IdentificationMethod:
    """Description and capabilities of a method.

    The function and its module (in `estimators/`) have the name of the method, with _ for -.

    - what: what the method does, as help text
    - when: data that the method suits, as help text
    - options: fields of IdentificationSettings that it reads, apart from the confidence
    - velocity: it works with a measured velocity and no position
    - load: it fits the load terms of the bench
    """

    what: str
    when: str
    options: tuple[str, ...] = ()
    velocity: bool = False
    load: bool = False


METHODS: dict[str, IdentificationMethod] = {
    "auto": IdentificationMethod(
        "least squares, the power balance, sines or output error: by what encoder and motion "
        "allow (figure 4.4), and says why",
        "any log; drops a term that does not help to predict strokes that the fit has not seen",
        ("window",),
        velocity=True,
        load=True,
    ),
    "least-squares": IdentificationMethod(
        "least squares (4.11): zero-phase Savitzky-Golay, only samples certain to slip, QR",
        "any encoder, sticks and backlash; refuses the inertia that quantisation hides",
        ("window",),
        velocity=True,
        load=True,
    ),
    "power-balance": IdentificationMethod(
        "the power balance (4.23): the same, weighted by velocity; with --time-constant on "
        "filtered differences, all samples",
        "friction that falls over speed beyond the slowest samples (Stribeck)",
        ("window", "time_constant"),
        velocity=True,
        load=True,
    ),
    "weighted": IdentificationMethod(
        "the same, weighted by the inverse variance of the measurement errors, found over speed "
        "(4.2.5.1)",
        "an encoder or a friction that is worse at some speeds than at others",
        ("window",),
        velocity=True,
        load=True,
    ),
    "conditioned": IdentificationMethod(
        "the power balance scaled by sqrt(2)/V (4.31), with the condition of (4.29) before and "
        "after",
        "very high or low speeds in SI units",
        ("window",),
        velocity=True,
        load=True,
    ),
    "weak": IdentificationMethod(
        "the weak (integral) form: windows of (1 - s^2)^3, nothing differentiated",
        "a coarse encoder; closest to what it can give of the inertia",
        ("window",),
    ),
    "instrumental": IdentificationMethod(
        "instrumental variables from the logged reference",
        "a noisy position and a reference that the axis followed",
        ("window",),
    ),
    "total-least-squares": IdentificationMethod(
        "total least squares: the encoder's noise in the regressors is accounted for",
        "short windows, an encoder much noisier than the effort",
        ("window",),
    ),
    "recursive": IdentificationMethod(
        "recursive least squares (4.16) in square-root form: the last of the log counts most",
        "parameters that drift along the log (warming up, wear)",
        ("window", "forgetting"),
        velocity=True,
    ),
    "ordinary": IdentificationMethod(
        "plain least squares on differences (4.2), every sample alike",
        "comparison with tables 4.2 and 4.3",
        ("time_constant",),
    ),
    "threshold": IdentificationMethod(
        "least squares on differences, only samples faster than a threshold (4.18)",
        "comparison; a fine encoder and a known Stribeck velocity",
        ("time_constant", "threshold"),
    ),
    "sines": IdentificationMethod(
        "sines (4.34)-(4.39): mean effort over mean speed of each stroke's middle; finds the "
        "knees of friction over speed",
        "any encoder, strokes at several speeds; friction only, the inertia is the bench's",
        velocity=True,
    ),
    "output-error": IdentificationMethod(
        "simulation error: the axis that, driven by the measured effort, goes where the measured "
        "one went; load terms by held-out halves",
        "a model that has to simulate; several strokes, and an effort that was measured",
        load=True,
    ),
    "stribeck-curve": IdentificationMethod(
        "the Stribeck curve (2.34): mean effort over runs at constant speeds",
        "runs at constant speeds, slow ones too; gives the breakaway and the Stribeck velocity "
        "where friction falls with speed",
    ),
    "friction-force": IdentificationMethod(
        "the friction force of a known inertia, causal filter, and its curve over speed, as "
        "published for a rack-and-pinion stage",
        "one stroke, one direction, an inertia that was weighed; to compare with published values",
        ("cutoff_hz", "filter_order"),
        velocity=True,
    ),
    "inverse-dynamic": IdentificationMethod(
        "the published EMPS pipeline: Butterworth, central differences, decimation, ordinary "
        "least squares",
        "a fine encoder, no backlash, long strokes; to compare with published values",
        ("pipeline",),
    ),
}


@dataclass(frozen=True)
class PublishedFilters:
    """Filters of the published methods inverse-dynamic and friction-force.

    The defaults are the published values of inverse-dynamic (EMPS).
    """

    cutoff_hz: float = 100.0
    filter_order: int = 4
    padding: int = 12  # samples, padding at either end of the record
    skip: int = 49  # samples, dropped at the start while the filters settle
    decimate: int = 10
    decimate_order: int = 8
    decimate_ripple_db: float = 0.05
    decimate_band: float = 0.8  # pass band edge relative to the new Nyquist frequency


@dataclass(frozen=True)
class IdentificationSettings:
    """Options of the identification methods; None selects the method's own choice.

    - confidence: confidence of the intervals, 0 to 1
    - window: smoothing window, samples, odd
    - time_constant: time constant of the filter on differences, s
    - threshold: least speed of a sample in (4.18), rad/s | m/s
    - forgetting: weight of a squared residual one stroke back, in ]0, 1]
    - pipeline: filters of inverse-dynamic and friction-force
    - fixed: sliding parameters held at the interval of the bench (name -> interval) in a second
      fit, since the first one did not identify them
    """

    confidence: float = 0.95
    window: int | None = None
    time_constant: float | None = None
    threshold: float | None = None
    forgetting: float | None = None
    pipeline: PublishedFilters | None = None
    fixed: Mapping[str, Interval] = field(default_factory=dict)


def run(
    method: str, records: list[MotionRecord], bench: Bench, settings: IdentificationSettings
) -> SlidingFit:
    """Return the sliding parameters by a method of METHODS.

    Raises UnusableLogs if the records do not give any.
    """
    _check(method, records, bench)
    name = method.replace("-", "_")
    return cast(
        "SlidingFit",
        getattr(import_module(f"frictool.identify.estimators.{name}"), name)(
            records, bench, settings
        ),
    )


def _check(method: str, records: list[MotionRecord], bench: Bench) -> None:
    """Raise UnusableLogs if the method cannot use the records or the bench's load."""
    from frictool.identify.fit_result import UnusableLogs

    blind = next((record.name for record in records if record.velocity is not None), None)
    if blind is not None and not METHODS[method].velocity:
        able = ", ".join(name for name, row in METHODS.items() if row.velocity)
        raise UnusableLogs(
            f"{blind} has a velocity and no position, which {method} needs; these do without: "
            f"{able}"
        )
    if bench.load is not None and bench.load.terms != ("offset",) and not METHODS[method].load:
        able = ", ".join(name for name, row in METHODS.items() if row.load)
        raise UnusableLogs(
            f"{method} does not know load.terms of the bench, "
            f"{', '.join(bench.load.terms) or 'none'}; these do: {able}"
        )
