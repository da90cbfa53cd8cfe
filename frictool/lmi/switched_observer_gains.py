"""Gains of a switched observer that bound the effect of the model error on the estimate.

Theorem 6.2.1 of the thesis gives the bound. The estimation error e at sample k, in mode i, follows

    e(k+1) = (A_i - L_i C_i) e(k) + Q_i Delta(k),    z(k) = C-bar_i e(k)        (6.5)

A_i, C_i and Q_i are matrices of the model (`ObserverMode`), L_i the gains, Delta the model error,
and z the weighted error.

Let P_i > 0, V_i = L_i' P_i, and lambda be the requested decay (in the printed (6.6), lambda = 1).
For every allowed switch from mode i at k to mode j at k+1, the inequality is

    [-lambda^2 P_i + C-bar_i' C-bar_i   0            A_i' P_i - C_i' V_i]
    [ *                                 -gamma^2 I   Q_i' P_i           ]  <  0    (6.6)
    [ *                                 *            P_j - 2 P_i        ]

For any allowed switches, e' P e is then multiplied by at most lambda^2 per sample if Delta = 0, and
|z| <= gamma |Delta|. The gains are L_i = P_i^-1 V_i'. The thesis has V' P^-1 and V > 0, but V is
neither symmetric nor square.

The solver's result is checked. (6.6) implies (6.9). With the computed gains and P_i, the smallest
gamma of (6.9) is the largest eigenvalue of a matrix; gains for which no gamma satisfies (6.9) are
rejected. In the first pass, the states are scaled so that their coupling is of order one; in each
later pass, they are scaled so that the mean of the previous P_i is the unit matrix.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy
from numpy.typing import NDArray

from frictool.errors import NoSolutionError
from frictool.lmi.sdp import AffineConstraint, assemble, solve, symmetric, upper_triangle
from frictool.typing import Matrix

Switches = Sequence[tuple[int, int]]
PASSES = 2  # balancing passes
# gamma of the chosen gains relative to the smallest gamma; the gains thus stay off the limit
GAMMA_RATIO, MOST_GAMMA_RATIO = 1.005, 1.008
ORIGINAL_UNITS_WEIGHT = 1e-3  # weight of the original units in the choice of units
# relative smallest singular value of [A - z; C] below which the mode at z is not observable
UNSEEN = 1e-9


@dataclass(frozen=True)
class ObserverMode:
    """Matrices of one mode i in thesis (6.5).

    The estimation error follows e+ = (A_i - L_i C_i) e + Q_i Delta; its weighted value is C-bar_i
    e.

    - a: matrix A_i (n, n)
    - c: matrix C_i (m, n)
    - q: matrix Q_i (n, w)
    - weight: matrix C-bar_i (p, n)
    """

    a: Matrix
    c: Matrix
    q: Matrix
    weight: Matrix

    def in_states(self, t: Matrix) -> ObserverMode:
        """Return the mode in new states x, where the present states are t x."""
        back = np.asarray(np.linalg.inv(t))
        return ObserverMode(back @ self.a @ t, self.c @ t, back @ self.q, self.weight @ t)


@dataclass(frozen=True)
class SwitchedGains:
    """Gains L_i (n, m) of each mode, and the bound `gamma` of the effect of the model error.

    gamma is proved by thesis (6.9) with the matrices P_i.

    - decay: upper bound lambda of the factor by which the error changes per sample
    - smallest_gamma: smallest gamma for lambda = 1 (in `QuietGains`: for the requested lambda)
    - t: scaling of the states
    - p: matrices P_i for the scaled states t^-1 x; in SI units, rounding errors would hide the
      decrease of e' P_i e
    """

    gains: dict[int, Matrix]
    gamma: float
    decay: float
    smallest_gamma: float
    p: dict[int, Matrix]
    t: Matrix

    def value(self, mode: int, error: Matrix) -> NDArray[np.float64]:
        """Return the Lyapunov function e' P_i e for errors e (..., n) in mode i."""
        x = np.linalg.solve(self.t, error[..., None])[..., 0]
        return np.asarray(np.einsum("...i,ij,...j->...", x, self.p[mode], x))


