"""Switched-observer gains with least noise amplification for a bounded effect of the model error.

switched_observer_gains.py states the inequality (6.6) of the thesis and its symbols. Many gains are
nearly optimal for (6.6). Since (6.6) contains no noise, the optimal gains correct the error within
one or two samples and therefore amplify the noise of a coarse encoder. Here the gains minimise nu
subject to

    |z| <= factor gamma* |Delta|    z: weighted estimation error, Delta: model error;
                                    gamma*: the smallest gamma with the requested decay
    |z| <= nu |w|                   w: noise in y = C_i x + n_i w; it enters the error as -L_i n_i w

Both bounds are proved with the same P_i. For every allowed switch (i, j), a slack matrix G_i
replaces the factor P_i of (6.6), with V_i = G_i' L_i. The first bound becomes

    [lambda^2 P_i - C-bar_i' C-bar_i   0           A_i' G_i - C_i' V_i']
    [ *                                gamma^2 I   Q_i' G_i            ]  >  0
    [ *                                *           G_i + G_i' - P_j    ]

(J. Daafouz, P. Riedinger, C. Iung, IEEE TAC 47, 2002). The second bound, the noise inequality, has
-n_i' V_i' in place of Q_i' G_i, nu in place of gamma, and lambda = 1. With G_i = P_i the first
inequality is (6.6), in which lemma 6.2.1 requires P_j < 2 P_i for every switch. If the wear alpha
acts in opposite directions in two successive modes, this requirement excludes a fast estimate of
alpha.

gamma* is a result of the solver. With the computed gains and P_i, (6.9) checks both bounds, nu and
`factor` gamma*.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np
import scipy
from numpy.typing import NDArray

from frictool.errors import NoSolutionError
from frictool.lmi.sdp import AffineConstraint, assemble, solve, symmetric
from frictool.lmi.switched_observer_gains import (
    ObserverMode,
    SwitchedGains,
    Switches,
    place_among_unknowns,
    proved_gamma,
    refuse_undetectable,
    state_units,
)
from frictool.typing import Matrix, Vector

PASSES = 3  # balancing passes
INSIDE, FASTER = (
    0.995,
    1e-6,
)  # reserve in gamma (factor) and in the decay (share): keeps the gains off the limit


@dataclass(frozen=True)
class QuietGains:
    """Switched-observer gains with matrices P_i that prove bounds of the weighted error.

    - gains: the gains L_i, the matrices P_i, and the bound gamma of |z|/|Delta|, with the weighted
      error z and the model error Delta
    - noise_gain: the smallest bound nu of |z|/|w| that P_i prove, with the noise w
    """

    gains: SwitchedGains
    noise_gain: float


def quiet_gains(
    modes: Mapping[int, ObserverMode],
    switches: Switches,
    noise: Mapping[int, Vector],
    decay: float,
    factor: float,
    apart: Mapping[int, NDArray[np.bool_]] = MappingProxyType({}),
) -> QuietGains:
    """Return the switched-observer gains with the least noise amplification.

    - modes: matrices of each mode
    - switches: allowed switches (i, j)
    - noise: amplitude n_i (m,) of the measurement noise in each mode
    - decay: upper bound of the factor by which the estimation error changes per sample
    - factor: allowed bound gamma of |weighted error|/|model error|, divided by the smallest gamma
    - apart: for each mode, mask (n, m) of the gains that are allowed to differ from 0; states with
      equal rows of the mask must be consecutive

    Raises NoSolutionError if a mode is not detectable, or if no gains are proved for `factor` times
    the smallest gamma. Raises ValueError for a decay outside (0, 1] or a factor of at most 1.
    """
    if not 0.0 < decay <= 1.0 or not factor > 1.0:
        raise ValueError(
            f"found a decay of {decay:g} and a factor of {factor:g}; allowed: a decay above 0 and "
            "at most 1, a factor above 1"
        )
    t = state_units(modes)
    for index, mode in modes.items():
        refuse_undetectable(index, mode.in_states(t))
    best: QuietGains | None = None
    for _ in range(PASSES):
        problem = _QuietProblem(modes, switches, noise, decay, t, apart)
        smallest = problem.smallest()
        gains = problem.quietest(INSIDE * factor * smallest) if smallest > 0.0 else None
        if gains is None:
            break
        passed = {
            i: replace(mode, q=-gains.gains[i] @ noise[i][:, None]) for i, mode in modes.items()
        }
        nu = proved_gamma(passed, switches, gains.gains, gains.p, t, 1.0)
        if gains.gamma <= factor * smallest and (best is None or nu < best.noise_gain):
            best = QuietGains(replace(gains, smallest_gamma=smallest), nu)
        t = t @ np.linalg.inv(scipy.linalg.cholesky(np.mean(list(gains.p.values()), axis=0)))
    if best is None:
        raise NoSolutionError(
            f"no gains were proved with a decay of {decay:g} per sample and at most {factor:g} "
            "times the smallest gamma; choose a decay nearer to 1, or a larger factor"
        )
    return best


class _QuietProblem:
    """Inequalities of the module docstring in one set of state coordinates.

    The unknowns are P_i, G_i, V_i of each mode, then gamma^2 or nu^2, which is minimised.
    """

    def __init__(
        self,
        modes: Mapping[int, ObserverMode],
        switches: Switches,
        noise: Mapping[int, Vector],
        decay: float,
        t: Matrix,
        apart: Mapping[int, NDArray[np.bool_]],
    ) -> None:
        self.modes = modes
        self.switches = switches
        self.decay = decay
        self.t = t
        posed = {index: mode.in_states(t) for index, mode in modes.items()}
        self.n = len(t)
        self.half = self.n * (self.n + 1) // 2
        self.weight = max(float(np.max(np.abs(mode.weight))) for mode in posed.values())
        self.entering = (
            max(float(np.max(np.abs(mode.q), initial=0.0)) for mode in posed.values()) or 1.0
        )
        self.rows = {i: np.max(np.abs(m.c), axis=1, keepdims=True) for i, m in posed.items()}
        self.posed = {
            i: ObserverMode(m.a, m.c / self.rows[i], m.q / self.entering, m.weight / self.weight)
            for i, m in posed.items()
        }
        enters = {i: each[:, None] / self.rows[i] for i, each in noise.items()}
        largest = max(float(np.max(np.abs(each))) for each in enters.values()) or 1.0
        self.noise = {i: each / largest for i, each in enters.items()}
        masks = {
            i: apart.get(i, np.ones((self.n, len(m.c)), dtype=np.bool_)) for i, m in posed.items()
        }
        self.masks = {
            i: (np.all(mask[:, None] == mask[None], axis=2), mask) for i, mask in masks.items()
        }  # masks of G_i and V_i
        self.first = {}
        self.sizes = {}
        count = 0
        for index, mode in self.posed.items():
            self.first[index], self.sizes[index] = (
                count,
                self.half + self.n * self.n + self.n * len(mode.c),
            )
            count += self.sizes[index]
        self.count = count + 1

    def smallest(self) -> float:
        square = float(
            solve(
                np.eye(self.count)[-1],
                [self.inequality(i, j, None, False) for i, j in self.switches],
            ).x[-1]
        )
        return self.weight * self.entering * math.sqrt(square) if square > 0.0 else 0.0

    def quietest(self, gamma: float) -> SwitchedGains | None:
        level = (gamma / (self.weight * self.entering)) ** 2
        constraints = [self.inequality(i, j, level, False) for i, j in self.switches]
        constraints += [self.inequality(i, j, None, True) for i, j in self.switches]
        return self.proved_gains(solve(np.eye(self.count)[-1], constraints).x)

    def inequality(self, i: int, j: int, level: float | None, of_noise: bool) -> AffineConstraint:
        """Return the constraint of the switch from mode i to mode j (module docstring).

        - level: gamma^2; if None, the last unknown is used instead
        - of_noise: True for the noise inequality
        """
        mode = self.posed[i]
        same = i == j
        unknowns = self.sizes[i]
        size = unknowns + (0 if same else self.half) + 1

        def values(x: Matrix) -> Matrix:
            p_i = symmetric(x[:, : self.half], self.n)
            p_j = p_i if same else symmetric(x[:, unknowns:-1], self.n)
            g, v = self.multipliers(i, x[:, self.half : unknowns])
            square = x[:, -1] if level is None else np.full(len(x), level)
            turned = np.swapaxes(g, 1, 2)
            enters = -v @ self.noise[i] if of_noise else turned @ mode.q
            decay = 1.0 if of_noise else (1.0 - FASTER) * self.decay
            return _matrix(
                decay**2 * p_i - mode.weight.T @ mode.weight,
                np.concatenate([turned @ mode.a - v @ mode.c, enters], axis=2),
                g + turned - p_j,
                square,
            )

        return place_among_unknowns(
            assemble(values, size),
            self.count,
            (self.first[i], unknowns),
            None if same else (self.first[j], self.half),
        )

    def multipliers(self, index: int, x: Matrix) -> tuple[Matrix, Matrix]:
        of_g, of_v = self.masks[index]
        return of_g * x[:, : self.n**2].reshape(-1, *of_g.shape), of_v * x[:, self.n**2 :].reshape(
            -1, *of_v.shape
        )

    def proved_gains(self, x: Vector) -> SwitchedGains | None:
        """Return the gains L_i = G_i'^-1 V_i for the unknowns `x`, and the gamma that they prove.

        The result is None if P_i or G_i + G_i' is not positive.
        """
        gains, p = {}, {}
        for index in self.posed:
            unknowns = x[self.first[index] : self.first[index] + self.sizes[index]]
            if not np.all(np.isfinite(unknowns)):
                return None
            p[index] = self.weight**2 * symmetric(unknowns[: self.half], self.n)
            (g,), (v,) = self.multipliers(index, unknowns[None, self.half :])
            if np.linalg.eigvalsh(g + g.T)[0] <= 0.0 or np.linalg.eigvalsh(p[index])[0] <= 0.0:
                return None
            gains[index] = self.t @ np.linalg.solve(g.T, v) / self.rows[index].T
        gamma = proved_gamma(self.modes, self.switches, gains, p, self.t, self.decay)
        return SwitchedGains(gains, gamma, self.decay, np.inf, p, self.t)


def _matrix(first: Matrix, below: Matrix, last: Matrix, square: Vector) -> Matrix:
    n, whole = first.shape[1], below.shape[2]
    out = np.zeros((len(first), whole + n, whole + n))
    out[:, :n, :n] = first
    out[:, n:whole, n:whole] = square[:, None, None] * np.eye(whole - n)
    out[:, whole:, :whole] = below
    out[:, :whole, whole:] = np.swapaxes(below, 1, 2)
    out[:, whole:, whole:] = last
    return out
