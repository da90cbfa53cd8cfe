"""Measurement of backlash, delay between channels, current-loop lag, winding and ringing."""
