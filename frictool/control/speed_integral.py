"""What the speed controller is given, eta = integral(omega_c) - position, and its hold while the drive is limited.

Both integrals advance by their difference, so that no number grows with the distance travelled. While the last drive was limited
and eta would move further into that limit, eta is held (conditional integration). A positive eta asks for a positive drive: that
is the sign convention of `controller.yaml`.
"""

from __future__ import annotations

from frictool.kernels import kernel


@kernel
def next_eta(eta: float, increment: float, motion: float, limited: float) -> float:
    """eta [rad | m] at this sample.

    increment: T omega_c; motion: the position's difference since the last sample; limited: -1, 0, +1, the limit that the last drive met.
    """
    change = increment - motion
    return eta if limited * change > 0.0 else eta + change
