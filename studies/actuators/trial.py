"""Trial: frictool designs a controller for an actuator, and the judge simulates the exported C.

The commands are those of a user. synth runs in a separate process, whose processor time is
measured:

    frictool synth model.yaml --spec spec.yaml --vertices-only -o controller.yaml
    frictool export controller.yaml --lang c -o c
"""

from __future__ import annotations

import resource
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from statistics import median

import yaml

from studies.actuators import documents
from studies.actuators.drawing import Actuator, draw, draw_plants
from studies.actuators.judge import Verdict, judge
from studies.actuators.margin import margin
from studies.actuators.native import load_exported
from studies.actuators.search import search
from studies.command_line import run

LONGEST = 600  # s of processor time, of each process of synth
MET, MISSED = 0, 1  # exit codes of synth with a controller


@dataclass(frozen=True)
class Trial:
    """Result for one actuator; the judge computes `worst` and `met`, empty without a controller."""

    number: int
    actuator: str  # description of the actuator in one line
    code: int  # exit code of synth, -1 if a process reached LONGEST
    seconds: float  # processor time of synth
    message: str  # last line of a command that ended without a controller
    searched: bool  # the judge's search found a controller
    candidates: int  # number of candidates that the search needed
    worst: dict[str, float] = field(default_factory=dict)
    limits: dict[str, float] = field(default_factory=dict)
    met: dict[str, bool] = field(default_factory=dict)
    plants_met: int = 0

    @property
    def claimed(self) -> bool:
        """Return True if synth reports that the specification is met."""
        return self.code == MET

    @property
    def solved(self) -> bool:
        """Return True if the judge finds that all plants meet the specification."""
        return bool(self.met) and all(self.met.values())


def try_actuator(seed: str, number: int) -> Trial:
    """Return the trial of one actuator of a seed."""
    actuator = draw(seed, number)
    plants = draw_plants(actuator, seed)
    found = search(actuator, plants)
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        documents.write(actuator, folder)
        code, seconds, message = _synth(folder)
        trial = Trial(
            number, describe(actuator), code, seconds, message, found.solved, found.candidates
        )
        if code not in (MET, MISSED):
            return trial
        exported = run("export", folder / "controller.yaml", "--lang", "c", "-o", folder / "c")
        if exported.code != 0:
            return replace(trial, message=exported.stderr.strip())
        try:
            verdict = verdict_of(actuator, seed, folder)
        except (NotImplementedError, RuntimeError) as error:
            return replace(trial, message=f"not judged: {error}")
    return replace(
        trial,
        message="",
        worst=verdict.worst,
        limits=verdict.limits,
        met=verdict.met,
        plants_met=sum(verdict.plants),
    )


def verdict_of(actuator: Actuator, seed: str, folder: Path) -> Verdict:
    """Return the judge's verdict on folder/controller.yaml with its exported C in folder/c."""
    plants = draw_plants(actuator, seed)
    document = yaml.load((folder / "controller.yaml").read_text(), Loader=yaml.CSafeLoader)
    margins = [margin(actuator, plant, document) for plant in plants]
    return judge(actuator, load_exported(folder / "c"), plants, margins)


def describe(actuator: Actuator) -> str:
    """Return a line with the numbers that determine how difficult an actuator is."""
    nominal = actuator.constant.value * actuator.limit
    return (
        f"{actuator.axis} {actuator.drive}, {1e3 * actuator.period:g} ms, "
        f"{actuator.response / actuator.period:.0f} periods, "
        f"bang-bang {actuator.bang_bang / actuator.response:.0%}, delay {actuator.delay}, "
        f"lag {actuator.lag / actuator.period:.1f}, "
        f"{actuator.amplitude / actuator.encoder_step:.0f} counts, "
        f"friction {actuator.coulomb.high / nominal:.0%} "
        f"by {actuator.coulomb.high / actuator.coulomb.low:.1f}"
    )


def _synth(folder: Path) -> tuple[int, float, str]:
    """Return exit code, processor time [s] and the last line on stderr of synth."""
    before = _children_time()
    words = ["synth", "model.yaml", "--spec", "spec.yaml", "--vertices-only"]
    command = [sys.executable, "-m", "frictool", *words, "-o", "controller.yaml"]
    done = subprocess.run(
        command,
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
        preexec_fn=partial(resource.setrlimit, resource.RLIMIT_CPU, (LONGEST, LONGEST)),
    )
    code, lines = done.returncode, done.stderr.strip().splitlines()
    if code < 0:  # a signal
        code, lines = -1, [f"ended by signal {-code}; allowed: {LONGEST} s of processor time"]
    return code, _children_time() - before, lines[-1] if lines else ""


def _children_time() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def summary(trials: Sequence[Trial]) -> dict[str, float]:
    """Return counts and rates of trials."""
    claimed = [trial for trial in trials if trial.claimed]
    searched = [trial for trial in trials if trial.searched]
    return {
        "actuators": len(trials),
        "met": sum(trial.solved for trial in trials),
        "met_rate": _rate(trials),
        "search_solves": len(searched),
        "met_rate_of_solvable": _rate(searched),
        "refused_but_solvable": sum(trial.code not in (MET, MISSED) for trial in searched),
        "claimed_met": len(claimed),
        "false_met": sum(not trial.solved for trial in claimed),
        "false_met_rate": 1.0 - _rate(claimed),
        "median_seconds": median(trial.seconds for trial in trials),
    }


def _rate(trials: Sequence[Trial]) -> float:
    """Return the share of trials that the judge accepts; 1 if there are none."""
    return sum(trial.solved for trial in trials) / len(trials) if trials else 1.0
