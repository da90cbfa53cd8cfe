"""The square-root position law (5.19), (5.71), annex (5): the speed from which Coulomb friction alone stops the axis at its target.

    omega_c = k sqrt(|e|) sign(e)        k = sqrt(2 F_c/J); with virtual friction k > sqrt(2 F_c/J) (5.42)

Braked by friction alone, J omega' = -F_c, the axis that follows the law arrives with speed 0 at e = 0 (5.5). The band around the
target, where the law gives way to rest, is in `band`. The larger k, the faster the response and the more the drive has to brake
with; a k above the friction's own value is what `virtual_coulomb_factor` asks for.
"""

from __future__ import annotations

import math

from frictool.kernels import kernel


@kernel
def speed_reference(gain: float, error: float) -> float:
    """omega_c [rad/s | m/s] for a position error [rad | m]; odd, continuous, steep at zero."""
    return gain * math.sqrt(error) if error >= 0.0 else -(gain * math.sqrt(-error))
