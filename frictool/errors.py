"""Every failure that frictool reports, each with its exit code.

====  =========================================================================
code  meaning
====  =========================================================================
0     done
1     done, and the answer is no or undecided: specification not met, parameter not identifiable
2     the command line is wrong (click raises it)
3     an input file is wrong, or part of its data could not be read
4     no solution: infeasible, not converged, not verified
====  =========================================================================

A message is one line: what was found, what is allowed, what to try.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, Self

EXIT_DONE = 0
EXIT_NO = 1
EXIT_INPUT = 3
EXIT_NO_SOLUTION = 4
EXIT_INTERRUPTED = 130  # the exit code of a shell after Ctrl-C


class FrictoolError(Exception):
    """Base class of the errors whose message is written for the user.

    - `exit_code`: exit code of the process
    - `document_key`: kind of the document, such as "design", and the wrong key; None if the error
      concerns no key. The command adds file and line to the message.
    """

    exit_code = EXIT_INPUT
    document_key: tuple[str, str] | None = None

    def __init__(self, message: str) -> None:
        super().__init__(" ".join(message.split()))

    def at(self, document: str, key: str) -> Self:
        """Set `document_key`, and return the error."""
        self.document_key = document, key
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle the error with its fields; unpickling does not call the constructor."""
        return _rebuilt, (type(self), self.args), self.__dict__


def _rebuilt(kind: type[FrictoolError], arguments: tuple[Any, ...]) -> FrictoolError:
    return kind.__new__(kind, *arguments)


class InputFileError(FrictoolError):
    """An input file is missing or damaged, or does not have the required form."""

    def __init__(self, path: Path | str, message: str, *, line: int | None = None) -> None:
        self.path = str(path)
        self.line = line
        where = self.path if line is None else f"{self.path}:{line}"
        super().__init__(f"{where}: {message}")


class DocumentError(InputFileError):
    """A key or value of a YAML document is wrong; the message names file, line and key."""

    def __init__(self, path: Path | str, message: str, *, line: int | None, key: str) -> None:
        self.key = key
        super().__init__(path, f"{key}: {message}" if key else message, line=line)


class LogError(InputFileError):
    """A log cannot be read, or lacks channels that a command needs."""


class OutputError(FrictoolError):
    """The output cannot be written, or would overwrite an input."""


class NoSolutionError(FrictoolError):
    """There is no solution, the solver did not converge, or the verification failed."""

    exit_code = EXIT_NO_SOLUTION


class WorkerLost(FrictoolError):
    """Several worker processes crashed, one after another, on the same job.

    `job`: index of the job in the list of jobs; None if no job began.
    """

    def __init__(self, job: int | None, message: str) -> None:
        self.job = job
        super().__init__(message)


class ClusterError(FrictoolError):
    """A cluster is not reachable, has stopped, or runs another version of frictool."""
