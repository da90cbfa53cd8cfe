"""The band around the target, inside which the drive ends at zero: no limit cycle can start where nothing drives (5.2.2, 5.2.3).

====  =====  =======================================================================================================
code  mode   what runs
====  =====  =======================================================================================================
0     RUN    the position law gives the speed reference, the speed loop is closed
1     BRAKE  the speed reference is 0, the speed loop is closed
2     REST   the drive is 0, the speed loop is open and reset
====  =====  =======================================================================================================

The band acts where |e| <= band and the prefilter has settled, |f'| < settled_speed: with the error alone the axis would be dropped
in the middle of a move, whenever it happens to follow the filtered reference closely. `cut` goes to REST at once, `brake` first
brings the measured speed below `rest_speed`. Leaving the band, or a moving prefilter, is RUN again.

What holds of it is boundedness and rest; the decrease of (5.12) has no sign and proves no stability.
"""

from __future__ import annotations

from frictool.kernels import kernel

RUN, BRAKE, REST = 0.0, 1.0, 2.0


@kernel
def next_mode(
    mode: float, brakes: bool, band: float, settled_speed: float, rest_speed: float, error: float, reference_speed: float, speed: float
) -> float:
    """The mode at this sample; lengths in rad | m, speeds per s. `speed` is the measured one, of which only braking makes use."""
    if not (abs(error) <= band and abs(reference_speed) < settled_speed):
        return RUN
    if not brakes or mode == REST or abs(speed) < rest_speed:
        return REST
    return BRAKE
