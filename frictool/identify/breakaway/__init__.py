"""Breakaway from ramps, as a function of position or time at rest; friction map (thesis 4.3)."""