def switched_gains(
    modes: Mapping[int, ObserverMode], switches: Switches, decay: float = 1.0
) -> SwitchedGains:
    """Return the observer gains for `modes` and the allowed `switches` (i, j).

    The bound gamma of |weighted error|/|model error| is at most MOST_GAMMA_RATIO times the smallest
    gamma that was found. Mode i can last for several samples if the switch (i, i) is allowed.
    `decay` is the upper bound lambda of the factor by which the error changes per sample.

    Raises NoSolutionError if (A_i, C_i) of a mode is not detectable, or if the inequalities have no
    solution that passes the check. Raises ValueError for a decay outside (0, 1].
    """
    if not 0.0 < decay <= 1.0:
        raise ValueError(f"decay is {decay:g} per sample; allowed: above 0 and at most 1")
    t = state_units(modes)
    for index, mode in modes.items():
        refuse_undetectable(index, mode.in_states(t))
    without = min(_candidates(modes, switches, 1.0, t), key=lambda candidates: candidates.gamma)
    candidates = _candidates(modes, switches, decay, t)
    least = min(each.gamma for each in candidates)
    if not np.isfinite(least):
        raise NoSolutionError(_unsolved(decay, without.gamma))
    best = next(each for each in candidates if each.gamma <= MOST_GAMMA_RATIO * least)
    return replace(
        best, smallest_gamma=min(without.gamma, least)
    )  # gains with a decay also solve the inequalities without a decay


def _candidates(
    modes: Mapping[int, ObserverMode], switches: Switches, decay: float, t: Matrix
) -> list[SwitchedGains]:
    """Return candidates for the gains, the best first; the last is empty, with an infinite gamma.

    Each balancing pass gives gains for GAMMA_RATIO times the smallest gamma, which are preferred,
    and gains for the smallest gamma. t: scaling of the states in the first pass.
    """
    inner, edge = [], []
    for _ in range(PASSES):
        problem = _SwitchedProblem(modes, switches, decay, t)
        smallest, gains = problem.smallest()
        if not gains.p:
            break
        inner.append(problem.inside(GAMMA_RATIO * smallest))
        edge.append(gains)
        t = t @ np.linalg.inv(scipy.linalg.cholesky(np.mean(list(gains.p.values()), axis=0)))
    return [*reversed(inner), *reversed(edge), _nothing(decay, t)]


def proved_gamma(
    modes: Mapping[int, ObserverMode],
    switches: Switches,
    gains: Mapping[int, Matrix],
    p: Mapping[int, Matrix],
    t: Matrix,
    decay: float,
) -> float:
    """Return the smallest bound gamma that thesis (6.9) proves; inf if there is none.

    gamma bounds |weighted error|/|model error|.

    - decay: upper bound of the factor by which the error changes per sample
    - p: P_i of each mode, for states x_p with x = t x_p
    """
    if any(
        not np.all(np.isfinite(each)) or np.linalg.eigvalsh(each)[0] <= 0.0 for each in p.values()
    ):
        return np.inf
    worst = 0.0
    loops = {
        i: replace(mode, a=mode.a - gains[i] @ mode.c).in_states(t) for i, mode in modes.items()
    }
    for i, j in switches:
        loop = loops[i]
        moved = p[j] @ loop.a
        left = decay**2 * p[i] - loop.weight.T @ loop.weight - loop.a.T @ moved
        if np.linalg.eigvalsh(left)[0] <= 0.0:
            return np.inf
        side = moved.T @ loop.q
        entered = loop.q.T @ p[j] @ loop.q + side.T @ np.linalg.solve(left, side)
        worst = max(worst, float(np.linalg.eigvalsh(entered)[-1]))
    return float(np.sqrt(worst))


