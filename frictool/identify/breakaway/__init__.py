"""Breakaway from ramps, over position and time at rest; friction map (thesis 4.3)."""
