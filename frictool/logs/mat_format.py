"""MATLAB files up to version 7 (level 5): each real numeric vector is a column."""

from __future__ import annotations

from pathlib import Path

from frictool.errors import LogError
from frictool.logs.mat_elements import Variable, variables
from frictool.logs.raw_table import RawTable, Wanted, listed, pick
from frictool.logs.source import open_log


def read_mat(path: Path, wanted: Wanted | None = None) -> RawTable:
    """The vectors of a MATLAB file, as float64; `wanted` (names, or numbers from 1) leaves the others unread.

    Raises LogError where the file is damaged, or where a variable that is asked for is missing or no vector: the message lists the vectors.
    """
    try:
        with open_log(path) as stream:
            found = {variable.name: variable for variable in variables(stream, path.stat().st_size)}
        chosen = _chosen(path, found, wanted)
        columns = {name: found[name].numbers() for name in chosen}
    except OSError as error:
        raise LogError(path, f"cannot be read: {error.strerror or error}") from None
    except ValueError as error:
        raise LogError(path, f"is damaged or no MATLAB file up to version 7: {error}") from None
    names = tuple(name for name, variable in found.items() if variable.is_vector)
    return RawTable(columns, dict.fromkeys(names), str(path), names)


def _chosen(path: Path, found: dict[str, Variable], wanted: Wanted | None) -> tuple[str, ...]:
    """The names of the vectors that are asked for, each once."""
    vectors = tuple(name for name, variable in found.items() if variable.is_vector)
    if not vectors:
        raise LogError(path, f"has no real numeric vector; found: {listed([f'{name} ({variable})' for name, variable in found.items()])}")
    for name in wanted or ():
        if isinstance(name, str) and name in found and not found[name].is_vector:
            raise LogError(path, f"variable {name!r} is a {found[name]}; allowed: a real vector: {listed(vectors)}")
    return vectors if wanted is None else tuple(dict.fromkeys(pick(vectors, one, str(path), "variable") for one in wanted))
