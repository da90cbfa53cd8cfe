"""Short descriptions of the control blocks' states, for comments in the exported struct."""

from __future__ import annotations

MEANINGS = {
    "reference_before": "last valid reference",
    "velocity_before": "last valid speed of the sensor",
    "holds_left": "invalid samples still allowed before the fault; -1: fault",
    "filtered_before": "reference after the prefilter",
    "filtered_speed_before": "derivative of the filtered reference",
    "filtered_line": "earlier filtered references, the latest first",
    "tracked_before": "reference that the loop tracked at the last sample",
    "profile_distance": "distance from the unsmoothed profile to the reference",
    "profile_speeds": "speeds of the unsmoothed profile, the latest first",
    "reference_lag": "reference minus filtered reference",
    "reference_speed": "speed of the filtered reference",
    "reference_acceleration": "acceleration of the filtered reference",
    "friction_direction": "sign of the Coulomb friction in the feedforward: -1, 0, +1",
    "position_before": "last valid position",
    "difference_before": "last difference quotient of the position",
    "speed_before": "measured speed, filtered",
    "difference_before_raw": "last difference quotient of the position",
    "speed_before_raw": "measured speed after the first of two filters",
    "mode": "state of the band: RUN, BRAKE or REST",
    "eta_before": "integral(speed reference) - position",
    "limited_before": "limit that the last drive met: -1, 0, +1",
    "observed": "state of the disturbance observer",
    "tracked_position": "position of the tracking observer, in the encoder's readings",
    "tracked_velocity": "speed of the tracking observer",
    "disturbance": "estimated disturbance",
    "tracked_gap": "position of the observer's motor within the backlash",
    "estimated_position": "position of the switched observer",
    "estimated_velocity": "speed of the switched observer",
    "estimated_wear": "friction relative to the model's friction, or increase of the friction",
    "commanded": "drives that act after the delay, the oldest first",
    "drive_before": "drive after the lag of its loop, at the last sample",
    "x": "state of the linear controller",
    "s": "states of the sections, two per section",
}


def state_meaning(state: str, constant: bool) -> str:
    """Return the description of a state.

    `constant`: True if the program never changes the state.
    """
    return "scheduled parameter, set by the caller" if constant else MEANINGS.get(state, "")
