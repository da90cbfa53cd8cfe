"""Kernels of the estimators that process a log sample by sample."""
