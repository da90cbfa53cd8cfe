"""H-infinity synthesis of one plant by two Riccati equations, in place of matrix inequalities.

With B = [B1 B2], D1 = [D11 D12] and V = D1' D1 - diag(gamma^2 I, 0), X is the stabilising solution
of (Glover and Doyle, 1988)

    A' X + X A + C1' C1 - (C1' D1 + X B) V^-1 (D1' C1 + B' X) = 0

and Y the stabilising solution of the dual equation. Let D12 have full column rank and D21 full row
rank, and let the systems (A, B2, C1, D12) and (A, B1, C2, D21) have no zeros on the imaginary axis.
A controller with a norm below gamma then exists if and only if X and Y exist, X >= 0, Y >= 0 and
the spectral radius of X Y is below gamma^2. A sampled plant is first transformed by
s = (z - 1)/(z + 1), which changes neither X and Y nor the norm.

R = gamma X^-1 and S = gamma Y^-1 solve the inequalities of bounded_real.py with equality. If every
state gets an additional output and an additional disturbance of gain `strict`, R and S solve the
inequalities strictly.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import scipy

from frictool.plant.generalised_plant import GeneralisedPlant
from frictool.typing import Matrix

FULL_RANK = 1e-6  # smallest singular value of D12 and D21, relative to the largest entry of D
PRECISION = 1e-5  # relative precision of the smallest gamma
SYMMETRIC, SEMIDEFINITE = 1e-5, 1e-7  # errors of X, relative to its largest entry
FIRST, FACTOR, LARGEST = 1.0, 4.0, 1e6  # first gamma tried, factor to the next gamma, largest gamma


def smallest_gamma(plant: GeneralisedPlant) -> float | None:
    """Return an upper bound of the smallest gamma, with a relative error of at most PRECISION.

    The result is None if the plant does not meet the conditions of the Riccati equations, or if the
    smallest gamma is not between 1/LARGEST and LARGEST.
    """
    continuous = _continuous(plant)
    if not _regular(continuous):
        return None
    high = FIRST
    while not (excess := _excess(continuous, high)) < 0.0:
        high *= FACTOR
        if high > LARGEST:
            return None
    low = high / FACTOR
    while (above := _excess(continuous, low)) < 0.0:
        high, excess = low, above
        low /= FACTOR
        if low < 1.0 / LARGEST:
            return None
    side = 0
    while high - low > PRECISION * high:
        # regula falsi (Illinois) as long as the spectral radius of X Y decides, else halving
        share = above / (above - excess) if math.isfinite(above) else 0.5
        middle = low + min(max(share, 1e-3), 1.0 - 1e-3) * (high - low)
        value = _excess(continuous, middle)
        if value < 0.0:
            high, excess = middle, value
            above *= 0.5 if side > 0 else 1.0
            side = 1
        else:
            low, above = middle, value
            excess *= 0.5 if side < 0 else 1.0
            side = -1
    return high


def lyapunov_blocks(
    plant: GeneralisedPlant, gamma: float, strict: float
) -> tuple[Matrix, Matrix] | None:
    """Return R and S that solve the inequalities of bounded_real.py at `gamma`.

    The result is None if no such R and S exist. `strict` > 0 is the gain of the output and the
    disturbance that are added to every state.
    """
    continuous = _continuous(plant)
    n = len(plant.a)
    states = strict * np.eye(n)
    widened = replace(
        continuous,
        b1=np.hstack([continuous.b1, states]),
        c1=np.vstack([continuous.c1, states]),
        d11=np.pad(continuous.d11, ((0, n), (0, n))),
        d12=np.pad(continuous.d12, ((0, n), (0, 0))),
        d21=np.pad(continuous.d21, ((0, 0), (0, n))),
    )
    pair = _solutions(widened, gamma)
    if pair is None or not _radius(*pair) < gamma**2:
        return None
    x, y = pair
    if min(np.linalg.eigvalsh(x)[0], np.linalg.eigvalsh(y)[0]) <= 0.0:
        return None
    r, s = (gamma * np.linalg.inv(block) for block in (x, y))
    return 0.5 * (r + r.T), 0.5 * (s + s.T)


def _continuous(plant: GeneralisedPlant) -> GeneralisedPlant:
    if not plant.period:
        return plant
    identity = np.eye(len(plant.a))
    inverse = np.linalg.inv(plant.a + identity)
    root = math.sqrt(2.0)
    return GeneralisedPlant(
        (plant.a - identity) @ inverse,
        root * inverse @ plant.b1,
        root * inverse @ plant.b2,
        root * plant.c1 @ inverse,
        root * plant.c2 @ inverse,
        plant.d11 - plant.c1 @ inverse @ plant.b1,
        plant.d12 - plant.c1 @ inverse @ plant.b2,
        plant.d21 - plant.c2 @ inverse @ plant.b1,
        0.0,
    )


def _regular(plant: GeneralisedPlant) -> bool:
    largest = max(float(np.max(np.abs(d))) for d in (plant.d11, plant.d12, plant.d21))
    return all(
        np.linalg.matrix_rank(d, FULL_RANK * largest) == ports
        for d, ports in ((plant.d12, plant.b2.shape[1]), (plant.d21, len(plant.c2)))
    )


def _excess(plant: GeneralisedPlant, gamma: float) -> float:
    """Return (spectral radius of X Y)/gamma^2 - 1 for the solutions X, Y of the Riccati equations.

    The result is NaN if X or Y does not exist or is indefinite.
    """
    pair = _solutions(plant, gamma)
    return math.nan if pair is None else _radius(*pair) / gamma**2 - 1.0


def _radius(x: Matrix, y: Matrix) -> float:
    return float(np.max(np.abs(np.linalg.eigvals(x @ y))))


def _solutions(plant: GeneralisedPlant, gamma: float) -> tuple[Matrix, Matrix] | None:
    p = plant
    n_z, n_w = p.d11.shape
    x = _stabilising(p.a, np.hstack([p.b1, p.b2]), p.c1, np.hstack([p.d11, p.d12]), gamma, n_w)
    if x is None:
        return None
    b, d = np.hstack([p.c1.T, p.c2.T]), np.hstack([p.d11.T, p.d21.T])
    y = _stabilising(p.a.T, b, p.b1.T, d, gamma, n_z)
    return None if y is None else (x, y)


def _stabilising(
    a: Matrix, b: Matrix, c: Matrix, d: Matrix, gamma: float, n_w: int
) -> Matrix | None:
    n = len(a)
    v = d.T @ d
    v[:n_w, :n_w] -= gamma**2 * np.eye(n_w)
    if np.count_nonzero(np.linalg.eigvalsh(v) > 0.0) != b.shape[1] - n_w:
        return None  # gamma is below the norm of the part of D11 that no controller changes
    direct = np.linalg.solve(v, np.hstack([d.T @ c, b.T]))
    hamiltonian = np.block([[a, np.zeros((n, n))], [-c.T @ c, -a.T]])
    hamiltonian -= np.vstack([b, -c.T @ d]) @ direct
    try:
        _, u, stable = scipy.linalg.schur(hamiltonian, sort="lhp")
        x = np.linalg.solve(u[:n, :n].T, u[n:, :n].T).T
    except scipy.linalg.LinAlgError:
        return None
    size = float(np.max(np.abs(x)))
    x = 0.5 * (x + x.T) if np.max(np.abs(x - x.T)) <= SYMMETRIC * size else np.full_like(x, np.nan)
    if stable != n or not np.all(np.isfinite(x)):
        return None
    return x if np.linalg.eigvalsh(x)[0] >= -SEMIDEFINITE * size else None
