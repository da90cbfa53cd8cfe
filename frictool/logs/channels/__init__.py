"""Mapping of the columns of a bench file to channels in SI."""
