"""What a bench file holds before its columns mean anything: named columns of numbers."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Collection
from dataclasses import dataclass, field

from frictool.errors import LogError
from frictool.logs.log import Vector

Wanted = Collection[str | int]  # columns by name, or by number from 1
MOST_NAMES_SHOWN = 12


@dataclass(frozen=True)
class RawTable:
    """Columns of a bench file as they stand in it.

    columns: name -> (n,) numbers, those that were asked for. units: name -> unit that the file gives, or None. names: all columns
    of the file in its order, so that one can be asked for by its number. line_of: from a row, from 0, to its line in the file, where
    the file has lines.
    """

    columns: dict[str, Vector]
    units: dict[str, str | None]
    source: str
    names: tuple[str, ...] = ()
    line_of: Callable[[int], int] | None = field(default=None, repr=False)

    def line(self, row: int) -> int | None:
        """The line of a row in the file, or None where the file has no lines."""
        return None if self.line_of is None else self.line_of(row)

    def fail_at(self, row: int, message: str) -> LogError:
        """The error about one row: it names the line, or the sample where the file has no lines."""
        line = self.line(row)
        return LogError(self.source, message if line is not None else f"sample {row + 1}, {message}", line=line)


def pick(names: tuple[str, ...], wanted: str | int, source: str, kind: str = "column") -> str:
    """The name of the column that is asked for by name or by number from 1.

    Raises LogError with the nearest name and what there is.
    """
    if isinstance(wanted, int):
        if 1 <= wanted <= len(names):
            return names[wanted - 1]
        raise LogError(source, f"has no {kind} {wanted}; it has {len(names)}: {listed(names)}")
    if wanted in names:
        return wanted
    near = difflib.get_close_matches(wanted, names, n=1, cutoff=0.5)
    hint = f" (did you mean {near[0]!r}?)" if near else ""
    raise LogError(source, f"has no {kind} {wanted!r}{hint}; found: {listed(names)}")


def listed(names: Collection[str]) -> str:
    """Names for a message, not more than fit a line."""
    shown = list(names)[:MOST_NAMES_SHOWN]
    return ", ".join(shown) + (f" and {len(names) - len(shown)} more" if len(names) > len(shown) else "") if shown else "nothing"
