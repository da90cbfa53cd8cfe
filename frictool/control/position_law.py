"""The square-root position law (5.19), (5.71), annex (5): the speed from which Coulomb friction alone stops the axis at its target.

    omega_c = k sqrt(|e|) sign(e)   outside the band        k = sqrt(2 F_c/J); with virtual friction k > sqrt(2 F_c/J) (5.42)
            = k e/sqrt(band)        inside, its linear continuation

Braked by friction alone, J omega' = -F_c, the axis that follows the law arrives with speed 0 at e = 0 (5.5). The band around the
target, where the law gives way to rest, is in `band`. The larger k, the faster the response and the more the drive has to brake
with; a k above the friction's own value is what `virtual_coulomb_factor` asks for. The text has 0 inside the band (5.19); here the law
is followed there too until the prefilter has settled and the band acts, linearly, since the root's infinite slope at zero would turn
each encoder count into a jump of the speed reference.
"""

from __future__ import annotations

import math

from frictool.kernels import kernel


@kernel
def speed_reference(gain: float, slope: float, band: float, error: float) -> float:
    """omega_c [rad/s | m/s] for a position error [rad | m]; odd, continuous. `slope` = gain/sqrt(band)."""
    if error > band:
        return gain * math.sqrt(error)
    if error < -band:
        return -(gain * math.sqrt(-error))
    return slope * error
