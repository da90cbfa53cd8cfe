"""Upper bound of the worst norm (thesis 5.53) of loops whose parameters vary arbitrarily fast.

    x' = A x + B w,  z = C x + D w    (A, B, C, D) in the convex hull of the loops

A Lyapunov matrix P that solves the bounded-real inequalities of all loops proves the bound for
their hull (Boyd et al., 1994). In discrete time a Schur complement keeps A' P A linear:

    [-P  A'P  0  C'; P A  -P  P B  0; 0  B'P  -gamma  D'; C  0  D  -gamma] < 0.

The matrices of a sampled plant are not multi-affine in the parameters of the continuous plant. For
sampled loops the bound is therefore valid for plants whose sampled matrices are interpolated
between the matrices of the sampled loops. The bound is not proved for the true plants between these
loops, although these are close to the interpolated plants. The result does not rely on the solver's
gamma: for the computed P, the smallest gamma of each inequality is the largest eigenvalue of a
matrix (Schur complement).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np
import scipy

from frictool.lmi.sdp import Affine, solve, symmetric
from frictool.lmi.state_balancing import osborne
from frictool.plant.lti import Lti
from frictool.typing import Matrix

PASSES = 3  # balancing passes; the coordinates of each pass make the last P the unit matrix


def common_bound(loops: Sequence[Lti]) -> float:
    """Return a bound of |z|/|w| (L2 norms) for loops that vary in time within the hull of `loops`.

    The loops have the same states, inputs w, outputs z and sample period (0 for continuous time).
    The bound is infinite if a loop is unstable or no Lyapunov matrix was found. The Lyapunov matrix
    is computed in balanced states and, in continuous time, in a unit of time in which the fastest
    poles have a modulus of about 1.
    """
    best = np.inf
    if any(not loop.stable for loop in loops):
        return best
    unit = (
        1.0
        if loops[0].period
        else 1.0 / float(np.median([np.max(np.abs(np.linalg.eigvals(loop.a))) for loop in loops]))
    )
    scaled = [_in_time_unit(loop, unit) for loop in loops]
    wholes = [np.block([[loop.a, loop.b], [loop.c, loop.d]]) for loop in scaled]
    t = osborne(wholes, scaled[0].order)
    for _ in range(PASSES):
        gamma, p = _solved([loop.transformed(t) for loop in scaled])
        if not np.isfinite(gamma):
            break
        best = min(best, gamma)
        t = t @ np.linalg.inv(scipy.linalg.cholesky(p))
    return best


def _in_time_unit(loop: Lti, unit: float) -> Lti:
    if loop.period:
        return loop
    return replace(loop, a=unit * loop.a, b=np.sqrt(unit) * loop.b, c=np.sqrt(unit) * loop.c)


def _solved(loops: Sequence[Lti]) -> tuple[float, Matrix]:
    n = loops[0].order
    unknowns = n * (n + 1) // 2 + 1  # P, then gamma

    def lyapunov(x: Matrix) -> Matrix:
        return symmetric(x[:, :-1], n)

    def positive(x: Matrix, loop: Lti) -> Matrix:
        whole = -_inequality(loop, lyapunov(x))
        outer = np.arange(whole.shape[1] - _ports(loop), whole.shape[1])
        whole[:, outer, outer] += x[:, -1:]
        return whole

    constraints: list[Affine] = [lyapunov, *(partial(positive, loop=loop) for loop in loops)]
    x = solve(np.eye(unknowns)[-1], constraints).x
    if not np.all(np.isfinite(x)):
        return np.inf, np.eye(n)
    p = lyapunov(x[None])
    if np.linalg.eigvalsh(p[0])[0] <= 0.0:
        return np.inf, p[0]
    return max(_smallest_gamma(_inequality(loop, p)[0], loop) for loop in loops), p[0]


def _ports(loop: Lti) -> int:
    return int(loop.b.shape[1]) + len(loop.c)


def _inequality(loop: Lti, p: Matrix) -> Matrix:
    n, w = loop.b.shape
    inner = 2 * n if loop.period else n
    whole = np.zeros((len(p), inner + w + len(loop.c), inner + w + len(loop.c)))
    if loop.period:
        whole[:, :n, :n], whole[:, n:inner, n:inner] = -0.5 * p, -0.5 * p
        whole[:, n:inner, :n], whole[:, n:inner, inner : inner + w] = p @ loop.a, p @ loop.b
    else:
        whole[:, :n, :n] = p @ loop.a
        whole[:, :n, n : n + w] = p @ loop.b
    whole[:, inner + w :, :n], whole[:, inner + w :, inner : inner + w] = loop.c, loop.d
    return np.asarray(whole + whole.transpose(0, 2, 1))


def _smallest_gamma(whole: Matrix, loop: Lti) -> float:
    """Return the smallest gamma for which whole - diag(0, gamma I) is negative definite.

    gamma is infinite if the upper left block of `whole` is not negative definite.
    """
    inner = len(whole) - _ports(loop)
    decrease = -whole[:inner, :inner]
    cross = whole[inner:, :inner]
    rest = whole[inner:, inner:]
    if np.linalg.eigvalsh(decrease)[0] <= 0.0:
        return np.inf
    return float(np.linalg.eigvalsh(rest + cross @ np.linalg.solve(decrease, cross.T))[-1])
