"""Conversion of a mechanism document to arrays (plant/mechanism/packed_mechanism.py)."""
