"""Narrower range of one parameter with which a candidate of a failed search passes every test.

If the range of a parameter prevents a design, candidates fail only with plants on one side of its
nominal value. The cut is the parameter value of the passing plant that is closest to the failing
plants. The narrower range extends from the cut to the opposite end of the range. It is reported
only if the candidate passes all tests with new plants from the narrower range, and is verified.
Otherwise the cut is moved towards the nominal value.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple, TypeVar

import numpy as np
from msgspec import structs

from frictool.adapters.parameter_intervals import breakaway_interval
from frictool.campaign.design_trial import DesignTest, design_test
from frictool.campaign.search_findings import CandidateExamination, NarrowerRange, missed
from frictool.campaign.search_tests import search_tests
from frictool.documents.model import Model
from frictool.documents.quantity import Estimate, Quantity
from frictool.errors import FrictoolError
from frictool.simulate.axis_variants import parameters_of
from frictool.simulate.simulated_plant import VariedParameter
from frictool.synth.search.candidate_controller import CandidateControllers
from frictool.synth.search.played_search import Candidate, PlayedExtent
from frictool.synth.search.played_tests import shortfalls

Range = TypeVar("Range", bound=Quantity)

NARROWED = ("inertia", "viscous", "coulomb", "breakaway", "constant")
MEASURED = ("inertia", "viscous", "coulomb", "breakaway")  # parameters of `excite --for`
WIDE = 1.5  # least factor between the ends of a wide range
TRIED = 2  # parameters whose ranges are tried
SEPARATED = 6  # number of candidates that are tried for one parameter
NOMINAL = 20  # number of candidates that are first simulated with the nominal plant
HALVINGS = 3  # largest number of times that the distance of a cut from the nominal value is halved
MOST_PLANTS = 800  # plants simulated to confirm ranges, after which no further range is tried


class _Cut(NamedTuple):
    """Value of a parameter [SI] beyond which all failing plants of a candidate lie.

    `share`: distance of the cut from the nominal value, divided by the distance of the end of the
        range from the nominal value.
    """

    share: float
    value: float
    upper: bool
    candidate: Candidate


def narrower_range(test: DesignTest, candidates: Sequence[Candidate]) -> NarrowerRange | None:
    """Search for a range of one parameter with which a candidate passes every test.

    The first parameter is the one that separates failing from passing plants for most candidates.
    Its ranges are tried from the widest to the narrowest. Return None if no range suffices.

    Parameters
    ----------
    test : DesignTest
        Test that no candidate passes, with the plants of the whole ranges.
    candidates : sequence of Candidate
        Candidates of the search. Candidates that were simulated with the most plants are preferred.
    """
    parameters = _parameters(test.model)
    near = _nearest(candidates)
    cuts = {
        name: [cut for one in near for cut in _cuts(test, one, name, parameter)]
        for name, parameter in parameters.items()
    }
    played = 0
    for name in sorted(cuts, key=lambda name: -len(cuts[name]))[:TRIED]:
        for cut in _tried(_usable(test, cuts[name]), parameters[name]):
            if played >= MOST_PLANTS:
                return None
            found, plants = _confirmed(test, name, parameters[name], cut)
            played += plants
            if found is not None:
                return found
    return None


def _parameters(model: Model) -> dict[str, VariedParameter]:
    """Return the parameters that may be narrowed; their nominal values are those of the model."""
    constant = model.bench.actuator.constant
    return {
        name: one._replace(nominal=getattr(model.parameters, name, constant).value)
        for name, one in parameters_of(model).items()
        if name in NARROWED
    }


def _cuts(
    test: DesignTest, one: Candidate, name: str, parameter: VariedParameter
) -> Iterator[_Cut]:
    """Yield the cut of a candidate if all its failing plants are on one side of the nominal value.

    If no plant between the nominal value and the nearest failing plant passed, the cut is halfway
    between these two values.
    """
    passed = _passed(one)
    values = np.array([test.plants[plant].get(name, parameter.nominal) for plant in passed])
    failing = np.logical_not(list(passed.values()))
    for upper, end in ((True, parameter.high), (False, parameter.low)):
        width = end - parameter.nominal
        if width == 0.0 or not failing.any():
            continue
        shares = (values - parameter.nominal) / width
        least = float(shares[failing].min())
        if least <= 0.0:
            continue
        share = float(shares[shares < least].max(initial=0.0)) or 0.5 * least
        yield _Cut(share, parameter.nominal + share * width, upper, one)


def _passed(one: Candidate) -> dict[int, bool]:
    """Map each plant's index to True if the candidate meets all requirements with this plant."""
    passed: dict[int, bool] = {}
    for runs in one.runs[:2]:  # the other tests have other plants
        met = np.all(shortfalls(runs, 0.0) <= 0.0, axis=1)
        for plant, each in zip(runs.plants, met, strict=True):
            passed[plant] = passed.get(plant, True) and bool(each) and plant not in runs.failed
    return passed


def _nearest(candidates: Sequence[Candidate]) -> list[Candidate]:
    """Return distinct candidates: most simulated plants first, then smallest violation first."""
    near = sorted(
        (one for one in candidates if one.extent > PlayedExtent.NONE),
        key=lambda one: (-one.plants, one.largest_missing),
    )
    first: dict[bytes, Candidate] = {}
    for one in near:
        first.setdefault(one.point.tobytes(), one)
    return list(first.values())


