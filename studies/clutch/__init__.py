"""Experiments on the clutch of configs/clutch, which its Makefile runs."""
