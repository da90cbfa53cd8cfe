"""Estimation of wear from an actuator's ordinary moves, by the equation of motion in weak form."""