def _usable(test: DesignTest, cuts: Sequence[_Cut]) -> list[_Cut]:
    """Return at most SEPARATED cuts whose candidate passes with the nominal plant."""
    controllers = CandidateControllers(test.model, test.spec)
    usable: list[_Cut] = []
    for cut in cuts[:NOMINAL]:
        if _meets_nominal(test, cut.candidate, controllers):
            usable.append(cut)
        if len(usable) == SEPARATED:
            break
    return usable


def meets_with_nominal_plant(test: DesignTest, candidates: Sequence[Candidate]) -> bool:
    """Return True if one of the nearest candidates meets all requirements on the nominal plant."""
    controllers = CandidateControllers(test.model, test.spec)
    return any(_meets_nominal(test, one, controllers) for one in _nearest(candidates)[:NOMINAL])


def _meets_nominal(test: DesignTest, one: Candidate, controllers: CandidateControllers) -> bool:
    passed = _passed(one).get(0)
    return not missed(test.judge(controllers(one.design), [0])) if passed is None else passed


def widest_ranges(model: Model) -> list[tuple[str, VariedParameter]]:
    """Return the parameters with wide ranges that a test can narrow, widest range first.

    `excite --for` plans such a test. The width of a range is its upper end divided by its lower
    end. A range that begins at 0 comes last.
    """
    wide = [
        (name, one)
        for name, one in parameters_of(model).items()
        if name in MEASURED and one.high > WIDE * one.low
    ]
    return sorted(wide, key=lambda each: -each[1].high / each[1].low if each[1].low > 0.0 else 0.0)


def _tried(cuts: Sequence[_Cut], parameter: VariedParameter) -> list[_Cut]:
    """Return `cuts` and cuts moved towards the nominal value, farthest first.

    The distance of each cut from the nominal value is halved up to HALVINGS times. The values are
    rounded to four digits.
    """
    nearer = []
    for cut in cuts:
        for part in (0.5**number for number in range(HALVINGS + 1)):
            value = parameter.nominal + part * (cut.value - parameter.nominal)
            nearer.append(cut._replace(share=part * cut.share, value=float(f"{value:.4g}")))
    return sorted(nearer, key=lambda cut: -cut.share)


def _confirmed(
    test: DesignTest, name: str, parameter: VariedParameter, cut: _Cut
) -> tuple[NarrowerRange | None, int]:
    """Test the candidate of a cut in the range that ends at the cut.

    Return (range, or None if the candidate fails in this range; number of simulated plants).
    """
    bounds = (parameter.low, cut.value) if cut.upper else (cut.value, parameter.high)
    if not bounds[0] <= parameter.nominal <= bounds[1]:
        return None, 0  # the value was rounded past the nominal value
    model = narrowed(test.model, name, bounds)
    reached = parameters_of(model)[name]
    if not np.allclose((reached.low, reached.high), bounds, rtol=1e-9, atol=0.0):
        return None, 0  # another parameter or direction determines the range
    try:
        narrow = design_test(model, test.spec, test.scenario)
    except FrictoolError:  # a value at the cut is outside the allowed range of the model
        return None, 0
    controllers = CandidateControllers(model, test.spec)
    examination = CandidateExamination(narrow, search_tests(narrow), controllers)
    passed, plants = examination.played(cut.candidate.design)
    if not passed:
        return None, plants
    whole = parameter.low, parameter.high
    return NarrowerRange(name, *bounds, whole, parameter.unit), plants


def narrowed(model: Model, name: str, bounds: tuple[float, float]) -> Model:
    """Return the model with a parameter's range and interval cut to `bounds`.

    The range in the bench describes the product's life, the interval in the model the axis today.
    If the parameter `name` is the Coulomb friction, and the ratio of breakaway to Coulomb friction
    is fixed, the breakaway keeps this ratio.

    """
    bench, today = model.bench, model.parameters
    if name == "constant":
        actuator = structs.replace(
            bench.actuator, constant=_within(bench.actuator.constant, bounds)
        )
        return structs.replace(model, bench=structs.replace(bench, actuator=actuator))
    estimate: Estimate = getattr(today, name)
    lifelong = getattr(bench.mechanics, name) or Quantity(
        estimate.value, *bounds, unit=estimate.unit
    )
    changed: dict[str, Estimate] = {name: _within(estimate, bounds)}
    if name == "coulomb" and breakaway_interval(model) is None:
        changed["breakaway"] = _in_proportion(today.breakaway, estimate, changed[name])
    mechanics = structs.replace(bench.mechanics, **{name: _within(lifelong, bounds)})
    return structs.replace(
        model,
        bench=structs.replace(bench, mechanics=mechanics),
        parameters=structs.replace(today, **changed),
    )


def _within(one: Range, bounds: tuple[float, float]) -> Range:
    value, low, high = (min(max(end, bounds[0]), bounds[1]) for end in (one.value, *one.interval))
    return structs.replace(one, value=value, low=low, high=high)


def _in_proportion(one: Estimate, before: Estimate, after: Estimate) -> Estimate:
    """Multiply the low end of `one` by the quotient of the low ends of `after` and `before`.

    Multiply the high end by the quotient of the high ends.
    """
    low, high = (
        end * new / old if old > 0.0 else end
        for end, old, new in zip(one.interval, before.interval, after.interval, strict=True)
    )
    return structs.replace(one, low=min(low, one.value), high=max(high, one.value))
