"""MATLAB files up to version 7 (level 5): each numeric vector is a column."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np

from frictool.errors import LogError
from frictool.logs.raw_table import RawTable, Wanted, listed, pick
from frictool.logs.source import open_log

NUMERIC = frozenset(
    ("double", "single", "int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64", "logical")
)  # MATLAB's classes


def read_mat(path: Path, wanted: Wanted | None = None) -> RawTable:
    """The vectors of a MATLAB file, as float64; `wanted` (names, or numbers from 1) leaves the others unread.

    Raises LogError where the file is damaged, or where a variable that is asked for is missing or no vector: the message lists the vectors.
    """
    open_log(path).close()
    found: list[tuple[str, tuple[int, ...], str]] = _scipy(path, "whosmat")
    vectors = tuple(name for name, shape, kind in found if kind in NUMERIC and len(shape) == 2 and min(shape) == 1 < max(shape))
    if not vectors:
        raise LogError(path, f"has no numeric vector; found: {listed([f'{n} ({_shape(s)} {k})' for n, s, k in found])}")
    others = {name: f"{_shape(shape)} {kind}" for name, shape, kind in found if name not in vectors}
    for name in wanted or ():
        if name in others:
            raise LogError(path, f"variable {name!r} is a {others[str(name)]}; allowed: a numeric vector: {listed(vectors)}")
    chosen = vectors if wanted is None else tuple(dict.fromkeys(pick(vectors, one, str(path), "variable") for one in wanted))
    loaded: dict[str, Any] = _scipy(path, "loadmat", variable_names=list(chosen))
    columns = {}
    for name in chosen:
        values = np.asarray(loaded[name])
        if np.iscomplexobj(values):
            raise LogError(path, f"variable {name!r} is complex; allowed: real numbers")
        columns[name] = values.astype(np.float64).ravel()
    return RawTable(columns, dict.fromkeys(vectors), str(path), vectors)


def _shape(shape: tuple[int, ...]) -> str:
    return "x".join(map(str, shape))


def _scipy(path: Path, function: str, **options: Any) -> Any:
    import scipy.io

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # duplicate variables: the last one counts, as in MATLAB
            return getattr(scipy.io, function)(str(path), appendmat=False, **options)
    except Exception as error:  # on damaged files scipy raises a dozen unrelated types
        raise LogError(path, f"is damaged or no MATLAB file up to version 7: {str(error) or type(error).__name__}") from None
