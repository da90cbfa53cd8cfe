"""Breakaway from ramps: over position and time at rest, and the friction map (4.3, 4.40-4.44)."""
