"""Observation of the logs of a fleet in parallel, with one result per log.

logs ──log_observer.py, run by workers/──▶ FleetResult, FleetResult, ...
     ──commissioning.py, wear_limit.py──▶ rows (fleet_table.py)
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from frictool.documents.model import Model
from frictool.errors import FrictoolError
from frictool.logs.fleet import FleetLog
from frictool.logs.origin import LogOrigin, origin_by_name
from frictool.observe.log_observer import (
    THESE,
    EstimatorFactories,
    LogObserver,
    ObservationSettings,
)
from frictool.observe.observation_outcome import ObservationOutcome
from frictool.workers.file_transfer import share_files

# total size of the logs, bytes, below which parallel processes save no time
WORTH_SHARING = 50_000_000


@dataclass(frozen=True)
class FleetResult:
    """Outcome of the observation of one log, or the reason why there is no outcome."""

    member: FleetLog
    origin: LogOrigin
    outcome: ObservationOutcome | None
    reason: str = ""

    @property
    def lost(self) -> bool:
        """Return True if all or part of the log could not be read."""
        return self.outcome is None or bool(self.outcome.losses)


def observe_logs(
    fleet: Sequence[FleetLog],
    model: Model,
    settings: ObservationSettings,
    estimators: EstimatorFactories = THESE,
    *,
    cores: int | None = None,
    cluster: str | None = None,
    tick: Callable[[float], None] = lambda part: None,
) -> list[FleetResult]:
    """Observe the logs of a fleet, and return one result per log in the order of `fleet`.

    - cores: number of local processes. If `cores` and `cluster` are None, a few small logs are
      observed in this process, other fleets in several processes.
    - cluster: address of a Dask cluster, used in place of local processes
    - tick: callback that takes the completed fraction (0 to 1)
    """
    few = (
        sum(member.path.stat().st_size for member in fleet if member.path.is_file()) < WORTH_SHARING
    )
    observe = ObserveJob(model, settings, estimators)
    jobs = [((member.path,), member) for member in fleet]
    results: dict[int, FleetResult] = {}
    for index, one in share_files(
        observe, jobs, observe.lost, cores=cores or (1 if few else None), cluster=cluster
    ):
        results[index] = one
        tick(len(results) / len(fleet))
    return [results[index] for index in range(len(fleet))]


@dataclass(frozen=True)
class ObserveJob:
    """Picklable callable that observes one log; the result contains no samples."""

    model: Model
    settings: ObservationSettings
    estimators: EstimatorFactories = THESE

    def __call__(self, paths: tuple[Path, ...], member: FleetLog) -> FleetResult:
        """Observe the only log in `paths`; return its outcome, or why there is no outcome."""
        (path,) = paths
        try:
            one = LogObserver(path, self.model, self.settings, member.name, self.estimators)
            for _ in one.parts():
                pass
            out = replace(one.outcome(), source=str(member.path))
            return FleetResult(member, LogOrigin(out.unit, out.date), out)
        except FrictoolError as error:
            return self.lost(member, str(error).removeprefix(f"{path}: "))
        except MemoryError:
            return self.lost(member, "needs more memory than this machine has")
        except OSError as error:
            return self.lost(member, f"cannot be read: {error.strerror or error}")
        except Exception as error:  # a defect of this program must not stop the other logs
            return self.lost(
                member,
                f"could not be observed ({type(error).__name__}: {error}); "
                "observe this log alone for details",
            )

    def lost(self, member: FleetLog, reason: str) -> FleetResult:
        """Return the result of a log that could not be observed, with the reason."""
        return FleetResult(
            member, origin_by_name(member.name, self.settings.patterns), None, reason
        )
