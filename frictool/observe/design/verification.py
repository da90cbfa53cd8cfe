"""Verification of a switched observer from its stored gains, before the document is written.

The estimation error e follows e(k+1) = (A_i - L_i C_i) e(k) + Q_i Delta(k), z = C-bar e (thesis
6.5). Delta is the model error, and z the weighted error (lmi/switched_observer_gains.py). P_i is
the Lyapunov matrix of mode i, lambda the decay factor. For every sequence of allowed transitions
between modes, the inequalities guarantee two properties. If Delta = 0, each sample multiplies
e' P_i e by at most lambda^2. If the initial error is zero, |z| <= gamma |Delta|.

The verification simulates the recursion, independently of the inequalities, with every allowed
transition, every pair of modes that may alternate, and random allowed sequences. Delta is white
noise, a constant, and the worst Delta, which iterations of the recursion and the adjoint recursion
find.

A rest of the axis needs a separate bound, because the error of the wear alpha stays constant at
rest (eigenvalue 1). The verification computes the largest growth of e' P e in two cases. In the
first case, the growth is from the start of a rest of any length to the first sample after the rest.
In the second case, it is the growth at a forbidden transition between two moving modes. The report
states how long the axis must then move until e' P e has decayed by the same factor.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from frictool.errors import NoSolutionError
from frictool.lmi.switched_observer_gains import ObserverMode, SwitchedGains, proved_gamma
from frictool.typing import Matrix

Switch = tuple[int, int]
SAMPLES = 600  # samples of a simulated sequence
WORST_ROUNDS = 6  # iterations of the search for the worst disturbance
RANDOM_SEQUENCES = 64
SEED = 8
LONGEST_REST = 4096  # samples of the longest rest; errors of position and speed decay much faster
ROUNDING = 1e-6  # relative tolerance of gain and decay in the simulation


@dataclass(frozen=True)
class ObserverVerification:
    """Results of the verification, with the symbols of this module.

    - gamma: proved bound of |z|/|Delta|
    - radii: spectral radius of A_i - L_i C_i by mode
    - switching_radius: largest spectral radius of the product of the matrices A_i - L_i C_i of two
      modes that may alternate
    - simulated_gain: largest |z|/|Delta| in simulation
    - rest: largest growth factor of e' P e from the start of a rest of any length to the first
      sample after the rest
    - turn: largest growth factor of e' P e at a forbidden transition between two moving modes
    """

    gamma: float
    radii: dict[int, float]
    switching_radius: float
    simulated_gain: float
    rest: float
    turn: float


def motion_samples(growth: float, decay: float) -> float | None:
    """Return the number of samples after which e' P e has decayed by the factor `growth`.

    `decay` is the decay factor lambda. Return None if lambda is 1, so that nothing decays.
    """
    return None if decay >= 1.0 else max(0.0, math.log(growth) / (-2.0 * math.log(decay)))


def verify(
    modes: Mapping[int, ObserverMode],
    switches: Sequence[Switch],
    gains: Mapping[int, Matrix],
    solution: SwitchedGains,
) -> ObserverVerification:
    """Verify the stored `gains` (n, m) of each mode with the Lyapunov matrices of `solution`.

    Raises NoSolutionError if a condition fails.
    """
    gamma = proved_gamma(modes, switches, gains, solution.p, solution.t, solution.decay)
    if not math.isfinite(gamma):
        raise NoSolutionError(
            "not verified: the inequalities do not hold for the stored gains; "
            "choose a --decay nearer to 1"
        )
    loops = {i: mode.a - gains[i] @ mode.c for i, mode in modes.items()}
    radii = {i: radius(loop) for i, loop in loops.items()}
    for index, value in radii.items():
        if value >= 1.0:
            raise NoSolutionError(
                f"not verified: the error in mode {index} has an eigenvalue of modulus "
                f"{value:.6g}; it must be below 1"
            )
    both = [(i, j) for i, j in switches if (j, i) in switches]
    switching = max(radius(loops[j] @ loops[i]) for i, j in both)
    if switching >= 1.0:
        raise NoSolutionError(
            "not verified: while two modes alternate, two samples multiply the error by "
            f"{switching:.6g}; the factor must be below 1"
        )
    gain = _simulated(modes, loops, _sequences(switches), solution)
    if gain > gamma * (1.0 + ROUNDING):
        raise NoSolutionError(
            f"not verified: the simulated gain from disturbance to weighted error is {gain:.6g}, "
            f"above the proved gamma {gamma:.6g}; allow a larger gamma by --quiet"
        )
    return ObserverVerification(
        gamma,
        radii,
        switching,
        gain,
        _over_rest(modes[0], gains[0], switches, solution),
        _over_turn(loops, switches, solution),
    )


def radius(matrix: Matrix) -> float:
    """Return the spectral radius of a matrix."""
    return float(np.max(np.abs(np.linalg.eigvals(matrix))))


def _sequences(switches: Sequence[Switch]) -> NDArray[np.intp]:
    allowed = set(switches)
    after = {i: sorted(j for i_, j in allowed if i_ == i) for i in sorted({i for i, _ in allowed})}
    first = np.arange(SAMPLES + 1) <= SAMPLES // 2
    rows = [
        np.where(first, i, j) for i, j in sorted(allowed) if (i, i) in allowed and (j, j) in allowed
    ]
    rows += [
        np.where(np.arange(SAMPLES + 1) % 2 == 0, i, j)
        for i, j in sorted(allowed)
        if i < j and (j, i) in allowed
    ]
    random = np.random.default_rng(SEED)
    for number in range(RANDOM_SEQUENCES):
        # every second sequence switches as often as possible
        stay = 0.0 if number % 2 else float(random.uniform(0.5, 0.99))
        now = int(random.choice(list(after)))
        row = []
        for _ in range(SAMPLES + 1):
            row.append(now)
            if not (now in after[now] and random.uniform() < stay):
                now = int(random.choice(after[now]))
        rows.append(np.array(row))
    return np.array(rows)


def _simulated(
    modes: Mapping[int, ObserverMode],
    loops: Mapping[int, Matrix],
    sequences: NDArray[np.intp],
    solution: SwitchedGains,
) -> float:
    """Return the largest gain |z|/|Delta| from model error to weighted error in `sequences`.

    Raises NoSolutionError if a sample with Delta = 0 multiplies e' P e by more than lambda^2.
    """
    numbers = sorted(modes)
    index = np.searchsorted(numbers, sequences).T  # (SAMPLES + 1, k)
    t = solution.t
    back = np.linalg.inv(t)
    a = np.array([back @ loops[i] @ t for i in numbers])
    q = np.array([back @ modes[i].q for i in numbers])
    weight = np.array([modes[i].weight @ t for i in numbers])
    p = np.array([solution.p[i] for i in numbers])
    _refuse_rising(a, p, index, solution.decay)
    random = np.random.default_rng(SEED + 1)
    shape = (len(index) - 1, index.shape[1], q.shape[2])
    gain = 0.0
    worst = random.normal(size=shape)
    for delta in (random.normal(size=shape), np.ones(shape)):
        gain = max(gain, float(np.max(_norm(_forward(a, q, weight, index, delta)) / _norm(delta))))
    for _ in range(WORST_ROUNDS):
        out = _forward(a, q, weight, index, worst)
        gain = max(gain, float(np.max(_norm(out) / np.maximum(_norm(worst), 1e-300))))
        worst = _adjoint(a, q, weight, index, out)
        worst /= np.maximum(_norm(worst), 1e-300)[None, :, None]
    return gain


def _norm(signal: Matrix) -> Matrix:
    return np.asarray(np.sqrt(np.sum(signal**2, axis=(0, 2))))


def _forward(
    a: Matrix, q: Matrix, weight: Matrix, index: NDArray[np.intp], delta: Matrix
) -> Matrix:
    """Return the weighted errors z (samples, k, p) of k sequences of modes, with e(0) = 0.

    - delta: model errors (samples, k, w)
    - a, q, weight: A - L C, Q and C-bar of each mode
    - index: mode at each sample of each sequence, (samples + 1, k)
    """
    e = np.zeros((index.shape[1], a.shape[1]))
    out = []
    for now, disturbance in zip(index[:-1], delta, strict=True):
        out.append(np.einsum("kij,kj->ki", weight[now], e))
        e = np.einsum("kij,kj->ki", a[now], e) + np.einsum("kij,kj->ki", q[now], disturbance)
    return np.array(out)


def _adjoint(a: Matrix, q: Matrix, weight: Matrix, index: NDArray[np.intp], z: Matrix) -> Matrix:
    """Apply the adjoint of `_forward` to `z` (samples, k, p); return an array (samples, k, w)."""
    s = np.zeros((index.shape[1], a.shape[1]))
    out = []
    for now, seen in zip(index[-2::-1], z[::-1], strict=True):
        out.append(np.einsum("kji,kj->ki", q[now], s))
        s = np.einsum("kji,kj->ki", a[now], s) + np.einsum("kji,kj->ki", weight[now], seen)
    return np.array(out[::-1])


def _refuse_rising(a: Matrix, p: Matrix, index: NDArray[np.intp], decay: float) -> None:
    """Raise NoSolutionError if a sample multiplies the Lyapunov function by more than decay^2.

    Each sequence of modes (column of `index`) starts from a random error.
    """
    e = np.random.default_rng(SEED + 2).normal(size=(index.shape[1], a.shape[1]))
    value = np.einsum("ki,kij,kj->k", e, p[index[0]], e)
    for now, then in itertools.pairwise(index):
        e = np.einsum("kij,kj->ki", a[now], e)
        after = np.einsum("ki,kij,kj->k", e, p[then], e)
        if np.any(after > decay**2 * value * (1.0 + ROUNDING)):
            raise NoSolutionError(
                "not verified: in simulation a sample multiplies the error's Lyapunov function by "
                f"more than the proved factor, {decay**2:.6g}; choose a --decay nearer to 1"
            )
        value = np.where(after > 1e-200, after, 0.0)
        e = np.where(after[:, None] > 1e-200, e, 0.0)


def _over_rest(
    mode: ObserverMode, gains: Matrix, switches: Sequence[Switch], solution: SwitchedGains
) -> float:
    """Return the largest growth of the Lyapunov function over a rest.

    The growth is from the start of the rest to the first sample after the rest. The wear estimate
    is constant during a rest. Raises NoSolutionError if the errors of position and speed do not
    decay in a rest.
    """
    resting = mode.a - gains[:, :1] @ mode.c[:1]
    resting[2] = (0.0, 0.0, 1.0)
    if radius(resting[:2, :2]) >= 1.0:
        raise NoSolutionError(
            "not verified: in mode 0 (stuck), the errors of position and speed have an eigenvalue "
            f"of modulus {radius(resting[:2, :2]):.6g}; allowed: below 1"
        )
    t = solution.t
    step = np.linalg.solve(t, resting @ t)
    root = np.linalg.inv(np.linalg.cholesky(solution.p[0])).T  # transforms P_0 to the identity
    moves = [solution.p[j] for i, j in switches if i == 0 and j != 0]
    worst = 1.0
    length = 1
    over = step @ root
    while length <= LONGEST_REST:
        worst = max(worst, *(float(np.linalg.eigvalsh(over.T @ p @ over)[-1]) for p in moves))
        over = step @ over
        length = length + 1
        if np.max(np.abs(step @ over - over)) <= 1e-12 * np.max(np.abs(over)):
            break
    return worst


def _over_turn(
    loops: Mapping[int, Matrix], switches: Sequence[Switch], solution: SwitchedGains
) -> float:
    """Return the largest growth of e' P e at a forbidden transition between two moving modes."""
    posed = {
        i: np.linalg.solve(solution.t, loop @ solution.t)
        @ np.linalg.inv(np.linalg.cholesky(solution.p[i])).T
        for i, loop in loops.items()
    }
    allowed = set(switches)
    moving = [i for i in loops if i]
    steps = [(posed[i], solution.p[j]) for i in moving for j in moving if (i, j) not in allowed]
    return max([1.0, *(float(np.linalg.eigvalsh(step.T @ p @ step)[-1]) for step, p in steps)])
