"""Gains of a switched observer that bound the gain from the model's error to the weighted
estimation error: theorem 6.2.1.

    e(k+1) = (A_i - L_i C_i) e(k) + Q_i Delta(k),    z(k) = C-bar_i e(k)        (6.5), mode i at k
                                                     and j at k+1, (i, j) an allowed switch

With P_i > 0 and V_i = L_i' P_i, for every allowed (i, j), and the decay lambda that is asked for
(1: none, which is (6.6) as printed)

    [-lambda^2 P_i + C-bar_i' C-bar_i      0           A_i' P_i - C_i' V_i]
    [ *                                   -gamma^2 I   Q_i' P_i           ]  <  0            (6.6)
    [ *                                    *           P_j - 2 P_i        ]

so that e' P e falls by lambda^2 a sample where Delta = 0, whatever the allowed switches, and |z| <=
gamma |Delta|. The gains are L_i = P_i^-1 V_i' (the thesis prints V' P^-1, and V > 0, which has
neither a sign nor a square).

The solver's word is not taken. With the gains and the P_i found, the smallest gamma of (6.9), which
(6.6) implies, is the largest eigenvalue of a matrix in closed form, evaluated here; what cannot be
proved so is no solution. States are put into units in which what couples them is of order one, and
then into those in which the mean P of the pass before is the unit matrix.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cholesky

from frictool.errors import NoSolutionError
from frictool.lmi.sdp import AffineConstraint, assemble, solve, symmetric, upper_triangle

Matrix = NDArray[np.float64]
Switches = Sequence[tuple[int, int]]
PASSES = 2  # of balancing
ROOM, MOST_ROOM = (
    1.005,
    1.008,
)  # gamma over the smallest one, at which the gains are taken: inside the solutions, not on their edge
HELD = 1e-3  # weight of the units given, in finding units
# smallest singular value of [A - z; C], of the largest, below which the mode of A at z is not seen
UNSEEN = 1e-9


@dataclass(frozen=True)
class ObserverMode:
    """A mode: a (n, n), c (m, n) what is measured, q (n, w) how the model's error enters, weight
    (p, n), C-bar of (6.5)."""

    a: Matrix
    c: Matrix
    q: Matrix
    weight: Matrix

    def in_states(self, t: Matrix) -> ObserverMode:
        """The same in states x with old states t x."""
        back = np.asarray(np.linalg.inv(t))
        return ObserverMode(back @ self.a @ t, self.c @ t, back @ self.q, self.weight @ t)


@dataclass(frozen=True)
class SwitchedGains:
    """gains: L_i (n, m). gamma: what `p` and the gains prove by (6.9). decay: lambda.
    smallest_gamma: of (6.6) without a decay.

    p: P_i in states x = t x_p. In SI the decrease of e' P e would be lost in rounding.
    """

    gains: dict[int, Matrix]
    gamma: float
    decay: float
    smallest_gamma: float
    p: dict[int, Matrix]
    t: Matrix

    def value(self, mode: int, error: Matrix) -> NDArray[np.float64]:
        """e' P_i e of errors (..., n)."""
        x = np.linalg.solve(self.t, error[..., None])[..., 0]
        return np.asarray(np.einsum("...i,ij,...j->...", x, self.p[mode], x))


def switched_gains(
    modes: Mapping[int, ObserverMode], switches: Switches, decay: float = 1.0
) -> SwitchedGains:
    """Gains for `modes` and the allowed `switches` (i, j), of which (i, i) is one where the mode
    may last.

    Raises NoSolutionError where a mode's (A_i, C_i) is not detectable, and where the inequalities
    have no solution, or none that holds when it is evaluated. Raises ValueError for a decay outside
    (0, 1].
    """
    if not 0.0 < decay <= 1.0:
        raise ValueError(f"a decay of {decay:g} a sample; allowed: above 0 and at most 1")
    t = state_units(modes)
    for index, mode in modes.items():
        refuse_undetectable(index, mode.in_states(t))
    without = min(_candidates(modes, switches, 1.0, t), key=lambda found: found.gamma)
    found = _candidates(modes, switches, decay, t)
    least = min(each.gamma for each in found)
    if not np.isfinite(least):
        raise NoSolutionError(_unsolved(decay, without.gamma))
    best = next(each for each in found if each.gamma <= MOST_ROOM * least)
    return replace(
        best, smallest_gamma=min(without.gamma, least)
    )  # what decays solves the inequalities without a decay too


