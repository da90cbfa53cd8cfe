"""Experiments on the clutch; the Makefile of configs/clutch runs them."""
