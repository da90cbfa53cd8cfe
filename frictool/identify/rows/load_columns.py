"""Regressors of loads (`load_terms`), smoothed in the same way as the position.

    viscous_backward             (v - |v|)/2, viscous friction backward minus forward
    stiffness                    x
    gravity_sine, _cosine        sin x, cos x
    ripple_sine, _cosine         sin n x, cos n x

x is the position, v the velocity, and n the wave number of the ripple. The columns of declared
effects (`effects`) follow.

A harmonic needs sufficient travel: over a short distance, a sine cannot be separated from a spring,
and a cosine cannot be separated from an offset.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from frictool.documents.bench import Bench
from frictool.identify.fit_result import UnusableLogs
from frictool.identify.regression.tsqr import Tensor, merged
from frictool.identify.rows.effects import SmoothedMotion, declared_effects
from frictool.identify.rows.load_terms import (
    DECLARED,
    DIRECTION,
    HARMONICS,
    TERMS,
    declared_terms,
    wave_number,
)
from frictool.identify.rows.smoothing import smoothing_kernel
from frictool.typing import Vector

# least share of a harmonic's column that the other columns do not explain; the share is 1 over
# whole cycles
LEAST_SHARE = 0.005


def load_columns(motion: SmoothedMotion, bench: Bench) -> dict[str, Vector]:
    """Return the column (m,) of each parameter of the bench's load terms, by name.

    The columns are computed at the samples `motion.rows`.

    Raises UnusableLogs if a term needs a position that was not measured.
    """
    record = motion.record
    window = motion.window
    terms = declared_terms(bench)
    effects = declared_effects(bench)
    absolute = [
        *(DECLARED[term] for term in terms if term != DIRECTION),
        *(effect.term for effect in effects if effect.needs_position),
    ]
    out = dict[str, Vector]()
    if record.velocity is not None and absolute:
        raise UnusableLogs(
            f"{record.name} has a velocity and no position; load.terms needs a position for "
            f"{', '.join(absolute)}"
        )
    for term in terms:
        if term == DIRECTION:
            whole: tuple[Vector, ...] = (np.where(motion.sign < 0.0, motion.velocity, 0.0),)
        elif term in HARMONICS:
            angle = wave_number(term, bench) * record.position
            whole = (
                _smoothed(np.sin(angle), window, record.period),
                _smoothed(np.cos(angle), window, record.period),
            )
        else:
            whole = (_smoothed(record.position, window, record.period),)
        out.update(zip(TERMS[term], map(motion.at_rows, whole), strict=True))
    for effect in effects:
        out.update(zip(effect.names, effect.columns(motion), strict=False))
    return out


def _smoothed(values: Vector, window: int, period: float) -> Vector:
    if values.size < window:
        return np.full(values.size, np.nan)
    return np.convolve(values, smoothing_kernel(window, period), mode="same")


def indistinct_terms(plain: Tensor, names: Sequence[str], rows: int) -> dict[str, str]:
    """Return the parameters of harmonics that need a longer travel, with the reasons.

    - plain: triangular matrices of g groups of rows, (g, q, q), with the columns `names` and the
      target
    - rows: number of rows in all groups
    """
    whole = merged(plain)[:, :-1]
    out = {}
    for term in HARMONICS:
        columns = [k for k, name in enumerate(names) if name in TERMS[term]]
        if not columns:
            continue
        others = np.delete(whole, columns, axis=1)
        left = (
            whole[:, columns] - others @ np.linalg.lstsq(others, whole[:, columns], rcond=None)[0]
        )
        share = float(np.linalg.svd(left, compute_uv=False)[-1]) / np.sqrt(0.5 * rows)
        if share < LEAST_SHARE:
            reason = (
                f"over this travel, only {100 * share:.2g} % of {term} is independent of the other "
                "terms"
            )
            out.update(
                dict.fromkeys(
                    TERMS[term],
                    f"{reason} (at least {100 * LEAST_SHARE:g} % is needed); move further",
                )
            )
    return out


def by_direction(
    names: tuple[str, ...], coulomb: bool, plain: Tensor, weighted: Tensor
) -> tuple[tuple[str, ...], Tensor, Tensor]:
    """Replace columns so that friction has one parameter for each direction of motion.

    Viscous friction is split if `names` contains "viscous_backward". If `coulomb` is True, Coulomb
    friction and offset are replaced by one Coulomb friction for each direction. `names` (q - 1,)
    are the parameters. `plain` and `weighted` (g, q, q) are triangular matrices of g groups of
    rows; their last column is the effort.
    """
    change = np.eye(len(names) + 1)
    out = list(names)
    if "viscous_backward" in names:
        change[names.index("viscous_backward"), names.index("viscous")] = -1.0
    if coulomb and "offset" in names:
        sign, one = names.index("coulomb"), names.index("offset")
        change[np.ix_((sign, one), (sign, one))] = [[0.5, 0.5], [0.5, -0.5]]
        out[one] = "coulomb_backward"
    return tuple(out), plain @ change, weighted @ change
