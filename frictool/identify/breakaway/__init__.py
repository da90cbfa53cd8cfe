"""Breakaway from ramps, over position and time at rest; friction map (4.3, 4.40-4.44)."""
