"""Measurement of backlash, delay between channels, current-loop lag and motor winding."""