def _candidates(
    modes: Mapping[int, ObserverMode], switches: Switches, decay: float, t: Matrix
) -> list[SwitchedGains]:
    """Gains a little inside of the smallest gamma, of the best states first, then those at it; of
    infinite gamma where none is proved."""
    inner, edge = [], []
    for _ in range(PASSES):
        problem = _SwitchedProblem(modes, switches, decay, t)
        asked, found = problem.smallest()
        if not found.p:
            break
        inner.append(problem.inside(ROOM * asked))
        edge.append(found)
        t = t @ np.linalg.inv(cholesky(np.mean(list(found.p.values()), axis=0)))
    return [*reversed(inner), *reversed(edge), _nothing(decay, t)]


def proved_gamma(
    modes: Mapping[int, ObserverMode],
    switches: Switches,
    gains: Mapping[int, Matrix],
    p: Mapping[int, Matrix],
    t: Matrix,
    decay: float,
) -> float:
    """The smallest gamma for which (6.9), with `decay`, holds for the P given in states x = t x_p;
    infinite where it holds for none."""
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
    """Raises NoSolutionError where a motion of the mode that does not die out is not seen by what
    it measures (Hautus)."""
    identity = np.eye(len(mode.a))
    for pole in np.linalg.eigvals(mode.a).astype(np.complex128):
        if abs(pole) < 1.0 - UNSEEN:
            continue
        values = np.linalg.svd(
            np.vstack([mode.a - pole * identity, mode.c / _rows(mode.c)]), compute_uv=False
        )
        if values[-1] <= UNSEEN * values[0]:
            raise NoSolutionError(
                f"mode {index}: its state at the pole {pole if pole.imag else pole.real:.4g} is not seen by what is measured, and does not "
                "die out by itself: no observer exists; friction that is 0 there tells nothing of its wear"
            )


