"""Explicit controllers that depend on r but not on its rates, for constant X and variable Y(r).

r is the vector of scheduled parameters. With M = I and N(r) = I - Y(r) X in thesis (5.63), the map
from the closed loop's inequality to (5.62) is constant. The rates of r then occur only in dY/dt, in
the second diagonal block of (5.62); Apkarian and Adams (1998) call these controllers practically
valid. The controller's direct term D is any matrix with |D11 + D12 D D21| < gamma. Its other
matrices follow by (5.63) from A^, B^ and C^. W is the lower right block of (5.62), which a Schur
complement removes, and [L1 L2] the row to the left of W. ' is the transpose.
With V = -W^-1, E = [0; D12] and F = [D21'; 0]:

    A^ = -A' - C2' D' B2' + L2' W^-1 L1        makes the remaining off-diagonal block zero; two
                                               inequalities remain, one in C^ and one in B^
    C^ = -(E' V E + e I)^-1 (B2' + E' V L1)    minimises the left side of the inequality in C^
    B^' = -(F' V F + e I)^-1 (C2 + F' V L2)    minimises the left side of the inequality in B^,
                                               for every rate

In the last two formulas, L1 is evaluated for C^ = 0, and L2 is evaluated for B^ = 0. e > 0 is a
small regularising weight, needed if D12 or D21 does not have full rank. If both have full rank, the
code first tries e = 0. If the inequalities then fail at a point, or a matrix does not have full
rank, the code uses the largest tried e for which both inequalities hold at every point. A smaller e
does not improve the guaranteed gamma, and gives the controller faster poles.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy

from frictool.errors import NoSolutionError
from frictool.lmi.grid_inequalities import Values
from frictool.lmi.gridded_synthesis import GriddedSolution
from frictool.lmi.parrott_reconstruction import parrott
from frictool.plant.generalised_plant import GeneralisedPlant
from frictool.plant.lti import Lti
from frictool.typing import Matrix

# tried values of e in balanced coordinates; 0 only if D12 and D21 have full rank
WEIGHTS = (0.0, *np.geomspace(1.0, 1e-10, 21).tolist())
FULL = 1e-6  # smallest singular value of D12 and D21 with full rank, relative to gamma


def scheduled_controllers(
    solution: GriddedSolution, points: Sequence[Values], plants: Sequence[GeneralisedPlant]
) -> tuple[Lti, ...]:
    """Return one controller for each pair of a point (values of r) and the plant at this point.

    The norm of the scheduled loop is at most `solution.gamma` while the parameters vary no faster
    than the solution's rates. Raises ValueError for sampled plants and if X is not constant. Raises
    NoSolutionError if, to working precision, the inequalities admit no controller at some point.
    """
    if solution.frame.disc or solution.bases[0].degree:
        raise ValueError(
            "scheduled controllers need continuous plants and a constant Lyapunov matrix X "
            "(basis of degree 0)"
        )
    cells = [
        _ScheduledPlant(solution, values, solution.frame.plant(plant).transformed(solution.t))
        for values, plant in zip(points, plants, strict=True)
    ]
    full = min(cell.rank for cell in cells) > FULL * solution.gamma
    for small in WEIGHTS if full else WEIGHTS[1:]:
        if all(cell.holds(small) for cell in cells):
            return tuple(solution.frame.back(cell.controller(small), 0.0) for cell in cells)
    raise NoSolutionError(
        "no scheduled controller meets the bound at every point to working precision; raise "
        "`recentring`"
    )


class _ScheduledPlant:
    def __init__(self, solution: GriddedSolution, values: Values, plant: GeneralisedPlant) -> None:
        self.plant = plant
        self.gamma = solution.gamma
        self.x = solution.x[0]
        self.y = np.tensordot(solution.bases[1].at(values), solution.y, 1)
        self.drifts = [
            np.tensordot(solution.bases[1].along(values, motion), solution.y, 1)
            for motion in solution.motions
        ]
        p = plant
        root = 1.0 / solution.gamma
        self.rank = min(np.linalg.norm(p.d12, -2), np.linalg.norm(p.d21.T, -2))
        inside = np.linalg.norm(p.d11, 2) < solution.gamma
        self.d = (
            np.zeros((p.b2.shape[1], len(p.c2)))
            if inside
            else parrott(root * p.d11, root * p.d12, p.d21)
        )
        through = p.d11 + p.d12 @ self.d @ p.d21
        w = p.b1.shape[1]
        z = len(p.c1)
        self.v = np.linalg.inv(
            np.block(
                [[solution.gamma * np.eye(w), -through.T], [-through, solution.gamma * np.eye(z)]]
            )
        )
        self.e = np.vstack([np.zeros((w, p.d12.shape[1])), p.d12])
        self.f = np.vstack([p.d21.T, np.zeros((z, len(p.c2)))])
        self.a, self.b, self.c = (
            p.a + p.b2 @ self.d @ p.c2,
            p.b1 + p.b2 @ self.d @ p.d21,
            p.c1 + p.d12 @ self.d @ p.c2,
        )

    def hats(self, small: float) -> tuple[Matrix, Matrix, Matrix, Matrix]:
        p = self.plant
        e = self.e
        f = self.f
        v = self.v
        first = np.vstack([self.b.T, p.c1 @ self.x])
        second = np.vstack([p.b1.T @ self.y, self.c])
        c = -np.linalg.solve(e.T @ v @ e + small * np.eye(e.shape[1]), p.b2.T + e.T @ v @ first)
        b = -np.linalg.solve(f.T @ v @ f + small * np.eye(f.shape[1]), p.c2 + f.T @ v @ second).T
        return np.asarray(c), np.asarray(b), np.asarray(first + e @ c), np.asarray(second + f @ b.T)

    def holds(self, small: float) -> bool:
        """Return True if the inequalities in C^ and B^ hold for the regularising weight `small`."""
        p = self.plant
        c, b, first, second = self.hats(small)
        flow_x = p.a @ self.x + p.b2 @ c
        flow_y = self.y @ p.a + b @ p.c2
        one = flow_x + flow_x.T + first.T @ self.v @ first
        two = flow_y + flow_y.T + second.T @ self.v @ second
        return bool(
            np.linalg.eigvalsh(one)[-1] < 0.0
            and all(np.linalg.eigvalsh(two + drift)[-1] < 0.0 for drift in self.drifts)
        )

    def controller(self, small: float) -> Lti:
        p, x, y = self.plant, self.x, self.y
        c, b, first, second = self.hats(small)
        a = -self.a.T - second.T @ self.v @ first
        n = np.eye(len(x)) - y @ x
        found_c = c - self.d @ p.c2 @ x
        found_b = np.linalg.solve(n, b - y @ p.b2 @ self.d)
        found_a = np.linalg.solve(
            n, a - y @ self.a @ x - n @ found_b @ p.c2 @ x - y @ p.b2 @ found_c
        )
        return Lti(found_a, found_b, found_c, self.d, 0.0)


def lyapunov(solution: GriddedSolution, values: Values) -> Matrix:
    """Return the Lyapunov matrix P(r) of the loop with a scheduled controller, at r = `values`.

    P solves P [X I; I 0] = [I Y; 0 N'], with X and Y of the solution and N' = I - X Y.
    """
    back = scipy.linalg.block_diag(np.linalg.inv(solution.t), np.eye(len(solution.t)))
    return np.asarray(back.T @ _balanced(solution, values) @ back)


def _balanced(solution: GriddedSolution, values: Values) -> Matrix:
    x = solution.x[0]
    y = np.tensordot(solution.bases[1].at(values), solution.y, 1)
    identity = np.eye(len(solution.t))
    first = np.block([[x, identity], [identity, np.zeros_like(x)]])
    second = np.block([[identity, y], [np.zeros_like(x), identity - x @ y]])
    p = second @ np.linalg.inv(first)
    return np.asarray(0.5 * (p + p.T))


def certified_gamma(
    solution: GriddedSolution, values: Values, plant: GeneralisedPlant, controller: Lti
) -> float:
    """Return the smallest norm bound gamma that P(r) of `lyapunov` proves at r = `values`.

    The result is inf if P(r) proves no bound. The proof is valid for all allowed rates of the
    parameters. The controller must have the state coordinates of the scheduled controllers. It may
    be a barycentric sum of the scheduled controllers (5.64), for which the synthesis alone
    guarantees nothing.
    """
    states = scipy.linalg.block_diag(solution.t, np.eye(controller.order))
    loop = plant.closed(controller).transformed(states)
    unit = solution.frame.scale
    p = _balanced(solution, values)
    still = np.zeros((controller.order,) * 2)
    if np.linalg.eigvalsh(p)[0] <= 0.0:
        return np.inf
    w = loop.b.shape[1]
    z = len(loop.c)
    flow = unit * p @ loop.a
    cross = np.sqrt(unit) * np.vstack([loop.b.T @ p, loop.c])
    rest = np.block([[np.zeros((w, w)), loop.d.T], [loop.d, np.zeros((z, z))]])
    worst = 0.0
    for motion in solution.motions:
        drift = np.tensordot(solution.bases[1].along(values, motion), solution.y, 1)
        decrease = -(flow + flow.T + _carried(solution, drift, still))
        if np.linalg.eigvalsh(decrease)[0] <= 0.0:
            return np.inf
        worst = max(
            worst, float(np.linalg.eigvalsh(rest + cross @ np.linalg.solve(decrease, cross.T))[-1])
        )
    return worst


def _carried(solution: GriddedSolution, drift: Matrix, still: Matrix) -> Matrix:
    """Return the time derivative of the Lyapunov matrix P(r) of `lyapunov`.

    X is constant. The derivative is therefore T^-T diag(0, dY/dt) T^-1, with T = [X I; I 0].

    - drift: dY/dt
    - still: zero matrix of the size of Y
    """
    x = solution.x[0]
    identity = np.eye(len(drift))
    inverse = np.linalg.inv(np.block([[x, identity], [identity, still]]))
    return np.asarray(inverse.T @ scipy.linalg.block_diag(still, drift) @ inverse)
