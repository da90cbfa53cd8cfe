"""Judgement of the intervals, claims and warnings of `identify` on recordings with known truth."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from frictool.adapters.parameter_intervals import absolute
from frictool.documents.bench import Bench
from frictool.documents.model import Model
from frictool.documents.registry import load
from frictool.errors import FrictoolError
from frictool.identify import identify
from frictool.identify.methods import IdentificationRequest
from studies.violations.families import FAMILIES, MILD, draw_violation
from studies.violations.recording import Recording, record
from studies.violations.true_structure import least_squares_refuses

PARAMETERS = ("inertia", "viscous", "coulomb", "offset")
LOADS = ("stiffness", "gravity", "ripple")


@dataclass(frozen=True)
class Verdict:
    """Judgement of one record.

    - held: parameter -> True if the interval contains the truth. A parameter is missing here if
      both `identify` and least squares with the true structure refuse it.
    - half, error: half width and error of each identified parameter, relative to the scale of the
      truth (`_scale`)
    - refused: parameters that are not identified
    - false_claims: loads, knees and resonances that the machine does not have
    - seconds: processor time of the identification [s]
    """

    family: str
    number: int
    test: str
    severity: float
    method: str
    held: dict[str, bool]
    half: dict[str, float]
    error: dict[str, float]
    refused: dict[str, str]
    false_claims: tuple[str, ...]
    warnings: tuple[str, ...]
    seconds: float

    @property
    def mild(self) -> bool:
        """Return True if the violation is mild."""
        return self.severity < MILD


def judge(seed: str, family: str, number: int, method: str = "auto") -> Verdict:
    """Return the verdict on record `number` of a family, identified with defaults."""
    recording = record(draw_violation(seed, family, number), f"{seed}/{family}/{number}")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "bench.yaml")
        path.write_text(recording.bench)
        bench = load(path, Bench)
    start = time.process_time()
    try:
        outcome = identify([recording.log], bench, IdentificationRequest(method=method))
    except FrictoolError as error:
        return _verdict(family, number, recording, None, bench, str(error), start)
    refused = dict(outcome.result.refused)
    verdict = _verdict(family, number, recording, outcome.model, bench, refused, start)
    warnings = outcome.result.warnings
    return Verdict(**{**vars(verdict), "warnings": warnings})


def _verdict(
    family: str,
    number: int,
    recording: Recording,
    model: Model | None,
    bench: Bench,
    reasons: dict[str, str] | str,
    start: float,
) -> Verdict:
    seconds = time.process_time() - start
    held, half, error, refused = {}, {}, {}, {}
    truth = dict(recording.truth)
    laws = None if model is None else model.laws
    claims = [
        name
        for name in LOADS
        if laws is not None and laws.load is not None and getattr(laws.load, name) is not None
    ]
    if "stiffness" not in claims and "gravity" not in claims:
        truth["offset"] = truth["offset_with_loads"]
    if laws is not None and laws.backward is not None and laws.backward.viscous is not None:
        truth["viscous"] = truth["viscous_forward"]
    claims += ["regimes"] if laws is not None and laws.regimes else []
    claims += ["resonances"] if model is not None and model.resonances is not None else []
    for name in PARAMETERS:
        estimate = None if model is None else getattr(model.parameters, name)
        if estimate is None or estimate.source != "identified":
            reason = reasons if isinstance(reasons, str) else reasons.get(name, "")
            refused[name] = reason
            if not least_squares_refuses(recording, name):
                held[name] = False
            continue
        low, high = estimate.interval
        if FAMILIES[family].absolute:
            low, high = absolute(low, high, bench.actuator.constant)
        held[name] = bool(low <= truth[name] <= high)
        scale = _scale(truth, name)
        half[name] = 0.5 * (high - low) / scale
        error[name] = (estimate.value - truth[name]) / scale
    return Verdict(
        family,
        number,
        recording.machine.test,
        recording.machine.severity,
        "" if model is None else model.method,
        held,
        half,
        error,
        refused,
        tuple(claim for claim in claims if claim not in FAMILIES[family].claims),
        (),
        seconds,
    )


def _scale(truth: dict[str, float], name: str) -> float:
    """Return the value by which an error is divided: the true value or the Coulomb friction."""
    return truth["coulomb" if name == "offset" else name]


@dataclass(frozen=True)
class FamilySummary:
    """Results of one family.

    - held: parameter -> (number of intervals that contain the truth, number of judged records)
    - ratio: parameter -> median half width divided by rms error
    - half: parameter -> median half width, relative
    - warned, mild_warned: share of records with a warning, of all and of the mild ones
    - false: share of records with a false load, knee or resonance
    - refused: number of refused parameters
    """

    family: str
    records: int
    held: dict[str, tuple[int, int]]
    ratio: dict[str, float]
    half: dict[str, float]
    warned: float
    mild_warned: float
    false: float
    refused: int
    seconds: float


def summary(family: str, verdicts: Sequence[Verdict]) -> FamilySummary:
    """Return the summary of a family's verdicts."""
    held, ratio, half = {}, {}, {}
    for name in PARAMETERS:
        judged = [one.held[name] for one in verdicts if name in one.held]
        held[name] = (sum(judged), len(judged))
        widths = [one.half[name] for one in verdicts if name in one.half]
        errors = np.array([one.error[name] for one in verdicts if name in one.error])
        half[name] = float(np.median(widths)) if widths else float("nan")
        error = float(np.sqrt(np.mean(errors**2))) if errors.size else float("nan")
        ratio[name] = half[name] / error if error > 0.0 else float("nan")
    mild = [one for one in verdicts if one.mild]
    return FamilySummary(
        family,
        len(verdicts),
        held,
        ratio,
        half,
        sum(bool(one.warnings) for one in verdicts) / max(len(verdicts), 1),
        sum(bool(one.warnings) for one in mild) / max(len(mild), 1),
        sum(bool(one.false_claims) for one in verdicts) / max(len(verdicts), 1),
        sum(len(one.refused) for one in verdicts),
        float(np.median([one.seconds for one in verdicts])),
    )


def pooled(summaries: Sequence[FamilySummary]) -> float:
    """Return the share of intervals that contain the truth, over all families and parameters."""
    hits = sum(one.held[name][0] for one in summaries for name in PARAMETERS)
    return hits / max(sum(one.held[name][1] for one in summaries for name in PARAMETERS), 1)