class _SwitchedProblem:
    """(6.6) in one set of states; unknowns: P_i and V_i of each mode, then gamma^2, or the margin
    at a gamma that is given."""

    def __init__(
        self, modes: Mapping[int, ObserverMode], switches: Switches, decay: float, t: Matrix
    ) -> None:
        self.modes, self.switches, self.decay, self.t = modes, switches, decay, t
        posed = {index: mode.in_states(t) for index, mode in modes.items()}
        self.n = len(t)
        self.half = self.n * (self.n + 1) // 2
        weight, entering = (
            _largest(np.vstack([getattr(mode, part) for mode in posed.values()]))
            for part in ("weight", "q")
        )
        self.weight, self.unit = weight, weight * entering  # the latter of gamma
        self.posed = {
            i: ObserverMode(m.a, m.c / _rows(m.c), m.q / entering, m.weight / weight)
            for i, m in posed.items()
        }
        self.first, count = {}, 0
        for index, mode in self.posed.items():
            self.first[index] = count
            count += self.half + self.n * len(mode.c)
        self.count = count + 1

    def smallest(self) -> tuple[float, SwitchedGains]:
        """The smallest gamma as the solver says it, and its gains."""
        x = solve(np.eye(self.count)[-1], [self.inequality(i, j) for i, j in self.switches]).x
        return self.unit * float(np.sqrt(max(x[-1], 0.0))), self.gains(x)

    def inside(self, gamma: float) -> SwitchedGains:
        """The gains that satisfy the inequalities at `gamma` by the largest margin."""
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
        """Minus the matrix of (6.6), assembled in the unknowns of its two modes and gamma^2 and
        then put where they belong."""
        mode, same, own = self.posed[i], i == j, self.half + self.n * len(self.posed[i].c)
        size = own + (0 if same else self.half) + 1

        def values(x: Matrix) -> Matrix:
            p_i = symmetric(x[:, : self.half], self.n)
            v = x[:, self.half : own].reshape(-1, len(mode.c), self.n)
            return _inequality(
                mode, self.decay, p_i, p_i if same else symmetric(x[:, own:-1], self.n), v, x[:, -1]
            )

        return place_among_unknowns(
            assemble(values, size),
            self.count,
            (self.first[i], own),
            None if same else (self.first[j], self.half),
        )

    def gains(self, x: Matrix) -> SwitchedGains:
        """L_i = P_i^-1 V_i' in the modes' own states, and the gamma that they prove; infinite where
        P is not positive."""
        gains, p = {}, {}
        for index, mode in self.posed.items():
            own = x[self.first[index] :]
            p[index] = self.weight**2 * symmetric(
                own[: self.half], self.n
            )  # of the weights as they are
            v = own[self.half : self.half + self.n * len(mode.c)].reshape(len(mode.c), self.n)
            if not np.all(np.isfinite(own)) or np.linalg.eigvalsh(p[index])[0] <= 0.0:
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
    local: AffineConstraint, count: int, own: tuple[int, int], other: tuple[int, int] | None
) -> AffineConstraint:
    """An inequality of a switch among all `count` unknowns, gamma last. own, other: first unknown
    and how many, of the mode that is left and of the one that follows, in which order `local` has
    them before gamma."""
    columns = np.zeros((len(local.columns), count))
    columns[:, own[0] : own[0] + own[1]] = local.columns[:, : own[1]]
    if other is not None:
        columns[:, other[0] : other[0] + other[1]] = local.columns[:, own[1] : -1]
    columns[:, -1] = local.columns[:, -1]
    return AffineConstraint(local.fixed, columns)


def _inequality(
    mode: ObserverMode, decay: float, p_i: Matrix, p_j: Matrix, v: Matrix, level: Matrix
) -> Matrix:
    """Minus the matrix of (6.6) for P_i, P_j (k, n, n), V_i (k, m, n) and gamma^2 (k,)."""
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
    """Units of the states in which what couples them in A is of order one, by least squares of its
    logarithms over all modes."""
    coupling = np.max(
        [np.abs(mode.a - np.diag(np.diag(mode.a))) for mode in modes.values()], axis=0
    )
    n, rows, right = len(coupling), [], []
    for i, j in zip(*np.nonzero(coupling), strict=True):
        rows.append(np.eye(n)[j] - np.eye(n)[i])
        right.append(-np.log(coupling[i, j]))
    stacked = np.vstack([*rows, HELD * np.eye(n)])  # what is not coupled stays as it is
    return np.diag(
        np.exp(np.linalg.lstsq(stacked, np.concatenate([right, np.zeros(n)]), rcond=None)[0])
    )


def _unsolved(decay: float, without: float) -> str:
    if not np.isfinite(without):
        return (
            "no gains were found that satisfy (6.6) when it is evaluated, for these modes and switches: allow fewer switches, or fewer and "
            "wider intervals, or weights that are less far apart"
        )
    return (
        f"no gains were found that satisfy (6.6) with a decay of {decay:.6g} a sample when it is evaluated; without a decay there are some "
        f"(gamma {without:.4g}): ask for a decay nearer to 1"
    )


def _rows(matrix: Matrix) -> Matrix:
    """(m, 1): the largest of each row."""
    return np.array([[_largest(row)] for row in matrix])


def _largest(matrix: Matrix) -> float:
    return float(np.max(np.abs(matrix), initial=0.0)) or 1.0
