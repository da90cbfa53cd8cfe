"""Runs the four tests on each law and judges it; the event-exact Stribeck law is what the others
are compared with (3.7)."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from multiprocessing import get_context
from typing import Protocol

from frictool.compare import (
    drift_criterion,
    input_protocol,
    limit_cycle_criterion,
    presliding_criterion,
    stick_slip_criterion,
)
from frictool.compare.comparison_setting import ComparisonSetting
from frictool.compare.thesis_tables import TableDifference, table_differences
from frictool.compare.trajectory import LawTrajectory, Vector

# a rigid stick and the Stribeck curve, event-exact: LuGre is a comparison and not the truth
REFERENCE = "stribeck"
POINTS_PER_LEG = 1000  # of the presliding path
SAMPLES = {
    "stick_slip": 60_001,
    "limit_cycle": 60_001,
    "drift": 102_001,
}  # of the kept trajectories


class LawRunner(Protocol):
    """What runs a law. `compare/law_simulator.py` is the one that the command uses."""

    def names(self) -> tuple[str, ...]:
        """The laws that can be run, in the order of the table."""

    def title(self, law: str) -> str:
        """What people call it."""

    def parameters(self, law: str) -> int:
        """How many physical parameters it has to be identified, those of the simulation
        excluded."""

    def run(
        self, law: str, segments: tuple[input_protocol.Segment, ...], samples: int
    ) -> LawTrajectory:
        """A run from rest through all segments, with `samples` equidistant samples."""

    def creep(self, law: str, path: Vector, speed: float) -> Vector | None:
        """The friction [N | N m] along a prescribed path at a prescribed speed; None where the
        contact is rigid below breakaway."""

    def properties(self, law: str, compliance: bool, drift: LawTrajectory) -> dict[str, str]:
        """The cells of table 2.1, by row, that follow from probes of the law; `drift`: its run of
        the drift test."""


@dataclass(frozen=True)
class LawResult:
    """One law: its figures, its verdicts, and what they were measured on."""

    title: str
    stick_slip: stick_slip_criterion.StickSlipResult
    limit_cycle: limit_cycle_criterion.LimitCycleResult
    presliding: presliding_criterion.PreslidingResult
    drift: drift_criterion.DriftResult
    verdicts: dict[str, str]
    properties: dict[str, str]
    runs: dict[str, LawTrajectory] = field(repr=False)
    loop: tuple[Vector, Vector] | None = field(repr=False)


@dataclass(frozen=True)
class Comparison:
    """All laws asked for, by name, and where tables 2.1 and 3.2 differ from the print."""

    setting: ComparisonSetting
    reference: stick_slip_criterion.StickSlipResult
    reference_cycle: limit_cycle_criterion.LimitCycleResult
    laws: dict[str, LawResult]
    differences: tuple[TableDifference, ...]


def compare(
    setting: ComparisonSetting,
    simulator: LawRunner,
    laws: tuple[str, ...],
    progress: Callable[[int, int], None] = lambda done, total: None,
    workers: int = 1,
) -> Comparison:
    """Every test on every law of `laws`. `progress(done, total)` is called before the first and
    after each.

    With several `workers` the laws are shared out among processes, which changes no figure;
    `simulator` then has to be picklable.
    """
    progress(0, len(laws))
    reference_runs = _runs(setting, simulator, REFERENCE)
    pulled, cycling = _measured(setting, reference_runs)
    job = partial(_tested, setting, simulator, pulled, cycling)
    found = {}
    with _pool(min(workers, len(laws))) as share_out:
        for law, tested in zip(laws, share_out(job, laws), strict=True):
            found[law] = tested
            progress(len(found), len(laws))
    verdicts = {law: tested.verdicts for law, tested in found.items()}
    properties = {law: tested.properties for law, tested in found.items()}
    return Comparison(
        setting, pulled, cycling, found, tuple(table_differences(verdicts, properties))
    )


@contextmanager
def _pool(workers: int) -> Iterator[Callable[..., Iterable[LawResult]]]:
    """A `map` over processes, or over this one. Processes start afresh, inheriting no state; an
    interruption ends them with the block."""
    if workers <= 1:
        yield map
        return
    with get_context("spawn").Pool(workers, signal.signal, (signal.SIGINT, signal.SIG_IGN)) as pool:
        yield pool.imap


def _runs(setting: ComparisonSetting, simulator: LawRunner, law: str) -> dict[str, LawTrajectory]:
    inputs = {
        "stick_slip": input_protocol.stick_slip,
        "limit_cycle": input_protocol.limit_cycle,
        "drift": input_protocol.drift,
    }
    return {
        test: simulator.run(law, make(setting.scales), SAMPLES[test])
        for test, make in inputs.items()
    }


def _measured(
    setting: ComparisonSetting, runs: dict[str, LawTrajectory]
) -> tuple[stick_slip_criterion.StickSlipResult, limit_cycle_criterion.LimitCycleResult]:
    return stick_slip_criterion.measure(
        runs["stick_slip"], setting.stribeck_velocity
    ), limit_cycle_criterion.measure(runs["limit_cycle"], setting.presliding)


def _tested(
    setting: ComparisonSetting,
    simulator: LawRunner,
    reference: stick_slip_criterion.StickSlipResult,
    reference_cycle: limit_cycle_criterion.LimitCycleResult,
    law: str,
) -> LawResult:
    """All tests on one law, judged against the reference's."""
    runs = _runs(setting, simulator, law)
    pulled, cycling = _measured(setting, runs)
    loop, contact = _presliding(setting, simulator, law)
    wander = drift_criterion.measure(runs["drift"], setting.presliding, setting.scales.time)
    parameters = str(simulator.parameters(law))
    verdicts = {
        "stick_slip": pulled.verdict(reference),
        "limit_cycle": cycling.verdict(reference_cycle),
        "presliding": contact.verdict,
        "drift": wander.verdict,
        "parameters": parameters,
    }
    measured = {
        "presliding": "+" if contact.compliance else "-",
        "non_drift": wander.verdict,
        "parameters": parameters,
    }
    nonlocal_memory = {"nonlocal_memory": "+" if contact.verdict == "+" else "-"}
    properties = {
        **simulator.properties(law, contact.compliance, runs["drift"]),
        **measured,
        **nonlocal_memory,
    }
    return LawResult(
        simulator.title(law), pulled, cycling, contact, wander, verdicts, properties, runs, loop
    )


def _presliding(
    setting: ComparisonSetting, simulator: LawRunner, law: str
) -> tuple[tuple[Vector, Vector] | None, presliding_criterion.PreslidingResult]:
    path, turning = input_protocol.presliding_path(setting.presliding, POINTS_PER_LEG)
    friction = simulator.creep(law, path, input_protocol.CREEP_SPEED * setting.scales.speed)
    if friction is None:
        return None, presliding_criterion.RIGID
    return (path, friction), presliding_criterion.measure(
        path, friction, turning, setting.breakaway, setting.presliding
    )
