"""Kernels of what runs along a log."""
