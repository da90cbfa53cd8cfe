"""Simulation of the tests of thesis 3.7 with each law; comparison with the exact Stribeck law."""

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
from frictool.compare.trajectory import LawTrajectory
from frictool.runtime.object_view import ResultView
from frictool.typing import Vector

# law with which all laws are compared: rigid stick and Stribeck curve, simulated event by event
REFERENCE = "stribeck"
POINTS_PER_LEG = 1000  # points between two turning points of the presliding path
# number of samples of the stored trajectories
SAMPLES = {"stick_slip": 60_001, "limit_cycle": 60_001, "drift": 102_001}


class LawRunner(Protocol):
    """Interface of a simulator of friction laws, such as LawSimulator of law_simulator.py."""

    def names(self) -> tuple[str, ...]:
        """Return the names of the laws, in the order in which tables show them."""

    def title(self, law: str) -> str:
        """Return the name of the law for display."""

    def parameters(self, law: str) -> int:
        """Return the number of physical parameters of the law."""

    def run(
        self, law: str, segments: tuple[input_protocol.Segment, ...], samples: int
    ) -> LawTrajectory:
        """Simulate a law from rest under the efforts `segments`; return equidistant samples."""

    def creep(self, law: str, path: Vector, speed: float) -> Vector | None:
        """Return the friction [N | N m] along the positions `path` at constant `speed`.

        Returns None if the contact is rigid below breakaway.
        """

    def properties(self, law: str, compliance: bool, drift: LawTrajectory) -> dict[str, str]:
        """Return the symbols of those rows of thesis table 2.1 that simulations can determine.

        - compliance: True if the contact is compliant in presliding
        - drift: trajectory of the drift test
        """


@dataclass(frozen=True)
class LawResult:
    """Measures, verdicts and trajectories of one law.

    - verdicts: symbol in each row of thesis table 3.2
    - properties: symbol in each row of thesis table 2.1
    - runs: trajectory of each test, by the name of the test
    - loop: positions and friction of the presliding test; None for a rigid contact
    """

    title: str
    stick_slip: stick_slip_criterion.StickSlipResult
    limit_cycle: limit_cycle_criterion.LimitCycleResult
    presliding: presliding_criterion.PreslidingResult
    drift: drift_criterion.DriftResult
    verdicts: dict[str, str]
    properties: dict[str, str]
    runs: dict[str, LawTrajectory] = field(repr=False)
    loop: tuple[Vector, Vector] | None = field(repr=False)


@dataclass(frozen=True, eq=False, repr=False)
class Comparison(ResultView):
    """Results of the laws by name, and differences from the thesis's tables 2.1 and 3.2.

    `reference`, `reference_cycle`: results of the Stribeck law in the stick-slip and in the
        limit-cycle test, simulated event by event.
    """

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
    """Simulate the four tests with each law, and compare the results with the Stribeck law.

    Parameters
    ----------
    setting : ComparisonSetting
        Parameters of the laws and scales of the tests.
    simulator : LawRunner
        Simulator of the laws; must be picklable if `workers` is not 1.
    laws : tuple of str
        Names of the laws.
    progress : callable
        `progress(done, total)` is called before the first law and after each law.
    workers : int
        Number of processes; the results do not depend on this number.

    Returns
    -------
    Comparison
        Results of the laws in the order of `laws`.

    Raises
    ------
    NoSolutionError
        If a law cannot be simulated with these parameters.
    """
    progress(0, len(laws))
    reference_runs = _runs(setting, simulator, REFERENCE)
    pulled, cycling = _measured(setting, reference_runs)
    job = partial(_tested, setting, simulator, pulled, cycling)
    results = {}
    with _pool(min(workers, len(laws))) as share_out:
        for law, tested in zip(laws, share_out(job, laws), strict=True):
            results[law] = tested
            progress(len(results), len(laws))
    verdicts = {law: tested.verdicts for law, tested in results.items()}
    properties = {law: tested.properties for law, tested in results.items()}
    return Comparison(
        setting, pulled, cycling, results, tuple(table_differences(verdicts, properties))
    )


@contextmanager
def _pool(workers: int) -> Iterator[Callable[..., Iterable[LawResult]]]:
    """Yield a function like `map` that runs in `workers` processes.

    For one worker, the function runs in this process.
    """
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
