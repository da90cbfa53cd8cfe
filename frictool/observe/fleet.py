"""A fleet's logs, a row each: observed side by side, compared with the earliest of each unit.

    logs ──one_log.py, shared by workers/──▶ Found, Found, ... ──commissioning.py, alarm.py──▶ Row, Row, ...

The rows are in the order of unit, date and file, whoever has ended first.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from frictool.documents.model import Model
from frictool.errors import FrictoolError
from frictool.logs.fleet import Member
from frictool.logs.origin import Origin, origin_by_name
from frictool.observe.one_log import THESE, Estimators, OneLog, Settings
from frictool.observe.outcome import Outcome
from frictool.workers.files import share_files

WORTH_SHARING = 50_000_000  # bytes of all logs, below which the start of further processes takes longer than they save


@dataclass(frozen=True)
class Found:
    """What a log has told, or why it could not. lost: whether it could not be read, or not whole."""

    member: Member
    origin: Origin
    outcome: Outcome | None
    reason: str = ""

    @property
    def lost(self) -> bool:
        return self.outcome is None or bool(self.outcome.losses)


def observed(
    fleet: Sequence[Member],
    model: Model,
    settings: Settings,
    estimators: Estimators = THESE,
    *,
    cores: int | None = None,
    cluster: str | None = None,
    tick: Callable[[float], None] = lambda part: None,
) -> list[Found]:
    """What each log tells, in the order given. cores, cluster: who does it, as `workers/share.py`; few bytes are observed in this process.

    tick: is told the part of them that is done.
    """
    few = sum(member.path.stat().st_size for member in fleet if member.path.is_file()) < WORTH_SHARING
    observe, jobs = Observe(model, settings, estimators), [((member.path,), member) for member in fleet]
    found: dict[int, Found] = {}
    for index, one in share_files(observe, jobs, observe.lost, cores=cores or (1 if few else None), cluster=cluster):
        found[index] = one
        tick(len(found) / len(fleet))
    return [found[index] for index in range(len(fleet))]


@dataclass(frozen=True)
class Observe:
    """One log, none of its samples kept, wherever it is read."""

    model: Model
    settings: Settings
    estimators: Estimators = THESE

    def __call__(self, paths: tuple[Path, ...], member: Member) -> Found:
        (path,) = paths
        try:
            one = OneLog(path, self.model, self.settings, member.name, self.estimators)
            for _ in one.parts():
                pass
            out = replace(one.outcome(), source=str(member.path))
            return Found(member, Origin(out.unit, out.date), out)
        except FrictoolError as error:
            return self.lost(member, str(error).removeprefix(f"{path}: "))
        except MemoryError:
            return self.lost(member, "needs more memory than there is")
        except OSError as error:
            return self.lost(member, f"cannot be read: {error.strerror or error}")
        except Exception as error:  # a mistake of ours with one log must not take the others along
            return self.lost(member, f"could not be observed ({type(error).__name__}: {error}); observe it alone to see more")

    def lost(self, member: Member, reason: str) -> Found:
        """In place of what it would have told."""
        return Found(member, origin_by_name(member.name, self.settings.patterns), None, reason)
