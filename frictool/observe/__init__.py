"""Velocity, friction and wear from a running actuator: observers designed, and logs that they run along."""
