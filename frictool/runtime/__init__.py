"""Kernels and their cache, notifications, partial files and lazy exports: what every package runs
on."""
