"""Every failure that frictool reports, each with its exit code.

====  =========================================================================
code  meaning
====  =========================================================================
0     done
1     done, and the answer is no or undecided: specification not met, parameter not identifiable
2     the command line is wrong (click raises it)
3     an input file is wrong, or was read with data lost
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
EXIT_INTERRUPTED = 130  # as a shell has it


class FrictoolError(Exception):
    """Root of every error that a user is meant to read.

    exit_code: the process's exit code. document_key: the name of a document, as `design`, and its
    wrong key; a command adds file and line.
    """

    exit_code = EXIT_INPUT
    document_key: tuple[str, str] | None = None

    def __init__(self, message: str) -> None:
        super().__init__(" ".join(message.split()))

    def at(self, document: str, key: str) -> Self:
        """Return the error, now of this key of a document."""
        self.document_key = document, key
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        """From another process it comes back as it was, whatever its constructor takes."""
        return _rebuilt, (type(self), self.args), self.__dict__


def _rebuilt(kind: type[FrictoolError], arguments: tuple[Any, ...]) -> FrictoolError:
    """An error with these `args`, its constructor not called."""
    return kind.__new__(kind, *arguments)


class InputFileError(FrictoolError):
    """An input file cannot be used: it is missing, damaged, or not of the form that is asked
    for."""

    def __init__(self, path: Path | str, message: str, *, line: int | None = None) -> None:
        self.path = str(path)
        self.line = line
        where = self.path if line is None else f"{self.path}:{line}"
        super().__init__(f"{where}: {message}")


class DocumentError(InputFileError):
    """A YAML document breaks its type: unknown key, wrong unit, out of range, missing (with file,
    line and key)."""

    def __init__(self, path: Path | str, message: str, *, line: int | None, key: str) -> None:
        self.key = key
        super().__init__(path, f"{key}: {message}" if key else message, line=line)


class LogError(InputFileError):
    """A log cannot be read, or its channels do not give what a stage needs."""


class OutputError(FrictoolError):
    """The output cannot be written, or would overwrite an input."""


class NoSolutionError(FrictoolError):
    """Infeasible, not converged, or found and then not verified."""

    exit_code = EXIT_NO_SOLUTION


class WorkerLost(FrictoolError):
    """A job that several processes in turn did not outlive. job: its index among those that were
    shared, None where none began."""

    def __init__(self, job: int | None, message: str) -> None:
        self.job = job
        super().__init__(message)


class ClusterError(FrictoolError):
    """A cluster that cannot be reached, is gone, or whose workers are not what this machine is."""
