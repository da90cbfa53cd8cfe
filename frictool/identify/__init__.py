"""Logs to parameters with intervals, one method per file."""
