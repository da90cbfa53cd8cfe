"""Kernels of the estimators that run along a log."""
