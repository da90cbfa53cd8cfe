"""Estimation of backlash, delay between channels, current-loop lag and winding of the bench."""
