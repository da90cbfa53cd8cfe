"""Table of the identification methods, with the data for which each method is suited.

A method's module is imported only when the method runs, so that `--help` stays fast.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from frictool.documents.bench import Bench
    from frictool.identify.breakaway.rate_table import RateTable
    from frictool.identify.fit_result import Interval, SlidingFit
    from frictool.identify.motion_record import MotionRecord

DEFAULT = "auto"
REFERENCE = "least-squares"  # method with which the other methods are compared


@dataclass(frozen=True)
class IdentificationMethod:
    """Description and capabilities of an identification method.

    The function and its module (in `estimators/`) have the name of the method, with _ for -.

    - what: what the method does, as help text
    - when: data for which the method is suited, as help text
    - reads: names of the options in OPTIONS that the method uses
    - velocity: True if the method can use a log with a measured velocity and no position
    - load: True if the method fits the load terms of the bench
    - known_inertia: True if the method uses the inertia of the bench and does not estimate it
    - whole_curve: True if the method fits a curve of friction over speed, but no inertia. The
      parameters of the curve are identified or refused together, never fixed, and not compared with
      the method REFERENCE.
    - differentiates: True if the method uses differences of samples without a filter. Such a method
      needs a fine encoder and a log without gaps.
    - special_test: True if the method needs a special test. The method's module then has a function
      `check_records`, which raises UnusableLogs if the records are not from such a test.
    - channel: channel that the method needs in addition to motion and drive, or None
    - comparison: True if the method serves only for comparison with published values. If the force
      error is large, the intervals are not widened for effects that the model lacks.
    - known_terms: name of the function that fits given load terms without a search for other terms,
      or None
    """

    name: str
    what: str
    when: str
    reads: tuple[str, ...] = ()
    velocity: bool = False
    load: bool = False
    known_inertia: bool = False
    whole_curve: bool = False
    differentiates: bool = False
    special_test: bool = False
    channel: str | None = None
    comparison: bool = False
    known_terms: str | None = None

    @property
    def estimate(self) -> Callable[[list[MotionRecord], Bench, IdentificationSettings], SlidingFit]:
        """Return the function that estimates the sliding parameters."""
        return self._function(self.name.replace("-", "_"))

    def refit(
        self,
        records: list[MotionRecord],
        bench: Bench,
        settings: IdentificationSettings,
        terms: tuple[str, ...],
    ) -> SlidingFit:
        """Fit the records with the load terms `terms`, without a search for load terms.

        Raises UnusableLogs if the method cannot use the records.
        """
        if self.known_terms is not None:
            return self._function(self.known_terms)(records, bench, settings, terms)
        from frictool.identify.rows.load_terms import bench_with_terms

        declared = bench_with_terms(bench, terms) if terms else bench
        return run(self.name, records, declared, settings)

    def why_not(self, records: list[MotionRecord], bench: Bench | None = None) -> str | None:
        """Return why the records do not come from the test that the method needs, else None.

        Conditions on the bench are checked only if `bench` is provided.
        """
        from frictool.identify.fit_result import UnusableLogs

        if not self.special_test:
            return None
        try:
            self._function("check_records")(records, bench)
        except UnusableLogs as error:
            return str(error)
        return None

    def _function(self, name: str) -> Callable[..., SlidingFit]:
        module = import_module(f"frictool.identify.estimators.{self.name.replace('-', '_')}")
        function: Callable[..., SlidingFit] = getattr(module, name)
        return function


_ROWS = (
    IdentificationMethod(
        "auto",
        "least squares, power balance, sines or output error: chosen from encoder and motion, "
        "with the reason",
        "any log; drops terms that do not improve the prediction of strokes left out of the fit",
        ("window",),
        velocity=True,
        load=True,
    ),
    IdentificationMethod(
        "least-squares",
        "least squares on smoothed signals, at the samples that certainly slip",
        "any encoder, stick and backlash; refuses an inertia that quantisation hides",
        ("window",),
        velocity=True,
        load=True,
    ),
    IdentificationMethod(
        "power-balance",
        "least squares weighted by velocity; with --time-constant, on filtered differences of all "
        "samples",
        "friction that still falls with speed at the samples that certainly slip (Stribeck)",
        ("window", "time_constant"),
        velocity=True,
        load=True,
    ),
    IdentificationMethod(
        "weighted",
        "least squares weighted by the inverse variance of the errors, estimated over speed",
        "errors of the encoder or of the friction model that depend on speed",
        ("window",),
        velocity=True,
        load=True,
    ),
    IdentificationMethod(
        "conditioned",
        "power balance scaled by sqrt(2)/top speed; shows the condition number before and after "
        "scaling",
        "speeds that are very large or small numbers in SI units",
        ("window",),
        velocity=True,
        load=True,
    ),
    IdentificationMethod(
        "weak",
        "weak (integral) form: windows of (1 - s^2)^3, without derivatives of signals",
        "a coarse encoder; precision of the inertia close to the Cramér-Rao bound",
        ("window",),
    ),
    IdentificationMethod(
        "instrumental",
        "instrumental variables from the logged reference",
        "a noisy position, and a logged reference that the axis followed",
        ("window",),
        channel="reference",
    ),
    IdentificationMethod(
        "total-least-squares",
        "total least squares, which allows for the encoder's noise in the regressors",
        "short windows, or an encoder much noisier than the effort",
        ("window",),
    ),
    IdentificationMethod(
        "recursive",
        "recursive least squares in square-root form, with the largest weights at the end of the "
        "log",
        "parameters that drift along the log (warming up, wear)",
        ("window", "forgetting"),
        velocity=True,
    ),
    IdentificationMethod(
        "ordinary",
        "plain least squares on differences, with equal weights of all samples",
        "comparison with published values",
        ("time_constant",),
        comparison=True,
    ),
    IdentificationMethod(
        "threshold",
        "least squares on differences of samples faster than a threshold",
        "comparison, with a fine encoder and a known Stribeck velocity",
        ("time_constant", "threshold"),
        comparison=True,
    ),
    IdentificationMethod(
        "sines",
        "fit of mean effort over mean speed in the middle of each stroke; the curve may have knees",
        "any encoder, strokes at several speeds; friction only, with the bench's inertia",
        velocity=True,
        known_inertia=True,
    ),
    IdentificationMethod(
        "output-error",
        "fit of the simulated to the measured position; selects load terms by the prediction of "
        "strokes left out of the fit",
        "a model for simulation; several strokes with a measured effort",
        load=True,
        known_terms="simulation_error",
    ),
    IdentificationMethod(
        "stribeck-curve",
        "Stribeck curve through the mean efforts of runs at constant speeds",
        "runs at constant speeds, including slow ones; also gives breakaway and Stribeck velocity "
        "if friction falls with speed",
        whole_curve=True,
        special_test=True,
    ),
    IdentificationMethod(
        "friction-force",
        "friction force with a known inertia and a causal filter, and its curve over speed, as "
        "published for a rack-and-pinion stage",
        "one stroke in one direction, a measured inertia; to compare with published values",
        ("cutoff_hz", "filter_order"),
        velocity=True,
        whole_curve=True,
        special_test=True,
    ),
    IdentificationMethod(
        "inverse-dynamic",
        "published EMPS pipeline: Butterworth, central differences, decimation, ordinary least "
        "squares",
        "a fine encoder, no backlash, long strokes; to compare with published values",
        ("cutoff_hz", "filter_order", "padding", "skip", "decimate"),
        differentiates=True,
    ),
)
METHODS = {row.name: row for row in _ROWS}


@dataclass(frozen=True)
class MethodOption:
    """Option of some methods: a field of IdentificationSettings or of PublishedFilters.

    - kind: int or float
    - low, high: allowed range; `high` is None if there is no upper limit
    - what: help text with unit
    - default: default value as text, or None
    - low_open: True if the range excludes `low`
    - odd: True if only odd numbers are allowed
    """

    name: str
    kind: type[int] | type[float]
    low: float
    high: float | None
    what: str
    default: str | None = None
    low_open: bool = False
    odd: bool = False

    @property
    def flag(self) -> str:
        """Return the name of the option on the command line, such as --time-constant."""
        return f"--{self.name.replace('_', '-')}"

    @property
    def readers(self) -> str:
        """Return the names of the methods that use the option, separated by commas."""
        return ", ".join(name for name, row in METHODS.items() if self.name in row.reads)


OPTIONS = (
    MethodOption(
        "window", int, 5, 100_001, "number of samples of the smoothing window", "chosen", odd=True
    ),
    MethodOption(
        "time_constant", float, 0.0, None, "time constant of the filter on differences [s]"
    ),
    MethodOption(
        "threshold",
        float,
        0.0,
        None,
        "smallest speed of a used sample [rad/s | m/s]",
        "a tenth of the top speed",
    ),
    MethodOption(
        "forgetting",
        float,
        0.0,
        1.0,
        "weight of a squared error relative to an error one stroke later",
        "0.99",
        low_open=True,
    ),
    MethodOption("cutoff_hz", float, 1e-3, None, "cut-off of the Butterworth filter [Hz]", "100"),
    MethodOption("filter_order", int, 1, 12, "order of the Butterworth filter", "4"),
    MethodOption("padding", int, 0, None, "number of padding samples at each end", "12"),
    MethodOption("skip", int, 0, None, "samples left out at the start", "49"),
    MethodOption("decimate", int, 1, 1000, "n, to keep every n-th sample", "10"),
)


@dataclass(frozen=True)
class PublishedFilters:
    """Filters of the published methods inverse-dynamic and friction-force.

    The defaults are the published values of inverse-dynamic (EMPS).

    - cutoff_hz, filter_order: cut-off in Hz and order of the low-pass
    - padding: number of padding samples at either end of the record
    - skip: number of samples dropped at the start, while the filters settle
    - decimate: ratio of the sample rates before and after decimation
    - decimate_order, decimate_ripple_db: order and ripple of the Chebyshev low-pass for decimation
    - decimate_band: pass band edge of this low-pass, relative to the new Nyquist frequency
    """

    cutoff_hz: float = 100.0
    filter_order: int = 4
    padding: int = 12
    skip: int = 49
    decimate: int = 10
    decimate_order: int = 8
    decimate_ripple_db: float = 0.05
    decimate_band: float = 0.8


@dataclass(frozen=True)
class IdentificationSettings:
    """Options of the identification methods; None selects the default of the method.

    - confidence: confidence of the intervals, 0 to 1
    - window: length of the smoothing window, samples, odd
    - time_constant: time constant of the filter on differences, s
    - threshold: speed below which the method `threshold` ignores a sample, rad/s | m/s
    - forgetting: weight of a squared residual that lies one median stroke duration before the end
      of the log; above 0, at most 1
    - pipeline: filters of inverse-dynamic and friction-force
    - fixed: intervals of the sliding parameters that are not fitted; each parameter is fixed at the
      value of its interval
    - position_order: highest order of friction over position that is fitted if the load terms
      contain this effect; None for all orders
    """

    confidence: float = 0.95
    window: int | None = None
    time_constant: float | None = None
    threshold: float | None = None
    forgetting: float | None = None
    pipeline: PublishedFilters | None = None
    fixed: Mapping[str, Interval] = field(default_factory=dict)
    position_order: int | None = None

    @classmethod
    def of_options(cls, confidence: float, options: Mapping[str, Any]) -> IdentificationSettings:
        """Return settings from option values; None selects the default of a method."""
        names = {one.name for one in fields(cls)}
        filters = {name: value for name, value in options.items() if name not in names}
        pipeline = PublishedFilters(**{n: one for n, one in filters.items() if one is not None})
        read = {name: value for name, value in options.items() if name in names}
        return cls(confidence, pipeline=pipeline, **read)


@dataclass(frozen=True)
class IdentificationRequest:
    """Options of an identification.

    Attributes
    ----------
    method : str
        Key of METHODS.
    settings : IdentificationSettings
        Confidence and options of the method.
    measurement : bool
        True to estimate also backlash, delay and current-loop lag of the bench.
    keep_bench_values : bool
        True to return a model with the values in bench.yaml, marked as such, if the logs give
        neither inertia nor friction. Otherwise NothingIdentified is raised.
    breakaway_table : RateTable or None
        Breakaway efforts measured at several rates of the ramp. The table replaces the breakaway of
        ramp logs.
    """

    method: str = DEFAULT
    settings: IdentificationSettings = IdentificationSettings()
    measurement: bool = False
    keep_bench_values: bool = False
    breakaway_table: RateTable | None = None


def run(
    method: str, records: list[MotionRecord], bench: Bench, settings: IdentificationSettings
) -> SlidingFit:
    """Estimate the sliding parameters with a method of METHODS.

    Raises UnusableLogs if the records do not determine any parameter.
    """
    refuse_unsupported(method, records, bench)
    return METHODS[method].estimate(records, bench, settings)


def refuse_unsupported(method: str, records: list[MotionRecord], bench: Bench) -> None:
    """Raise UnusableLogs if a method cannot use measured velocities or the loads of the bench."""
    from frictool.identify.fit_result import UnusableLogs

    blind = next((record.name for record in records if record.velocity is not None), None)
    if blind is not None and not METHODS[method].velocity:
        able = ", ".join(name for name, row in METHODS.items() if row.velocity)
        raise UnusableLogs(
            f"{blind} has a velocity and no position, but {method} needs a position; these methods "
            f"need no position: {able}"
        )
    if bench.load is not None and bench.load.terms != ("offset",) and not METHODS[method].load:
        able = ", ".join(name for name, row in METHODS.items() if row.load)
        raise UnusableLogs(
            f"{method} cannot fit load.terms of the bench "
            f"({', '.join(bench.load.terms) or 'none'}); these methods can: {able}"
        )
