"""Table of trials, saved line by line while they run, printed, and written as JSON."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path

from studies.actuators.judge import REQUIREMENTS
from studies.actuators.trial import MET, MISSED, Trial, summary, try_actuator
from studies.kept_results import kept_results

SHORT = dict(
    zip(
        REQUIREMENTS,
        ("response", "overshoot", "error", "oscill.", "peak", "rest", "margin"),
        strict=True,
    )
)
HEADER = (
    f"{'no.':>4} {'synth':<8}{'judge':<7}{'search':<7}{'time':>7}  "
    + " ".join(f"{name:<9}" for name in SHORT.values())
    + "actuator"
)


def run_trials(seed: str, count: int, kept: Path, cores: int = 1) -> Iterator[Trial]:
    """Yield the trials of a seed as they end.

    Each trial is appended to the file `kept`. Trials of this seed in the file are not repeated.
    """
    yield from kept_results(seed, range(count), kept, try_actuator, Trial, cores)


def row(trial: Trial) -> str:
    """Return the line of a trial: verdicts, time, and value/limit of each requirement."""
    said = {MET: "met", MISSED: "missed", -1: "no end"}.get(trial.code, "refused")
    judged = "-" if not trial.met else "met" if trial.solved else "missed"
    cells = [_cell(trial, name) for name in REQUIREMENTS]
    found = str(trial.candidates) if trial.searched else "none"
    return (
        f"{trial.number:>4} {said:<8}{judged:<7}{found:<7}{trial.seconds:>6.1f}s  "
        + " ".join(f"{cell:<9}" for cell in cells)
        + trial.actuator
        + (f"\n     {trial.message}" if trial.message else "")
    )


def _cell(trial: Trial, name: str) -> str:
    if name not in trial.met:
        return "-"
    limit = trial.limits[name]
    share = f"{trial.worst[name] / limit:.2f}" if limit else f"{trial.worst[name]:g}"
    return share if trial.met[name] else f"{share} !"


def write_table(seed: str, trials: Sequence[Trial], target: Path) -> None:
    """Write summary and trials as JSON; an infinite figure is null."""
    ordered = sorted(trials, key=lambda trial: trial.number)
    document = {
        "seed": seed,
        "summary": summary(ordered),
        "trials": [{**asdict(trial), "worst": _finite(trial.worst)} for trial in ordered],
    }
    target.write_text(json.dumps(document, indent=2, allow_nan=False) + "\n")


def _finite(figures: Mapping[str, float]) -> dict[str, float | None]:
    return {name: value if math.isfinite(value) else None for name, value in figures.items()}
