"""Tests to run on a bench: one kind a file, each a function of what the bench can do; and what a test would tell (information.py)."""