def refuse_undetectable(index: int, mode: ObserverMode) -> None:
    """Raise NoSolutionError if a pole z of the mode, |z| >= 1, is not observable (Hautus test)."""
    identity = np.eye(len(mode.a))
    for pole in np.linalg.eigvals(mode.a).astype(np.complex128):
        if abs(pole) < 1.0 - UNSEEN:
            continue
        values = np.linalg.svd(
            np.vstack([mode.a - pole * identity, mode.c / _rows(mode.c)]), compute_uv=False
        )
        if values[-1] <= UNSEEN * values[0]:
            raise NoSolutionError(
                f"mode {index}: the state with the pole {pole if pole.imag else pole.real:.4g} is "
                "not observable and does not decay, so that no observer exists; one cause is "
                "friction of 0, on which wear has no effect"
            )


class _SwitchedProblem:
    """Inequalities of thesis (6.6) in one set of state coordinates.

    The unknowns are P_i and V_i of each mode, and gamma^2. If gamma is fixed, the last unknown is
    the margin of the inequalities instead.
    """

    def __init__(
        self, modes: Mapping[int, ObserverMode], switches: Switches, decay: float, t: Matrix
    ) -> None:
        self.modes = modes
        self.switches = switches
        self.decay = decay
        self.t = t
        posed = {index: mode.in_states(t) for index, mode in modes.items()}
        self.n = len(t)
        self.half = self.n * (self.n + 1) // 2
        weight, entering = (
            _largest(np.vstack([getattr(mode, part) for mode in posed.values()]))
            for part in ("weight", "q")
        )
        # self.unit is the unit of gamma
        self.weight = weight
        self.unit = weight * entering
        self.posed = {
            i: ObserverMode(m.a, m.c / _rows(m.c), m.q / entering, m.weight / weight)
            for i, m in posed.items()
        }
        self.first = {}
        count = 0
        for index, mode in self.posed.items():
            self.first[index] = count
            count += self.half + self.n * len(mode.c)
        self.count = count + 1

    def smallest(self) -> tuple[float, SwitchedGains]:
        x = solve(np.eye(self.count)[-1], [self.inequality(i, j) for i, j in self.switches]).x
        return self.unit * float(np.sqrt(max(x[-1], 0.0))), self.gains(x)

    def inside(self, gamma: float) -> SwitchedGains:
        constraints = []
        for i, j in self.switches:
            free = self.inequality(i, j)
            level = symmetric(free.columns[:, -1], len(free.fixed))
            rows, across = upper_triangle(len(free.fixed))
            free.columns[:, -1] = -1.0 * (rows == across)
            constraints.append(
                AffineConstraint(free.fixed + (gamma / self.unit) ** 2 * level, free.columns)
            )
        return self.gains(solve(-np.eye(self.count)[-1], constraints).x)

    def inequality(self, i: int, j: int) -> AffineConstraint:
        mode = self.posed[i]
        same = i == j
        unknowns = self.half + self.n * len(self.posed[i].c)
        size = unknowns + (0 if same else self.half) + 1

        def values(x: Matrix) -> Matrix:
            p_i = symmetric(x[:, : self.half], self.n)
            v = x[:, self.half : unknowns].reshape(-1, len(mode.c), self.n)
            return _inequality(
                mode,
                self.decay,
                p_i,
                p_i if same else symmetric(x[:, unknowns:-1], self.n),
                v,
                x[:, -1],
            )

        return place_among_unknowns(
            assemble(values, size),
            self.count,
            (self.first[i], unknowns),
            None if same else (self.first[j], self.half),
        )

    def gains(self, x: Matrix) -> SwitchedGains:
        """Return the gains L_i = P_i^-1 V_i' for the unknowns `x`, and the gamma that they prove.

        gamma is infinite if a P_i is not positive definite.
        """
        gains, p = {}, {}
        for index, mode in self.posed.items():
            unknowns = x[self.first[index] :]
            p[index] = self.weight**2 * symmetric(
                unknowns[: self.half], self.n
            )  # in units of the original weights
            v = unknowns[self.half : self.half + self.n * len(mode.c)].reshape(len(mode.c), self.n)
            if not np.all(np.isfinite(unknowns)) or np.linalg.eigvalsh(p[index])[0] <= 0.0:
                return _nothing(self.decay, self.t)
            gains[index] = (
                self.weight**2
                * self.t
                @ np.linalg.solve(p[index], v.T)
                / _rows(self.modes[index].c @ self.t).T
            )
        proved = proved_gamma(self.modes, self.switches, gains, p, self.t, self.decay)
        return SwitchedGains(gains, proved, self.decay, np.inf, p, self.t)


