"""State-variable filter for the speed and the acceleration of an external reference.

    f' = v,   v' = a,   a' = j = w^3 (r - f) - 3 w^2 v - 3 w a         r/(1 + s/w)^3

r is the reference, f the filtered reference with the speed v and the acceleration a, and w the
bandwidth. The states are d = r - f, v and a, sampled by Tustin's rule, so that they are exactly 0
at rest. The filter lags by 3/w. This lag is corrected, and the speed and the acceleration of the
reference are predicted for a time `ahead` [s] after the sample:

    speed = v + c1 a + c2 j,   acceleration = a + c1 j
    c1 = 3/w + ahead,   c2 = 3/w^2 + 3 ahead/w + ahead^2/2

c1 and c2 are coefficients of the series (1 + s/w)^3 exp(s ahead) = 1 + c1 s + c2 s^2 + ...

Property: the result is exact for a reference with constant jerk. A reference that changes by one
count disturbs the predicted acceleration by up to (3 + w ahead) w^2 counts per s^2. A coarse
reference therefore needs a low w. Source of the filter: Young, Automatica 17 (1981) 23-39.
"""

from __future__ import annotations

import numpy as np

from frictool.control.difference_equation import impulse_sums
from frictool.control.program import Program, ProgramNode


def reference_derivatives(
    program: Program, reference: ProgramNode, bandwidth: float, ahead: float, period: float
) -> tuple[ProgramNode, ProgramNode]:
    """Return speed and acceleration of the reference, predicted `ahead` [s] after the sample.

    - bandwidth: bandwidth of the filter [rad/s]
    - period: sample period [s]
    """
    program.block("speed and acceleration of the reference: state-variable filter, by Tustin")
    w = bandwidth
    a = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [w**3, -3.0 * w**2, -3.0 * w]])
    left = np.eye(3) - 0.5 * period * a
    transition = np.linalg.solve(left, np.eye(3) + 0.5 * period * a)
    entry = np.linalg.solve(left, np.array([1.0, 0.0, 0.0]))
    scales = np.array([1.0, w, w * w])
    scaled = transition * scales / scales[:, None]
    reach = (reference.high - reference.low) * scales * impulse_sums(scaled, entry / scales)
    last = program.last("reference", reference, "position")
    names = ("reference_lag", "reference_speed", "reference_acceleration")
    before = [
        program.state(name, -float(bound), float(bound))
        for name, bound in zip(names, reach, strict=True)
    ]
    change = reference - last
    now = []
    for i, name in enumerate(names):
        coefficients = [
            program.constant(float(value), f"derivatives[{i}][{k}]")
            for k, value in enumerate([entry[i], *transition[i]])
        ]
        now.append(program.named(f"{name}_now", program.dot(coefficients, [change, *before])))
        program.update(name, now[i])
    first = 3.0 / w + ahead
    second = 3.0 / w**2 + 3.0 * ahead / w + 0.5 * ahead**2
    third = [w**3, -3.0 * w**2, -3.0 * w]  # coefficients of the jerk a'
    speed = program.dot(
        [
            program.constant(float(value), f"speed_ahead[{k}]")
            for k, value in enumerate(np.array([0.0, 1.0, first]) + second * np.array(third))
        ],
        now,
    )
    acceleration = program.dot(
        [
            program.constant(float(value), f"acceleration_ahead[{k}]")
            for k, value in enumerate(np.array([0.0, 0.0, 1.0]) + first * np.array(third))
        ],
        now,
    )
    return speed, acceleration
