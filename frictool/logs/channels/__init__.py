"""Mapping of the columns of a raw log file to channels in SI."""