def place_among_unknowns(
    local: AffineConstraint, count: int, before: tuple[int, int], after: tuple[int, int] | None
) -> AffineConstraint:
    """Return the inequality of one switch as a constraint on all `count` unknowns.

    `local` is the same inequality in three groups of unknowns: the unknowns of the mode before the
    switch, the unknowns of the mode after the switch, and gamma^2. `before` and `after` are (first
    index, number) of the unknowns of these modes; gamma^2 is the last unknown.
    """
    columns = np.zeros((len(local.columns), count))
    columns[:, before[0] : before[0] + before[1]] = local.columns[:, : before[1]]
    if after is not None:
        columns[:, after[0] : after[0] + after[1]] = local.columns[:, before[1] : -1]
    columns[:, -1] = local.columns[:, -1]
    return AffineConstraint(local.fixed, columns)


def _inequality(
    mode: ObserverMode, decay: float, p_i: Matrix, p_j: Matrix, v: Matrix, level: Matrix
) -> Matrix:
    """Return minus the matrix of thesis (6.6).

    The arguments are P_i and P_j (k, n, n), V_i (k, m, n) and gamma^2 (k,).
    """
    n, w = mode.q.shape
    whole = np.zeros((len(p_i), 2 * n + w, 2 * n + w))
    whole[:, :n, :n] = decay**2 * p_i - mode.weight.T @ mode.weight
    whole[:, n : n + w, n : n + w] = level[:, None, None] * np.eye(w)
    side = np.concatenate([mode.a.T @ p_i - mode.c.T @ v, mode.q.T @ p_i], axis=1)
    whole[:, : n + w, n + w :] = -side
    whole[:, n + w :, : n + w] = -np.swapaxes(side, 1, 2)
    whole[:, n + w :, n + w :] = 2.0 * p_i - p_j
    return whole


def _nothing(decay: float, t: Matrix) -> SwitchedGains:
    return SwitchedGains({}, np.inf, decay, np.inf, {}, t)


def state_units(modes: Mapping[int, ObserverMode]) -> Matrix:
    """Return a diagonal scaling of the states for which the couplings in A are of order one."""
    coupling = np.max(
        [np.abs(mode.a - np.diag(np.diag(mode.a))) for mode in modes.values()], axis=0
    )
    n = len(coupling)
    rows = []
    right = []
    for i, j in zip(*np.nonzero(coupling), strict=True):
        rows.append(np.eye(n)[j] - np.eye(n)[i])
        right.append(-np.log(coupling[i, j]))
    stacked = np.vstack(
        [*rows, ORIGINAL_UNITS_WEIGHT * np.eye(n)]
    )  # an uncoupled state keeps its unit
    return np.diag(
        np.exp(np.linalg.lstsq(stacked, np.concatenate([right, np.zeros(n)]), rcond=None)[0])
    )


def _unsolved(decay: float, without: float) -> str:
    if not np.isfinite(without):
        return (
            "no gains satisfy the inequalities for these modes and switches: allow fewer switches, "
            "choose fewer and wider intervals, or weights of similar size"
        )
    return (
        f"no gains satisfy the inequalities with a decay of {decay:.6g} per sample, but some do "
        f"without a decay (gamma {without:.4g}): choose a --decay nearer to 1"
    )


def _rows(matrix: Matrix) -> Matrix:
    return np.array([[_largest(row)] for row in matrix])


def _largest(matrix: Matrix) -> float:
    return float(np.max(np.abs(matrix), initial=0.0)) or 1.0
