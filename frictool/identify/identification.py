"""Identify sliding parameters from logs of motion and the breakaway from ramps.

Each parameter that is not identified has a reason.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import msgspec

from frictool.adapters.axis_model import load_law
from frictool.documents.bench import Bench
from frictool.documents.laws import Laws
from frictool.documents.load_terms import LoadTerms
from frictool.documents.quantity import Quantity
from frictool.errors import EXIT_NO, EXIT_NO_SOLUTION
from frictool.identify import methods
from frictool.identify.breakaway.breakaway import Breakaway, breakaway, is_ramp
from frictool.identify.constant_effort import without_constant_effort
from frictool.identify.duplicate_logs import refuse_duplicates
from frictool.identify.estimators.auto import inertia_over_position
from frictool.identify.fit_result import (
    CURVE,
    PARAMETERS,
    SLIDING,
    Interval,
    SlidingFit,
    UnusableLogs,
)
from frictool.identify.fit_warnings import (
    contradiction_warnings,
    doubt_warnings,
    replacement_warnings,
)
from frictool.identify.force_error import SlipRows, force_error, motion_rows
from frictool.identify.held_effort import slow_effort_warnings
from frictool.identify.interval_checks import (
    NEVER_NEGATIVE,
    below_coulomb,
    why_uninformative,
    without_negative,
)
from frictool.identify.measurement_faults import refuse_self_explained, refuse_unmeasured
from frictool.identify.method_check import method_warnings
from frictool.identify.motion_record import MotionRecord
from frictool.identify.orientation import negative_effort, opposite_signs, reversed_sign
from frictool.identify.pooling import pooling_warnings
from frictool.identify.record_plausibility import implausible
from frictool.identify.refit import CANNOT, fixed_parameters, refit

SLIDING_LOG, RAMP_LOG = "sliding", "ramp"
# parameters of which every model that `identify` writes has at least one
PHYSICAL = frozenset(NEVER_NEGATIVE)
LARGEST_FORCE_ERROR = 0.5  # above it more than a quarter of the effort's mean square is unexplained
POSITION_HIDES_INERTIA = (
    "friction varies with the position, which goes with the acceleration along a stroke: what "
    "one does is taken for the other; "
    "the bench's value is kept. The weak form (auto, weak) gives friction over the position "
    "columns of its own where it shows in slip"
)


@dataclass(frozen=True)
class Identification:
    """Identified parameters of an axis, and reasons for the others.

    - kinds: log name -> `sliding` or `ramp`
    - identified: parameter -> interval in SI units
    - refused: parameter -> reason
    - fit, ramp: fit of the sliding logs and breakaway of the ramps, None without one
    - warnings: doubts about the logs or the result
    - laws: friction and load beyond the parameters
    """

    method: str
    confidence: float
    kinds: dict[str, str]
    identified: dict[str, Interval]
    refused: dict[str, str]
    fit: SlidingFit | None
    ramp: Breakaway | None
    warnings: tuple[str, ...] = ()
    laws: Laws | None = None


class NothingIdentified(UnusableLogs):
    """Error: the logs give neither inertia nor friction; `result` holds the reasons.

    exit_code is 1 if no fit was possible. It is 4 if a fit gave neither, or if position and drive
    have opposite signs.
    """

    def __init__(self, result: Identification, exit_code: int = EXIT_NO) -> None:
        self.result = result
        self.exit_code = exit_code
        super().__init__(
            "; ".join(
                f"{', '.join(names)}: {reason}"
                for reason, names in _by_reason(result.refused).items()
            )
        )


def identify(
    records: list[MotionRecord],
    ramps: list[MotionRecord],
    bench: Bench,
    method: str,
    settings: methods.IdentificationSettings,
) -> Identification:
    """Identify the axis of `bench` from `records` and from known breakaway `ramps`.

    The kind of each of `records` is detected: sliding or ramp.

    Raises
    ------
    NothingIdentified
        If the records give neither inertia nor friction, or if position and drive have opposite
        signs.
    LogError
        If a log is passed twice, or cannot be of this axis.
    """
    refuse_duplicates([*records, *ramps])
    given = ramps
    odd = [warning for record in [*records, *ramps] for warning in implausible(record, bench)]
    ramp_like = [record for record in records if record.velocity is None and is_ramp(record, bench)]
    sliding = [record for record in records if not any(record is other for other in ramp_like)]
    ramps = [*ramps, *ramp_like]
    kinds = {**{r.name: SLIDING_LOG for r in sliding}, **{r.name: RAMP_LOG for r in ramps}}
    found: dict[str, Interval] = {}
    refused: dict[str, str] = {}
    free, fit, onsets = None, None, None
    unmeasured: str | None = None
    try:
        sliding, doubts = _measured(sliding, bench, settings)
        odd += doubts
    except UnusableLogs as error:
        sliding, unmeasured = [], str(error)
    rows = motion_rows(sliding, bench)
    try:
        free = _slide(sliding, rows, bench, method, settings)
        _accept(free.parameters, free.refused, bench, found, refused)
        fit = _settled(
            sliding, bench, settings, replace(free, method=free.method or method), found, refused
        )
    except UnusableLogs as error:
        refused.update(dict.fromkeys(SLIDING, unmeasured or str(error)))
    if not {"viscous", "coulomb"} <= found.keys() or _any_negative(fit):
        reason = reversed_sign(sliding, bench, settings)
        if reason is not None:
            raise _reversed(reason, method, settings, kinds, odd)
    if fit is not None and fit.laws is not None:
        ramps = [without_load(record, fit.laws) for record in ramps]
    try:
        onsets = _break_away(ramps, bench, found, settings.confidence)
        if onsets.interval.high < 0.0:
            shown = f"the breakaway is in [{onsets.interval.low:.4g}, {onsets.interval.high:.4g}]"
            raise _reversed(opposite_signs(ramps, shown, bench), method, settings, kinds, odd)
        _accept({"breakaway": onsets.interval}, {}, bench, found, refused)
    except UnusableLogs as error:
        if "breakaway" not in found and (ramps or "breakaway" not in refused):
            refused["breakaway"] = str(error)
    laws = None if fit is None else fit.laws
    if (
        onsets is not None
        and onsets.by_position is not None
        and laws is not None
        and laws.load is not None
        and bench.load is None
    ):
        # a load that the bench does not declare looks in slip like friction that varies with
        # position
        return identify(
            records,
            given,
            msgspec.structs.replace(bench, load=LoadTerms(("offset",))),
            method,
            settings,
        )
    if onsets is not None and onsets.by_position is not None:
        fit, onsets, laws = _by_position(
            sliding, ramps, fit, onsets, bench, method, settings, found, refused
        )
    elif onsets is not None and onsets.rising is not None:
        laws = _rising(onsets, bench, found, laws)
    if fit is not None:
        fit = with_force_error(replace(fit, laws=laws), rows, found, bench)
    if (
        onsets is not None
        and onsets.by_position is None
        and {"breakaway", "coulomb"} <= found.keys()
    ):
        impossible = below_coulomb(found["breakaway"], found["coulomb"])
        if impossible is not None:
            refused["breakaway"] = impossible
            del found["breakaway"]
    ordered = {name: found[name] for name in (*PARAMETERS, *CURVE) if name in found}
    warnings = [*odd, *contradiction_warnings(ordered, bench)]
    if fit is not None and free is not None:
        warnings += [*replacement_warnings(free, fit, found), *doubt_warnings(fit, method)]
        warnings += pooling_warnings(
            sliding, bench, settings, replace(free, method=free.method or method)
        )
        if method != methods.DEFAULT:
            warnings += method_warnings(sliding, rows, bench, settings, fit)
    used = (fit and fit.method) or method
    result = Identification(
        used, settings.confidence, kinds, ordered, refused, fit, onsets, tuple(warnings), laws
    )
    if not PHYSICAL & found.keys():
        reason = negative_effort([*sliding, *ramps], bench, settings.confidence)
        if reason is not None:
            raise _reversed(reason, method, settings, kinds, odd)
        if "offset" in found:
            refused["offset"] = (
                f"the fit gives {found['offset'].value:.4g} and neither inertia nor friction"
            )
        result = replace(result, identified={})
        raise NothingIdentified(result, EXIT_NO if fit is None else EXIT_NO_SOLUTION)
    return result


def _measured(
    records: list[MotionRecord], bench: Bench, settings: methods.IdentificationSettings
) -> tuple[list[MotionRecord], list[str]]:
    """Return the records without constant effort, and warnings.

    Raises UnusableLogs if the effort or position of a record was not measured.
    """
    refuse_unmeasured(records, bench)
    slow = slow_effort_warnings(records, bench, settings)
    kept, left_out = without_constant_effort(records, bench)
    return kept, [*slow, *left_out]


def _any_negative(fit: SlidingFit | None) -> bool:
    """Return whether the fit gives a negative value for a parameter that cannot be negative."""
    return fit is not None and any(
        name in NEVER_NEGATIVE and interval.value < 0.0 for name, interval in fit.parameters.items()
    )


def _reversed(
    reason: str,
    method: str,
    settings: methods.IdentificationSettings,
    kinds: dict[str, str],
    warnings: list[str],
) -> NothingIdentified:
    """Return the error for a log whose position or drive is negated: no parameter is identified."""
    refused = dict.fromkeys(PARAMETERS, reason)
    result = Identification(
        method, settings.confidence, kinds, {}, refused, None, None, tuple(warnings)
    )
    return NothingIdentified(result, EXIT_NO_SOLUTION)


def _slide(
    records: list[MotionRecord],
    rows: Sequence[SlipRows],
    bench: Bench,
    method: str,
    settings: methods.IdentificationSettings,
) -> SlidingFit:
    """Return the fit of one method, with its force error.

    Raises
    ------
    UnusableLogs
        If no fit is possible, or if its force error exceeds LARGEST_FORCE_ERROR.
    """
    if not records:
        raise UnusableLogs("no log of sliding motion was given")
    fit = methods.run(method, records, bench, settings)
    refuse_self_explained(fit, records)
    fit = with_force_error(fit, rows, fit.parameters, bench)
    if fit.force_error is not None and fit.force_error > LARGEST_FORCE_ERROR:
        allowed = f"(allowed: {100 * LARGEST_FORCE_ERROR:g} %)"
        raise UnusableLogs(
            f"the model does not explain the effort: force error {100 * fit.force_error:.3g} % "
            f"{allowed}; is it of this motion?"
        )
    return fit


def _settled(
    records: list[MotionRecord],
    bench: Bench,
    settings: methods.IdentificationSettings,
    fit: SlidingFit,
    found: dict[str, Interval],
    refused: dict[str, str],
) -> SlidingFit:
    """Return the fit with refused parameters fixed at the bench's values.

    It is repeated until no further parameter is refused (`refit.py`). `found` and `refused` are
    updated.
    """
    if fit.method in CANNOT or _any_negative(fit):
        return fit
    fixed: dict[str, Interval] = {}
    while (more := fixed_parameters(fit, found, bench)).keys() - fixed.keys() and found.keys() - {
        "offset"
    }:
        fixed |= more
        try:
            fit = refit(records, bench, settings, fit, fixed)
        except UnusableLogs:
            break
        for name in SLIDING:
            found.pop(name, None)
        _accept(
            fit.parameters,
            {name: reason for name, reason in fit.refused.items() if name not in refused},
            bench,
            found,
            refused,
        )
    return fit


def with_force_error(
    fit: SlidingFit, rows: Sequence[SlipRows], found: Mapping[str, Interval], bench: Bench
) -> SlidingFit:
    """Return the fit with the force error of the model: values of `found`, else of the bench."""
    values = {name: (found.get(name) or prior(bench, name)).value for name in SLIDING}
    values |= {name: interval.value for name, interval in found.items()}
    return replace(fit, force_error=force_error(rows, values, fit.laws))


def _break_away(
    ramps: list[MotionRecord], bench: Bench, found: Mapping[str, Interval], confidence: float
) -> Breakaway:
    """Return the breakaway of the ramps.

    Raises UnusableLogs without ramps, for ramps without a position, or if breakaways in one
    direction leave the offset unknown.
    """
    if not ramps:
        raise UnusableLogs("no log of breakaway ramps was given")
    for ramp in ramps:
        if ramp.velocity is not None:
            raise UnusableLogs(
                f"{ramp.name} has a velocity and no position, whose counts tell when the axis "
                "breaks away"
            )
    axis = {name: found.get(name) or prior(bench, name) for name in SLIDING}
    onsets = breakaway(ramps, bench, axis, confidence, found.get("stribeck_velocity"))
    if (
        not (onsets.forward > 0.0 and onsets.backward > 0.0)
        and "offset" not in found
        and bench.mechanics.offset is None
    ):
        raise UnusableLogs(
            "breakaways in one direction only, which an offset shifts, and neither a log nor the "
            "bench gives the offset"
        )
    return onsets


def _by_position(
    sliding: list[MotionRecord],
    ramps: list[MotionRecord],
    fit: SlidingFit | None,
    onsets: Breakaway,
    bench: Bench,
    method: str,
    settings: methods.IdentificationSettings,
    found: dict[str, Interval],
    refused: dict[str, str],
) -> tuple[SlidingFit | None, Breakaway, Laws]:
    """Return fit, breakaway and laws if the breakaway varies with position.

    The friction map replaces viscous friction, Coulomb friction and offset of a constant friction.
    If the strokes do not support a map, only the breakaway depends on position. `found` and
    `refused` are updated.
    """
    from frictool.identify.breakaway.friction_map import breakaway_laws, friction_map

    # a load or friction by direction, which the map does not model
    if fit is not None and fit.laws is not None and (fit.laws.load or fit.laws.backward):
        return fit, onsets, breakaway_laws(onsets, bench, found, fit.laws)
    why = (
        None
        if fit is None
        else _inertia_over_position(sliding, fit, bench, method, settings, found, refused)
    )
    axis = {name: found.get(name) or prior(bench, name) for name in SLIDING} | {
        "offset": prior(bench, "offset")
    }
    try:
        mapped = friction_map(sliding, ramps, onsets, axis, bench, settings)
    except UnusableLogs:
        return fit, onsets, breakaway_laws(onsets, bench, found)
    for name in ("viscous", "coulomb", "offset"):
        found.pop(name, None)
        refused.pop(name, None)
    _accept(mapped.fit.parameters, mapped.fit.refused, bench, found, refused)
    assert mapped.fit.laws is not None
    return (
        replace(mapped.fit, why=why),
        mapped.ramp,
        breakaway_laws(mapped.ramp, bench, found, mapped.fit.laws),
    )


def _inertia_over_position(
    sliding: list[MotionRecord],
    fit: SlidingFit,
    bench: Bench,
    method: str,
    settings: methods.IdentificationSettings,
    found: dict[str, Interval],
    refused: dict[str, str],
) -> str | None:
    """Replace or refuse an inertia that was fitted with a constant friction; return the reason.

    With method `auto`, the inertia is taken from the weak form with friction over position, if that
    gives one. `found` and `refused` are updated. The result is None if the inertia is refused.
    """
    if fit.details.get("position_order"):
        return fit.why
    if "inertia" in fit.parameters:
        found.pop("inertia", None)
        refused["inertia"] = POSITION_HIDES_INERTIA
    weak = inertia_over_position(sliding, bench, settings) if method == methods.DEFAULT else None
    if weak is None:
        return None
    refused.pop("inertia", None)
    _accept({"inertia": weak.parameters["inertia"]}, {}, bench, found, refused)
    return f"friction by sines and ramps. inertia by weak: {weak.why}"


def _rising(onsets: Breakaway, bench: Bench, found: dict[str, Interval], laws: Laws | None) -> Laws:
    """Return the laws with a breakaway that grows with the time at rest."""
    from frictool.identify.breakaway.friction_map import breakaway_laws

    return breakaway_laws(onsets, bench, found, laws)


def without_load(record: MotionRecord, laws: Laws) -> MotionRecord:
    """Return the record with the load law subtracted from its effort."""
    if laws.load is None or record.velocity is not None:
        return record
    return replace(record, effort=record.effort - load_law(laws.load).at(record.position))


def prior(bench: Bench, name: str) -> Interval:
    """Return the bench's interval of a sliding parameter; 0 for an undeclared offset."""
    known: Quantity | None = getattr(bench.mechanics, name)
    return Interval(0.0, 0.0, 0.0) if known is None else Interval(known.value, *known.interval)


def _accept(
    offered: Mapping[str, Interval],
    reasons: Mapping[str, str],
    bench: Bench,
    found: dict[str, Interval],
    refused: dict[str, str],
) -> None:
    """Add each parameter to `found` if its interval is informative, else to `refused`."""
    refused.update(reasons)
    for name, given in offered.items():
        known: Quantity | None = getattr(bench.mechanics, name, None)
        interval = without_negative(name, given, known)
        reason = why_uninformative(name, interval, known)
        if reason is None:
            low = max(interval.low, 0.0) if name in NEVER_NEGATIVE else interval.low
            found[name] = Interval(interval.value, low, interval.high)
        else:
            refused[name] = reason


def _by_reason(refused: Mapping[str, str]) -> dict[str, list[str]]:
    grouped: dict[str, list[str]] = {}
    for name in PARAMETERS:
        if name in refused:
            grouped.setdefault(refused[name], []).append(name)
    return grouped
