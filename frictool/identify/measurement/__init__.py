"""Estimate backlash, delay between channels and current-loop lag of the bench from logs."""
